"""Equally bright lamps in unknown directions: normals and directions of renderings and of a real ball."""

import numpy as np
import pytest

from harmonicface.datasets.diligent import load_diligent
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.lamps.unknown_directions import unknown_directions
from tests.stereo.lamp_scenes import angles, bumpy_ball, lamps

NORMALS, MASK = bumpy_ball()
LIGHTS = lamps(24)


def test_normals_and_directions_of_a_matte_ball():
    images = 0.6 * np.maximum(LIGHTS @ NORMALS.T, 0)
    found = unknown_directions(images + np.random.default_rng(0).normal(0, 0.003, images.shape), MASK)
    assert angles(found.lights, LIGHTS).mean() < 1.5
    assert angles(found.pixels.scaled, NORMALS).mean() < 1.5
    assert np.allclose(np.linalg.norm(found.lights, axis=1), 1)
    assert found.ambiguity.name == "none"


def test_lamps_on_a_cone_still_leave_the_shape_first():
    around = np.arange(20.0)
    cone = np.stack([0.5 * np.cos(around), 0.5 * np.sin(around), np.full(20, np.sqrt(0.75))], axis=1)
    found = unknown_directions(np.maximum(cone @ NORMALS.T, 0), MASK, method="least_squares")
    assert angles(found.lights, cone).mean() < 6


@pytest.mark.data
def test_ball_of_diligent(data_dir):
    ball = load_diligent(data_dir / "diligent" / "ballPNG")
    found = unknown_directions(ball.grey(), ball.mask, method="least_squares")
    assert angles(found.lights, ball.directions).mean() < 2.5


def test_fewer_lamps_than_unknowns_are_refused():
    with pytest.raises(HarmonicFaceError, match="at least 6"):
        unknown_directions(LIGHTS[:5] @ NORMALS.T, MASK)


def test_mask_of_other_size_is_refused():
    with pytest.raises(HarmonicFaceError, match=f"expected {len(NORMALS)} pixels, got 9"):
        unknown_directions(LIGHTS @ NORMALS.T, np.ones((3, 3), bool))


def test_mask_without_inner_pixels_is_refused():
    with pytest.raises(HarmonicFaceError, match="four neighbours"):
        unknown_directions(LIGHTS @ NORMALS[:9].T, np.ones((3, 3), bool))
