"""Calibration: the threshold of a gallery from searches by people who are not in it, at a rate of false alarms."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.enrolled.enrolment import WITH_GEOMETRY
from harmonicface.lighting.lights import directional
from harmonicface.recognition.intervals import Rate, rate
from harmonicface.recognition.strangers import Strangers

if TYPE_CHECKING:
    from harmonicface.gallery.gallery import Gallery

FEWEST_PEOPLE = 3  # one to be left out, and two to stay
MOST_SEARCHES = 400  # more people than these are sampled evenly
GROWTH = (10, 100, 1000)  # times as many people
LAMPS = ([0.0, 0.0, 1.0], [0.6, 0.0, 1.0], [-0.6, 0.0, 1.0], [0.0, 0.6, 1.0], [0.0, -0.6, 1.0])
NEAREST = 1e-6  # a distance is not smaller, so that it has a logarithm

Search = tuple[str, Floats]  # who is in a photograph, and the photograph


@dataclass(frozen=True)
class Calibration:
    """A threshold and what it promises.

    Parameters
    ----------
    threshold
        Of the gallery: the score from which somebody is named; of models without patterns the distance up to which
        somebody is.
    fpir
        The rate that was asked for: of searches by strangers, how many name somebody.
    people
        In the gallery.
    strangers, searches
        Who searched, and how often.
    seen
        Searches of these that would name somebody. Its interval says what they tell by themselves, without a
        distribution; with few searches that is little.
    fmr
        Expected false match rate of one comparison at the threshold.
    expected
        Expected rate per search, by number of people: of this gallery, and of one 10, 100 and 1000 times as large,
        1 - (1 - FMR)^n, which is an upper bound where only a shortlist is looked at.
    """

    threshold: float
    fpir: float
    people: int
    strangers: int
    searches: int
    seen: Rate
    fmr: float
    expected: dict[int, float]

    def __str__(self) -> str:
        """Say it in two lines."""
        growth = ", ".join(f"{100 * value:.3g} % with {people}" for people, value in self.expected.items())
        return (
            f"threshold {self.threshold:.3g} from {self.searches} searches by {self.strangers} people, "
            f"of which {self.seen} would name somebody\nexpected: {growth} people"
        )


def calibration(
    gallery: Gallery,
    fpir: float = 0.01,
    photographs: Sequence[ArrayLike] | None = None,
    names: Sequence[str] | None = None,
) -> Calibration:
    """Find the threshold of a gallery; see `Gallery.calibrate`, which also sets it."""
    if len(gallery) < 2:
        raise HarmonicFaceError(f"calibrate: expected a gallery of at least two people, got {len(gallery)}")
    searches = _own(gallery) if photographs is None else _given(photographs, names)
    if photographs is None and names is not None:
        raise HarmonicFaceError("names: expected them with photographs only, got names alone")
    scores: dict[str, list[NDArray[np.float64]]] = {}
    for name, photo in searches:
        scores.setdefault(name, []).append(_scores(gallery, photo, name))
    strangers = Strangers.of([np.stack(rows) for rows in scores.values()], len(gallery))
    score = strangers.threshold(fpir, len(gallery))
    best = np.array(strangers.best)
    return Calibration(
        threshold=_as_threshold(gallery, score),
        fpir=fpir,
        people=len(gallery),
        strangers=len(scores),
        searches=len(best),
        seen=rate(int((best >= score).sum()), len(best)),
        fmr=strangers.fmr(score),
        expected={size: strangers.fpir(score, size) for size in (len(gallery), *(n * len(gallery) for n in GROWTH))},
    )


def _own(gallery: Gallery) -> Iterator[Search]:
    """Return pictures of the people in a gallery: their photographs, or renderings of their harmonic images."""
    if len(gallery) < FEWEST_PEOPLE:
        expected = f"at least {FEWEST_PEOPLE} people, each to be left out once, or photographs of others"
        raise HarmonicFaceError(f"calibrate: expected {expected}, got {len(gallery)} people")
    every = -(-len(gallery) * len(LAMPS) // MOST_SEARCHES)
    for name in gallery.names[::every]:
        for picture in _pictures(gallery, name):
            yield name, picture


def _pictures(gallery: Gallery, name: str) -> list[Floats]:
    """Return photographs that are like those of a person."""
    images = gallery.pictures_of(name)
    if gallery.source_of(name) not in WITH_GEOMETRY:
        return [np.maximum(image, 0) for image in images]
    order = round(len(images) ** 0.5) - 1
    if (order + 1) ** 2 != len(images):  # linear3 leaves the first one out
        lights = [directional(towards).coefficients(1)[1:] for towards in LAMPS]
    else:
        lights = [directional(towards).coefficients(order) for towards in LAMPS]
    return [np.maximum(np.tensordot(light, images, 1), 0) for light in lights]


def _given(photographs: Sequence[ArrayLike], names: Sequence[str] | None) -> Iterator[Search]:
    """Return photographs that a user gives; without names each shows somebody else."""
    if names is not None and len(names) != len(photographs):
        raise HarmonicFaceError(f"names: expected one for each of {len(photographs)} photographs, got {len(names)}")
    for index, photo in enumerate(photographs):
        # a blank is no name that somebody could have in a gallery
        yield f" {index}" if names is None else names[index], _validate.image(photo, f"photograph {index}")


def _scores(gallery: Gallery, photo: Floats, name: str) -> NDArray[np.float64]:
    """Return the scores of a search with others than whom the photograph shows; not with more than a shortlist."""
    others = [one for one in gallery.names if one != name]
    found = gallery.search_scores(photo, among=others[:: -(-len(others) // gallery.shortlist)])
    return found.scores if gallery.by_score else -np.log(np.maximum(found.distances, NEAREST))


def _as_threshold(gallery: Gallery, score: float) -> float:
    """Return a score as the gallery compares it."""
    return score if gallery.by_score else float(np.exp(-score))
