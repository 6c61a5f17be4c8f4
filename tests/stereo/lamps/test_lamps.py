"""Surfaces are turned right side out, and what only the rim told is said."""

import numpy as np
import pytest

from harmonicface.stereo.lamps.lamps import bulging, of_rim, solved_under
from tests.stereo.lamp_scenes import angles, bumpy_ball, lamps

NORMALS, MASK = bumpy_ball()


@pytest.mark.parametrize("sign", [[1, 1, 1], [-1, -1, 1], [1, 1, -1], [-1, -1, -1]])
def test_every_sign_is_undone(sign):
    truth = lamps(5)
    if np.prod(sign) < 0:
        sign = -np.array(sign)  # photographs of a mirrored frame are those of the negative one
    lights, scaled, slant = bulging(truth * sign, NORMALS * sign, MASK)
    assert np.allclose(scaled, NORMALS) and np.allclose(lights, truth) and slant > 0.5


def test_a_negative_frame_is_turned_to_the_camera():
    lights, scaled, _ = bulging(-lamps(5), -NORMALS, MASK)
    assert np.allclose(scaled, NORMALS) and np.allclose(lights, lamps(5))


def test_a_rim_that_says_little_is_named():
    assert of_rim(0.05).name == "convex-concave"
    assert of_rim(0.6).name == "none"


@pytest.mark.parametrize("method", ["robust", "least_squares"])
def test_pixels_are_solved_under_the_lamps(method):
    images = lamps(12, widest=20) @ NORMALS.T
    found = solved_under(np.maximum(images, 0), lamps(12, widest=20), method, np.inf)
    assert np.median(angles(found.scaled, NORMALS)) < 0.5
