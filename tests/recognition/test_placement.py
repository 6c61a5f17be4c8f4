"""How a photograph shows somebody: shift, turn, growth, and the motion that these are."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from harmonicface.recognition.placement import Placement

SHAPE = (96, 84)


def test_a_motion_turns_clockwise_about_the_middle_and_grows() -> None:
    x, y = Placement(2, -1, 90, 0.5).motion((5, 7)) @ [4, 2, 1]  # a pixel to the right of the middle
    assert_allclose([x, y], [3 + 2, 2 - 1 + 1.5], atol=1e-12)
    assert_allclose(Placement().motion(SHAPE), np.eye(2, 3))


@given(*(st.floats(-20, 20) for _ in range(3)), st.floats(-0.5, 0.5))
def test_a_motion_tells_its_placement(right: float, down: float, turn: float, growth: float) -> None:
    found = Placement.of(Placement(right, down, turn, growth).motion(SHAPE), SHAPE)
    assert_allclose([found.right, found.down, found.turn, found.growth], [right, down, turn, growth], atol=1e-8)


def test_a_placement_in_smaller_pixels() -> None:
    coarse, fine = Placement(1, -2, 30, 0.1).motion((48, 42)), Placement(1, -2, 30, 0.1).scaled(2).motion((96, 84))
    point = np.array([10.0, 7.0])
    assert_allclose(2 * (coarse @ [*point, 1]) + 0.5, fine @ [*(2 * point + 0.5), 1])
