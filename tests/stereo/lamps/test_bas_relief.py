"""Bas-relief transformations leave photographs alone; equal lamps undo them."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from harmonicface.stereo.lamps.bas_relief import bas_relief, relief_of_equal_lamps, unit_frame
from tests.stereo.lamp_scenes import lamps

SLOPES = st.floats(-0.6, 0.6)


@given(SLOPES, SLOPES, st.floats(0.5, 2.0))
def test_depth_is_stretched_and_tilted(mu, nu, stretch):
    slopes = np.array([0.3, -0.2])  # of a depth
    seen = bas_relief(mu, nu, stretch) @ [*-slopes, 1.0]
    assert np.allclose(-seen[:2] / seen[2], stretch * slopes + [mu, nu])


@settings(max_examples=15)
@given(SLOPES, SLOPES, st.floats(0.5, 2.0))
def test_equal_lamps_undo_it(mu, nu, stretch):
    truth = lamps(30)
    frame = bas_relief(mu, nu, stretch)
    found, deviations = relief_of_equal_lamps(truth @ np.linalg.inv(frame))
    assert np.allclose(found @ frame, np.eye(3), atol=1e-3)
    assert (deviations < 0.01).all()


def test_lamps_on_a_cone_leave_their_relief_open():
    around = np.arange(20.0)
    cone = np.stack([0.5 * np.cos(around), 0.5 * np.sin(around), np.full(20, np.sqrt(0.75))], axis=1)
    assert relief_of_equal_lamps(cone)[1][2] > 0.3 > 0.03 > relief_of_equal_lamps(lamps(20))[1][2]


def test_unit_frame_leaves_a_rotation():
    matrix = np.random.default_rng(0).normal(size=(3, 3))
    seen = lamps(30) @ np.linalg.inv(matrix)
    found = seen @ np.linalg.inv(unit_frame(seen))
    assert np.allclose(found @ found.T, lamps(30) @ lamps(30).T)


def test_unit_frame_outvotes_a_lamp_of_other_brightness():
    seen = lamps(30)
    seen[3] *= 1.5
    assert np.allclose(unit_frame(seen), np.eye(3), atol=1e-3)


def test_unit_frame_needs_six_lamps_off_a_cone():
    around = np.arange(12.0)
    cone = np.stack([0.5 * np.cos(around), 0.5 * np.sin(around), np.full(12, np.sqrt(0.75))], axis=1)
    assert unit_frame(lamps(5)) is None
    assert unit_frame(cone) is None
