"""Lamps that are found again without photographs of something else."""

from __future__ import annotations

import numpy as np

from harmonicface.stereo.in_blocks import Pixels
from harmonicface.stereo.lamps.belonging import lamps_of_those_that_belong
from harmonicface.stereo.lamps.lamps import Lamps
from harmonicface.stereo.result import Ambiguity

GENERATOR = np.random.default_rng(0)
LIGHTS = GENERATOR.normal((0, 0, 3), 1, (24, 3))
SCALED = GENERATOR.normal((0, 0, 3), 1, (300, 3))
PHOTOGRAPHS = np.maximum(LIGHTS @ SCALED.T, 0)


def found(count: int, lights: np.ndarray) -> Lamps:
    pixels = Pixels(SCALED, np.zeros(300), np.ones(300), np.full(300, count, np.int32))
    return Lamps(lights, pixels, Ambiguity("bas-relief", "for the test"))


def test_those_that_belong_are_asked_once() -> None:
    asked = []
    lamps, left_out = lamps_of_those_that_belong(
        lambda seen: (asked.append(len(seen)), found(len(seen), LIGHTS))[1], PHOTOGRAPHS
    )
    assert (asked, left_out) == ([24], {})
    assert np.array_equal(lamps.lights, LIGHTS)


def test_a_photograph_of_something_else_is_left_out_and_the_others_asked_again() -> None:
    mixed = PHOTOGRAPHS.copy()
    mixed[5] = mixed[5, ::-1]
    asked = []

    def find(seen: np.ndarray) -> Lamps:
        asked.append(len(seen))
        return found(len(seen), LIGHTS if len(seen) == 24 else np.delete(LIGHTS, 5, axis=0))

    lamps, left_out = lamps_of_those_that_belong(find, mixed)
    assert asked == [24, 23]
    assert list(left_out) == [5]
    assert np.flatnonzero(np.isnan(lamps.lights).any(axis=1)).tolist() == [5]
    assert np.array_equal(np.delete(lamps.lights, 5, axis=0), np.delete(LIGHTS, 5, axis=0))
    assert lamps.pixels.used.max() == 23
