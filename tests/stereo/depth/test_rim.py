"""The rim tells convex from concave."""

import numpy as np

from harmonicface.stereo.depth.rim import outward_slant
from tests.stereo.lamp_scenes import bumpy_ball


def test_balls_bulge_and_bowls_do_not():
    normals, mask = bumpy_ball()
    assert outward_slant(normals, mask) > 0.5
    assert np.isclose(outward_slant(normals * [-1, -1, 1], mask), -outward_slant(normals, mask))


def test_a_wall_says_nothing():
    assert abs(outward_slant(np.tile([0.0, 0.0, 1.0], (400, 1)), np.ones((20, 20), bool))) < 1e-9
