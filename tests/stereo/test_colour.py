from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harmonicface.appearance.basis import harmonic_images
from harmonicface.appearance.render import render
from harmonicface.lighting.light import HarmonicLight
from harmonicface.stereo.colour import colour_albedo, shading_of
from harmonicface.surfaces.surface import Surface

RANDOM = np.random.default_rng(0)
COLOURS = RANDOM.uniform(0.2, 0.8, (50, 3))
SHADES = RANDOM.uniform(0.1, 1, (6, 50))
GREY = COLOURS.mean(axis=1)


def test_colours_of_a_matte_thing_are_exact() -> None:
    assert_allclose(colour_albedo(SHADES[..., None] * COLOURS, SHADES, GREY), COLOURS, rtol=1e-5)


def test_shadows_highlights_and_saturation_are_left_out() -> None:
    shown = SHADES[..., None] * COLOURS
    shown[0] *= 0.1
    shown[1] *= 4
    shown[2, :, 1] = np.inf
    assert_allclose(colour_albedo(shown, SHADES, GREY), COLOURS, rtol=1e-5)


def test_shadows_alone_still_tell_the_colour() -> None:
    assert_allclose(colour_albedo(0.1 * SHADES[..., None] * COLOURS, SHADES, GREY), COLOURS, rtol=1e-5)


def test_the_mean_of_colours_is_the_grey_albedo() -> None:
    shown = RANDOM.uniform(0, 1, (6, 50, 3))
    assert_allclose(colour_albedo(shown, SHADES, GREY).mean(axis=1), GREY, rtol=1e-5)


def test_what_nothing_shows_is_grey() -> None:
    shown = np.full((6, 50, 3), np.inf)
    assert_allclose(colour_albedo(shown, SHADES, GREY), np.repeat(GREY[:, None], 3, axis=1), rtol=1e-6)


@pytest.mark.parametrize("count", [4, 9])
def test_shading_under_harmonics_is_that_of_rendering(count: int) -> None:
    normals = RANDOM.normal(size=(5, 6, 3))
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    surface = Surface(normals, np.ones((5, 6)))
    light = RANDOM.normal(size=count)
    found = shading_of(surface, light)
    assert_allclose(found, light @ harmonic_images(surface, {4: 1, 9: 2}[count]), atol=1e-12)
    assert_allclose(found, render(surface, HarmonicLight(light))[surface.mask], atol=1e-12)


def test_shading_under_a_lamp_is_the_clamped_cosine() -> None:
    surface = Surface(np.array([[[0.0, 0, 1], [0.6, 0, -0.8]]]), np.ones((1, 2)))
    assert_allclose(shading_of(surface, np.array([0.0, 0, 2.0])), [2, 0])
