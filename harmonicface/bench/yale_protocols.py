"""Protocols on Yale B: which photographs of a person are learned from, and which are asked for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface.datasets.yale_b import YalePerson
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.estimators.nine_points import nearest_to_nine
from harmonicface.recognition.nine_lights import nine_lights

SUBSETS = (1, 2, 3, 4, 5)
PUBLISHED_PEOPLE = range(1, 11)  # whose photographs in subsets 1 to 4 are the 450 of the published tables
PUBLISHED_SUBSETS = (1, 2, 3, 4)
SEEDS = 10
CHOSEN_ON = range(1, 6)  # people whose photographs settings were chosen on; the others judge

Chosen = NDArray[np.bool_]
Chooser = Callable[[YalePerson, int], Chosen]


@dataclass(frozen=True, eq=False)
class Split:
    """For every person, which photographs are learned from and which are asked for: (n,) booleans each."""

    training: tuple[Chosen, ...]
    queries: tuple[Chosen, ...]


@dataclass(frozen=True)
class YaleProtocol:
    """A way to divide the photographs.

    Parameters
    ----------
    about
        What is learned from, as words.
    choose
        (person, seed) -> which of her photographs are learned from.
    asks_training
        Whether photographs that were learned from are asked for again: the published tables of 450 photographs count
        subset 1, on which everybody was trained.
    seeds
        How many different divisions there are; errors are means over them.
    """

    about: str
    choose: Chooser
    asks_training: bool = False
    seeds: int = 1

    def splits(self, faces: Sequence[YalePerson]) -> list[Split]:
        """Return the divisions of everybody's photographs.

        Raises
        ------
        HarmonicFaceError
            Somebody has nothing to learn from.
        """
        return [self._split(faces, seed) for seed in range(self.seeds)]

    def _split(self, faces: Sequence[YalePerson], seed: int) -> Split:
        training = tuple(self.choose(face, seed) for face in faces)
        for face, chosen in zip(faces, training, strict=True):
            if not chosen.any():
                raise HarmonicFaceError(f"yaleB{face.number:02d}: expected photographs with {self.about}, got none")
        queries = tuple(np.ones_like(chosen) if self.asks_training else ~chosen for chosen in training)
        return Split(training, queries)


def yale_protocol(train: str) -> YaleProtocol:
    """Return the protocol of that name.

    Raises
    ------
    HarmonicFaceError
        There is none of that name.

    Examples
    --------
    >>> yale_protocol("frontal").about
    'light from the camera, one photograph'
    """
    if train not in PROTOCOLS:
        raise HarmonicFaceError(f"train: expected one of {', '.join(PROTOCOLS)}, got {train!r}")
    return PROTOCOLS[train]


def published_size(people: Sequence[int], n: dict[str, int]) -> bool:
    """Say whether these are the people and photographs of the published tables: 450 of people 1 to 10."""
    return list(people) == list(PUBLISHED_PEOPLE) and sum(n[str(subset)] for subset in PUBLISHED_SUBSETS) == 450


def _subsets(*subsets: int) -> Chooser:
    """Learn from whole subsets."""
    return lambda face, _: np.isin(face.subsets, subsets)


def _nine(face: YalePerson, _: int) -> Chosen:
    """Learn from the photographs whose lights are nearest to the nine."""
    chosen = np.zeros(len(face.subsets), np.bool_)
    if len(chosen) >= len(nine_lights()):
        chosen[nearest_to_nine(face.lights)] = True
    return chosen


def _frontal(face: YalePerson, _: int) -> Chosen:
    """Learn from the one photograph with the light at the camera."""
    return np.asarray(face.angles < 1e-6)


def _half(face: YalePerson, seed: int) -> Chosen:
    """Learn from a random half, the smaller one; the same whoever else is asked for."""
    count = len(face.subsets)
    chosen = np.zeros(count, np.bool_)
    chosen[np.random.default_rng((seed, face.number)).choice(count, count // 2, replace=False)] = True
    return chosen


PROTOCOLS = {
    "subset1": YaleProtocol("light within 12 degrees of the camera", _subsets(1), asks_training=True),
    "subset12": YaleProtocol("light within 25 degrees of the camera", _subsets(1, 2), asks_training=True),
    "nine-lights": YaleProtocol("the nine lights of Lee, Ho & Kriegman (2005)", _nine),
    "frontal": YaleProtocol("light from the camera, one photograph", _frontal),
    "random-half": YaleProtocol("any light, a random half, mean of ten", _half, seeds=SEEDS),
}
