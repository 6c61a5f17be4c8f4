"""Time of a query in a gallery as large as all of Yale B, filled up with mirrored and synthetic people."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from harmonicface import _validate
from harmonicface.appearance.render import render
from harmonicface.appearance.sensor import photograph
from harmonicface.bench import timing
from harmonicface.bench.contenders import Person
from harmonicface.bench.degradation import Picture
from harmonicface.bench.peers import stopwatch_of
from harmonicface.bench.yale_b import Progress, learned
from harmonicface.bench.yale_contenders import NEEDING_DEPTH, YALE_METHODS, yale_contender
from harmonicface.datasets.yale_b import YalePerson
from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting import lights
from harmonicface.people.synthetic import synthetic_people

EVERYBODY = 38  # people of the Extended Yale B
QUERIES = 12
MIRRORED = np.array([-1.0, 1.0, 1.0])  # left and right change places


@dataclass(frozen=True)
class Timing:
    """How long one method takes: people in the gallery, milliseconds a query, seconds to enrol all, bytes a person.

    `query` is the time of a query under the name of what was called.
    """

    method: str
    people: int
    milliseconds: float
    enrolment_seconds: float
    bytes_per_person: float
    query: timing.Timing = timing.UNTIMED


def query_times(
    faces: Sequence[YalePerson],
    methods: Sequence[str] = YALE_METHODS,
    count: int = EVERYBODY,
    queries: int = QUERIES,
    progress: Progress | None = None,
) -> list[Timing]:
    """Time methods in a gallery filled up to `count` people, all enrolled from their photographs in subset 1.

    Photographs of subset 1 alone are learned from, so a method that needs nine lights is left out.

    Parameters
    ----------
    faces
        People of the data set.
    methods
        Names of methods.
    count
        People in the gallery, at least as many as faces.
    queries
        Photographs of subsets 2 to 5 that are timed.
    progress
        Called as work goes on.

    Raises
    ------
    HarmonicFaceError
        More faces than people wanted, nobody, an unknown method.
    """
    if not 1 <= len(faces) <= count:
        raise HarmonicFaceError(f"people: expected 1 to {count}, got {len(faces)}")
    tell = progress or (lambda *_: None)
    asked = [face.photographs[place] for face in faces for place in np.flatnonzero(face.subsets > 1)]
    spread = np.linspace(0, len(asked) - 1, min(_validate.at_least(queries, 1, "queries"), len(asked))).astype(int)
    photos = [asked[place] for place in spread]
    people = {deep: filled_up(faces, count, deep) for deep in {name in NEEDING_DEPTH for name in methods}}
    found = []
    for done, name in enumerate(methods):
        tell("times", done, len(methods))
        timing = _timed(name, people[name in NEEDING_DEPTH], photos)
        found += [] if timing is None else [timing]
    tell("times", len(methods), len(methods))
    return found


def filled_up(faces: Sequence[YalePerson], count: int, depth: bool = False) -> list[Person]:
    """Return people with their photographs of subset 1: the faces, their mirror images, then synthetic people.

    Parameters
    ----------
    faces
        At least one.
    count
        How many people are wanted.
    depth
        Whether their Surfaces have depth.
    """
    people: list[Person] = []
    for mirrored in (False, True):
        for face in faces[: count - len(people)]:
            chosen = face.subsets == 1
            photographs, towards = face.photographs[chosen], face.lights[chosen]
            if mirrored:
                photographs, towards = np.ascontiguousarray(photographs[:, :, ::-1]), towards * MIRRORED
            name = f"{'mirrored ' if mirrored else ''}{face.number}"
            people.append(learned(name, photographs, towards, depth))
    towards = faces[0].lights[faces[0].subsets == 1]
    height, width = faces[0].photographs.shape[1:]
    for number, surface in enumerate(synthetic_people(count - len(people), (height, width), seed=0)):
        shots = [photograph(render(surface, lights.directional(lamp)), number) for lamp in towards]
        people.append(learned(f"synthetic {number}", np.stack(shots), towards, depth))
    return people


def _timed(name: str, people: Sequence[Person], photos: Sequence[Picture]) -> Timing | None:
    """Enrol everybody and ask; None if the method cannot learn from these photographs."""
    method = yale_contender(name)
    start = time.perf_counter()
    try:
        method.enroll(people)
    except HarmonicFaceError:
        return None
    enrolment = time.perf_counter() - start
    watch = stopwatch_of(name, method)
    for photo in (photos[0], *photos):
        watch.run(partial(method.nearest, photo))
    query = watch.timing(lambda seconds: np.median(seconds[1:]))
    return Timing(name, len(people), 1e3 * query.seconds, enrolment, method.bytes_per_person, query)
