"""Maps redrawn, turned and shown: what is kept when the picture changes."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

import harmonicface as hf
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.lighting.layouts import LAYOUTS, layout_named

COEFFICIENTS = np.array([3.0, 0.5, -0.3, 0.4, 0.1, 0.2, -0.1, 0.05, 0.1])


def smooth(layout: str, size: int) -> hf.EnvironmentMap:
    """A map of known coefficients."""
    chosen = layout_named(layout)
    return hf.EnvironmentMap(
        np.tensordot(COEFFICIENTS, real_harmonics(chosen.directions(chosen.shape(size)), 2), 1), layout
    )


@pytest.mark.parametrize("start", LAYOUTS)
@pytest.mark.parametrize("end", LAYOUTS)
def test_light_survives_every_conversion(start: str, end: str) -> None:
    light = smooth(start, 96).converted(end, 64)
    assert light.layout == end
    assert light.shape == layout_named(end).shape(64)
    # a mirror ball's rim squeezes what is behind it: its pixels there are far apart
    assert_allclose(light.coefficients(), COEFFICIENTS, rtol=0, atol=0.03 if "mirrorball" in (start, end) else 3e-3)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_small_sun_keeps_its_strength_when_the_map_gets_coarse(layout: str) -> None:
    radiance = np.full((128, 256), 0.01)
    radiance[40, 70] = 5000.0
    fine = hf.EnvironmentMap(radiance)
    coarse = fine.converted(layout, 16)
    assert_allclose(coarse.coefficients(0), fine.coefficients(0), rtol=0.03)
    before, after = fine.coefficients(1)[1:], coarse.coefficients(1)[1:]
    cosine = before @ after / np.linalg.norm(before) / np.linalg.norm(after)
    # the sun moves to the centre of a pixel; half a diagonal of a light probe's largest one is 1.2 times the mean
    assert np.arccos(cosine) < 1.2 * layout_named(layout).spacing(coarse.shape)


def test_the_usual_size_keeps_that_of_a_pixel() -> None:
    cube = hf.EnvironmentMap(np.ones((64, 128))).converted("cube")
    assert 30 <= cube.shape[1] <= 40  # 8192 pixels are six faces of 37 x 37
    assert hf.EnvironmentMap(np.ones((1, 1))).converted("angular").shape == (1, 1)


def test_colours_and_types_stay() -> None:
    light = hf.EnvironmentMap(np.ones((4, 8, 3), np.float32) * np.float32([1, 2, 3])).converted("cube", 4)
    assert light.radiance.dtype == np.float32
    assert_allclose(light.radiance, np.broadcast_to([1, 2, 3], (6, 4, 4, 3)), rtol=1e-6)


def test_a_round_map_is_dark_outside_its_disc() -> None:
    light = hf.EnvironmentMap(np.ones((16, 32))).converted("angular", 32)
    assert light.radiance[0, 0] == 0
    assert light.radiance[16, 16] == 1


def test_turned_maps_look_turned() -> None:
    light = smooth("latlong", 64)
    turn = Rotation.from_rotvec([0.3, 1.0, -0.5])
    turned = light.rotated(turn)
    directions = np.random.default_rng(0).normal(size=(50, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    assert_allclose(turned.radiance_toward(turn.apply(directions)), light.radiance_toward(directions), rtol=1e-12)
    redrawn = turned.converted("latlong", 64)
    assert redrawn.rotation is None
    assert_allclose(redrawn.coefficients(), turned.coefficients(), rtol=0, atol=2e-3)
    twice = turned.rotated(turn.inv())
    assert_allclose(twice.coefficients(), light.coefficients(), rtol=0, atol=1e-13)
    assert_allclose(twice.directions, light.directions, atol=1e-14)
    assert_array_equal((turned * 2).rotation, turned.rotation)
    coloured = hf.EnvironmentMap(np.ones((2, 4, 3)), rotation=turn)
    assert_array_equal(coloured.grey().rotation, turn.as_matrix())


@pytest.mark.parametrize("layout", LAYOUTS)
def test_pictures_are_for_screens(layout: str) -> None:
    light = hf.lights.natural(0, size=16).converted(layout, 8)
    shown = light.picture()
    assert shown.shape == ((24, 32) if layout == "cube" else light.shape)
    assert shown.min() >= 0
    assert shown.max() == pytest.approx(1)
    assert light.rotated(np.diag([-1.0, 1.0, -1.0])).picture().shape == shown.shape


def test_a_map_turned_half_round_is_shown_turned() -> None:
    radiance = np.zeros((16, 32))
    radiance[8, 16] = 1.0  # straight ahead of the camera
    shown = hf.EnvironmentMap(radiance).rotated(np.diag([-1.0, 1.0, -1.0])).picture()
    assert shown[8, [0, -1]].max() > 0.1
    assert shown[:, 8:24].max() == 0


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda light: light.converted("globe"), "layout: expected one of"),
        (lambda light: light.converted("cube", 0), "size: expected an integer of at least 1"),
        (lambda light: light.radiance_toward([0.0, 0.0, 3.0]), "directions: expected unit vectors"),
        (lambda light: light.picture(key=0), "key: expected a finite number above 0"),
        (lambda light: light.picture(white=-1), "white: expected a finite number above 0"),
    ],
)
def test_what_cannot_be_drawn(call, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        call(hf.EnvironmentMap(np.ones((2, 4))))
