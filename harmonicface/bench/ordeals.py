"""Ordeals: ways in which a photograph can be worse than those that people were enrolled from, each at many levels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from harmonicface.bench.degradation import Picture, at_resolution, blurred, compressed, moved, noisy, with_gamma
from harmonicface.bench.occlusion import behind_block, behind_glasses

SIZE = (96, 84)  # height and width at which photographs are asked for
SHRINK = 2  # from the data set's size
YALE_EYES = (0.24, 0.21, 0.78)  # row of the eyes and columns of both, as parts of a photograph of Yale B

Spoil = Callable[[Picture, float, np.random.Generator], Picture]


@dataclass(frozen=True)
class Ordeal:
    """Something that happens to a photograph.

    Parameters
    ----------
    name
        As in "noise".
    unit
        What its levels are.
    levels
        From small to large; `still` is the one that does nothing.
    spoil
        (photograph at the data set's size, level, generator) -> the same size.
    still
        The level at which nothing happens.
    words
        What levels are called, where their numbers say little.
    """

    name: str
    unit: str
    levels: tuple[float, ...]
    spoil: Spoil
    still: float
    words: tuple[str, ...] = ()

    def spell(self, level: float) -> str:
        """Return what a level is called."""
        return self.words[self.levels.index(level)] if self.words else f"{level:g}"

    def apply(self, photo: Picture, level: float, seed: tuple[int, ...]) -> Picture:
        """Return a photograph of the data set, spoiled, at the size at which it is asked for."""
        spoiled = photo if level == self.still else self.spoil(photo, level, np.random.default_rng(seed))
        return reduced_photo(spoiled)


def reduced_photo(photo: Picture) -> Picture:
    """Return a photograph of the data set at half its size, by averages over areas.

    Examples
    --------
    >>> reduced_photo(np.ones((192, 168), np.float32)).shape
    (96, 84)
    """
    return np.asarray(cv2.resize(photo, SIZE[::-1], interpolation=cv2.INTER_AREA), np.float32)


def _shift(photo: Picture, pixels: float, rng: np.random.Generator) -> Picture:
    """Shift in a random direction."""
    around = rng.uniform(0, 2 * np.pi)
    return moved(photo, SHRINK * pixels * np.cos(around), SHRINK * pixels * np.sin(around))


def _block(photo: Picture, percent: float, rng: np.random.Generator) -> Picture:
    """Hold something before it."""
    return np.clip(behind_block(photo, percent / 100, rng), 0, 1)


def _glasses(photo: Picture, kind: float, _: np.random.Generator) -> Picture:
    """Put glasses on, with dark lenses if the kind is 2."""
    return np.clip(behind_glasses(photo, YALE_EYES, dark=kind == 2), 0, 1)


ORDEALS = (
    Ordeal("noise", "% of white", (0, 0.5, 1, 2, 4, 8), lambda p, level, rng: noisy(p, level / 100, rng), 0),
    Ordeal("block before the face", "% of the area", (0, 10, 20, 30, 40, 50), _block, 0),
    Ordeal("glasses", "rims, reflections, lenses", (0, 1, 2), _glasses, 0, ("none", "clear", "dark")),
    Ordeal("shift", f"pixels at {SIZE[1]} x {SIZE[0]}", (0, 1, 2, 3, 4, 5, 6), _shift, 0),
    Ordeal(
        "rotation",
        "degrees to a random side",
        (0, 2, 4, 6, 8, 10),
        lambda p, level, rng: moved(p, degrees=level * rng.choice((-1, 1))),
        0,
    ),
    Ordeal("scale", "times as large", (0.85, 0.9, 0.95, 1, 1.05, 1.1, 1.15), lambda p, s, _: moved(p, scale=s), 1),
    Ordeal(
        "blur", f"pixels at {SIZE[1]} x {SIZE[0]}", (0, 0.5, 1, 1.5, 2, 3), lambda p, s, _: blurred(p, SHRINK * s), 0
    ),
    Ordeal(
        "JPEG",
        "quality",
        (10, 20, 30, 50, 75, 95, 101),
        lambda p, q, _: compressed(p, int(q)),
        101,
        ("10", "20", "30", "50", "75", "95", "none"),
    ),
    Ordeal("resolution", "pixels across", (16, 21, 28, 42, 56, 84, 168), lambda p, w, _: at_resolution(p, int(w)), 168),
    Ordeal("gamma", "of an unknown camera", (0.45, 0.6, 0.8, 1, 1.4, 1.8, 2.2), lambda p, g, _: with_gamma(p, g), 1),
)
ENROLMENT = Ordeal("enrolment", "photographs a person", (1, 2, 3, 4, 5, 6, 7), lambda p, *_: p, 7)
