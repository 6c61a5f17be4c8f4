"""Lamps of which nothing is known: renderings with known answers, and what is said of the rest."""

import numpy as np
import pytest

from harmonicface.datasets.diligent import load_diligent
from harmonicface.datasets.yale_b import load_yale_b
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.known.robust import robust_normals
from harmonicface.stereo.lamps.unknown_directions import unknown_directions
from harmonicface.stereo.lamps.unknown_lamps import unknown_lamps
from harmonicface.stereo.registration import register
from tests.stereo.lamp_scenes import angles, bumpy_ball, lamps

NORMALS, MASK = bumpy_ball()
LIGHTS = lamps(24)
BRIGHTNESS = np.exp(np.random.default_rng(3).uniform(np.log(0.3), np.log(3), 24))[:, None]
IMAGES = 0.6 * BRIGHTNESS * np.maximum(LIGHTS @ NORMALS.T, 0)


def test_brightness_and_directions_of_a_matte_ball():
    found = unknown_lamps(IMAGES, MASK, method="least_squares")
    errors = angles(found.pixels.scaled, NORMALS)
    assert errors.mean() < 4
    assert errors.mean() < 2 * np.median(found.pixels.confidence)
    brightness = np.linalg.norm(found.lights, axis=1)
    assert np.abs(np.log(brightness / BRIGHTNESS[:, 0])).std() < 0.1
    assert np.isclose(np.median(brightness), 1)


def test_equal_lamps_settle_it():
    found = unknown_lamps(np.maximum(LIGHTS @ NORMALS.T, 0), MASK, method="least_squares")
    assert "equal lamps" in found.ambiguity.reason
    assert angles(found.lights, LIGHTS).mean() < 2


def test_a_thousand_to_one_is_no_harder():
    one = unknown_lamps(IMAGES, MASK, method="least_squares")
    dim = IMAGES * np.where(np.arange(24) % 2, 1e-3, 1.0)[:, None]
    assert angles(unknown_lamps(dim, MASK, method="least_squares").lights, one.lights).max() < 0.1


def test_a_cylinder_is_refused():
    x = np.tile(np.linspace(-0.9, 0.9, 40), (40, 1))
    cylinder = np.stack([x, np.full_like(x, 0.0), np.sqrt(1 - x**2)], axis=2).reshape(-1, 3)
    images = np.maximum(LIGHTS @ cylinder.T, 0) + np.random.default_rng(0).normal(0, 0.003, (24, 1600))
    with pytest.raises(HarmonicFaceError, match="or a cylinder"):
        unknown_lamps(images, np.ones((40, 40), bool))


@pytest.mark.parametrize("solve", [unknown_lamps, unknown_directions])
def test_lamps_near_one_another_are_refused(solve):
    images = lamps(20, widest=5) @ NORMALS.T
    with pytest.raises(HarmonicFaceError, match="near one another"):
        solve(images + np.random.default_rng(0).normal(0, 0.003, images.shape), MASK)


def test_a_wall_is_refused():
    wall = np.tile([0.0, 0.0, 1.0], (400, 1))
    with pytest.raises(HarmonicFaceError, match="not flat"):
        unknown_lamps(LIGHTS @ wall.T, np.ones((20, 20), bool))


@pytest.mark.parametrize(("count", "why"), [(24, "expected a face"), (3, "at least 4 to find a face")])
def test_where_no_face_is_found_it_is_said(count, why):
    found = unknown_lamps(IMAGES[:count], MASK, face=True, method="least_squares")
    assert why in found.ambiguity.reason
    same = unknown_lamps(IMAGES[:count], MASK, method="least_squares")
    assert np.array_equal(found.lights, same.lights)


@pytest.mark.data
def test_ball_of_diligent(data_dir):
    ball = load_diligent(data_dir / "diligent" / "ballPNG")
    found = unknown_lamps(ball.grey(divided=False), ball.mask, method="least_squares")
    measured = ball.normals.any(axis=1)
    assert angles(found.lights, ball.directions).mean() < 3
    seen = ball.grey(divided=False)[:, measured][:, ::20]
    some = robust_normals(seen, found.lights)
    assert angles(some.scaled, ball.normals[measured][::20]).mean() < 4


@pytest.mark.data
def test_light_directions_of_yale_b(data_dir):
    person = load_yale_b(data_dir / "yaleb", [7])[0]
    chosen = person.subsets <= 3
    photographs = register(person.photographs[chosen]).photographs
    mask = np.zeros(photographs.shape[1:], bool)
    mask[4:-4, 4:-4] = True
    found = unknown_lamps(photographs[:, mask], mask, face=True, saturation=0.999, method="least_squares")
    assert angles(found.lights, person.lights[chosen]).mean() < 8
    assert angles(np.array([[0.0, 0.0, 1.0]]), person.lights[chosen]).mean() > 25
