"""Curves: how often photographs are given to the wrong person as they get worse, method by method."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface.bench.contenders import Contender, Person
from harmonicface.bench.degradation import Picture
from harmonicface.bench.ordeals import ENROLMENT, ORDEALS, Ordeal, reduced_photo
from harmonicface.bench.peers import stopwatch_of
from harmonicface.bench.timing import UNTIMED, Timing
from harmonicface.bench.yale_b import Progress, learned
from harmonicface.bench.yale_contenders import yale_contender
from harmonicface.bench.yale_protocols import CHOSEN_ON
from harmonicface.datasets.yale_b import YalePerson
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.intervals import Rate, rate

CURVE_METHODS = ("default", "harmonic9", "lbph", "tan_triggs")
LEARNED_SUBSET = 1


@dataclass(frozen=True)
class CurvePoint:
    """One method at one level.

    Parameters
    ----------
    ordeal, level, method
        What was done, how much, to whom.
    wrong, asked
        Of everybody.
    wrong_unseen, asked_unseen
        Of people on whom no setting was chosen.
    milliseconds
        Median time of a query.
    timing
        The same, under the name of what was called.
    """

    ordeal: str
    level: float
    method: str
    wrong: int
    asked: int
    wrong_unseen: int
    asked_unseen: int
    milliseconds: float
    timing: Timing = UNTIMED

    @property
    def error(self) -> Rate:
        """The error over everybody."""
        return rate(self.wrong, self.asked)

    @property
    def error_unseen(self) -> Rate | None:
        """The error over people on whom no setting was chosen; None if there are none."""
        return rate(self.wrong_unseen, self.asked_unseen) if self.asked_unseen else None


@dataclass(frozen=True, eq=False)
class _Question:
    """A photograph of the data set: index and number of the person, and which of hers."""

    index: int
    number: int
    place: int
    photo: Picture


def error_curves(
    faces: Sequence[YalePerson],
    methods: Sequence[str] = CURVE_METHODS,
    queries: int = 1000,
    every: int = 1,
    progress: Progress | None = None,
) -> list[CurvePoint]:
    """Ask for people in photographs that get worse.

    Everybody is enrolled from her photographs in subset 1 at 84 x 96 pixels and asked for in subsets 2 to 5. What is
    done to a photograph is done at the data set's size, before it is reduced; the enrolled ones stay as they are. Where
    fewer are enrolled, the most frontal light comes first, then each time the one farthest from those before.

    Parameters
    ----------
    faces
        At least two people.
    methods
        Names of methods. One that cannot learn from so few photographs has no point there.
    queries
        Of each person at most so many, spread over subsets 2 to 5.
    every
        Only every so many levels, and the last.
    progress
        Called as work goes on.

    Raises
    ------
    HarmonicFaceError
        Fewer than two people, an unknown method, less than 1 query or level, somebody without photographs in
        subset 1 or beyond it.

    Examples
    --------
    With the data set in the folder CroppedYale::

        points = error_curves(load_yale_b("CroppedYale"), ["default", "lbph"], queries=8)
    """
    if len(faces) < 2:
        raise HarmonicFaceError(f"people: expected at least two to tell apart, got {len(faces)}")
    tell = progress or (lambda *_: None)
    asked = _questions(faces, _validate.at_least(queries, 1, "queries"))
    every = _validate.at_least(every, 1, "every")
    everybody = _learned(faces, None)
    contenders = {name: _enrolled(name, everybody) for name in methods}
    calm = [reduced_photo(question.photo) for question in asked]
    still = {
        name: _point("", 0, name, method, asked, calm) for name, method in contenders.items() if method is not None
    }
    points: list[CurvePoint] = []
    for ordeal in ORDEALS:
        levels = chosen_levels(ordeal, every)
        for done, level in enumerate(levels):
            tell(ordeal.name, done, len(levels))
            if level == ordeal.still:  # the same photographs for every ordeal
                points += [replace(point, ordeal=ordeal.name, level=level) for point in still.values()]
                continue
            photos = [ordeal.apply(q.photo, level, (q.number, q.place)) for q in asked]
            for name, method in contenders.items():
                points += [] if method is None else [_point(ordeal.name, level, name, method, asked, photos)]
        tell(ordeal.name, len(levels), len(levels))
    return points + list(_by_enrolment(faces, methods, asked, chosen_levels(ENROLMENT, every), tell))


def chosen_levels(ordeal: Ordeal, every: int) -> list[float]:
    """Return every so many levels of an ordeal, with the last and the one at which nothing happens.

    Examples
    --------
    >>> chosen_levels(ENROLMENT, 4)
    [1, 5, 7]
    """
    return [
        level
        for place, level in enumerate(ordeal.levels)
        if place % every == 0 or level == ordeal.still or place == len(ordeal.levels) - 1
    ]


def lost_points(points: Sequence[CurvePoint], method: str) -> list[tuple[CurvePoint, CurvePoint]]:
    """Return where another method gives fewer photographs to the wrong person: ours, and the best of the others.

    Examples
    --------
    >>> ours = CurvePoint("blur", 1, "default", 2, 9, 0, 0, 1.0)
    >>> other = CurvePoint("blur", 1, "lbph", 1, 9, 0, 0, 1.0)
    >>> [best.method for _, best in lost_points([ours, other], "default")]
    ['lbph']
    """
    found = []
    for ours in (point for point in points if point.method == method):
        here = [point for point in points if (point.ordeal, point.level) == (ours.ordeal, ours.level)]
        best = min(here, key=lambda point: point.wrong)
        found += [(ours, best)] if best.wrong < ours.wrong else []
    return found


def spread_lights(lights: NDArray[np.float64]) -> list[int]:
    """Return lights (n, 3) in an order: the most frontal first, then each time the farthest from those before.

    Examples
    --------
    >>> spread_lights(np.array([[0.1, 0.0, 1.0], [0.0, 0.0, 1.0], [0.3, 0.0, 0.9]]))
    [1, 2, 0]
    """
    unit = lights / np.linalg.norm(lights, axis=1, keepdims=True)
    order = [int(unit[:, 2].argmax())]
    while len(order) < len(unit):
        nearest = (unit @ unit[order].T).max(axis=1)
        nearest[order] = np.inf
        order.append(int(nearest.argmin()))
    return order


def _by_enrolment(
    faces: Sequence[YalePerson],
    methods: Sequence[str],
    asked: Sequence[_Question],
    levels: Sequence[float],
    tell: Progress,
) -> Iterator[CurvePoint]:
    """Return points by the number of enrolled photographs."""
    photos = [reduced_photo(question.photo) for question in asked]
    for done, level in enumerate(levels):
        tell(ENROLMENT.name, done, len(levels))
        people = _learned(faces, int(level))
        for name in methods:
            method = _enrolled(name, people)
            if method is not None:
                yield _point(ENROLMENT.name, level, name, method, asked, photos)
    tell(ENROLMENT.name, len(levels), len(levels))


def _point(
    ordeal: str,
    level: float,
    name: str,
    method: Contender,
    asked: Sequence[_Question],
    photos: Sequence[Picture],
) -> CurvePoint:
    """Ask one method for all photographs."""
    wrong, unseen, watch = [], [], stopwatch_of(name, method)
    for question, photo in zip(asked, photos, strict=True):
        wrong.append(watch.run(partial(method.nearest, photo)) != question.index)
        unseen.append(question.number not in CHOSEN_ON)
    missed, judging = np.array(wrong), np.array(unseen)
    timing = watch.timing()
    counts = int(missed.sum()), len(missed), int(missed[judging].sum()), int(judging.sum())
    return CurvePoint(ordeal, level, name, *counts, 1e3 * timing.seconds, timing)


def _questions(faces: Sequence[YalePerson], most: int) -> list[_Question]:
    """Return photographs beyond subset 1, of each person at most so many, spread evenly."""
    found = []
    for index, face in enumerate(faces):
        places = np.flatnonzero(face.subsets > LEARNED_SUBSET)
        places = places[np.argsort(face.angles[places], kind="stable")]
        if not len(places):
            raise HarmonicFaceError(f"yaleB{face.number:02d}: expected photographs beyond subset 1, got none")
        spread = places[np.linspace(0, len(places) - 1, min(most, len(places))).round().astype(int)]
        found += [_Question(index, face.number, int(place), face.photographs[place]) for place in spread]
    return found


def _learned(faces: Sequence[YalePerson], most: int | None) -> list[Person]:
    """Return people with some of their photographs of subset 1, and their Surfaces."""
    people = []
    for face in faces:
        places = np.flatnonzero(face.subsets == LEARNED_SUBSET)
        if not len(places):
            raise HarmonicFaceError(f"yaleB{face.number:02d}: expected photographs in subset 1, got none")
        places = places[spread_lights(face.lights[places])[:most]]
        photographs = np.stack([reduced_photo(face.photographs[place]) for place in places])
        people.append(learned(f"yaleB{face.number:02d}", photographs, face.lights[places]))
    return people


def _enrolled(name: str, people: Sequence[Person]) -> Contender | None:
    """Return a method that has learned everybody; None if it cannot learn from these photographs."""
    method = yale_contender(name)
    try:
        method.enroll(people)
    except HarmonicFaceError:
        return None
    return method
