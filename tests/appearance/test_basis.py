"""Harmonic images against the papers' polynomials, and against pictures that are rendered exactly."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import harmonicface as hf

RNG = np.random.default_rng(0)
NORMALS = RNG.normal(size=(6, 5, 3))
NORMALS /= np.linalg.norm(NORMALS, axis=2, keepdims=True)
ALBEDO = RNG.uniform(0.1, 1, (6, 5))
MASK = RNG.uniform(size=(6, 5)) < 0.7


def test_nine_images_in_closed_form() -> None:
    x, y, z = NORMALS[MASK].T
    one = np.ones_like(x)
    a0, a1, a2 = np.pi, 2 * np.pi / 3, np.pi / 4
    expected = ALBEDO[MASK] * [
        a0 * 0.28209479177 * one,
        a1 * 0.48860251190 * y,
        a1 * 0.48860251190 * z,
        a1 * 0.48860251190 * x,
        a2 * 1.09254843059 * x * y,
        a2 * 1.09254843059 * y * z,
        a2 * 0.31539156525 * (3 * z**2 - 1),
        a2 * 1.09254843059 * x * z,
        a2 * 0.54627421529 * (x**2 - y**2),
    ]
    images = hf.harmonic_images(hf.Surface(NORMALS, ALBEDO, MASK))
    assert images.shape == (9, MASK.sum())
    assert images.flags.c_contiguous
    assert_allclose(images, expected, rtol=0, atol=1e-10)


@pytest.mark.parametrize("order", [0, 1, 2, 5])
def test_combined_by_a_light_they_are_its_picture(order: int) -> None:
    surface = hf.Surface(NORMALS, ALBEDO, MASK)
    light = hf.lights.natural(0, size=6)
    combined = light.coefficients(order) @ hf.harmonic_images(surface, order)
    assert_allclose(combined, hf.render(surface, light, order=order)[MASK], rtol=0, atol=1e-13)


def test_they_approach_the_exact_picture() -> None:
    surface = hf.Surface(NORMALS, ALBEDO, MASK)
    light = hf.lights.natural(0, size=6)
    exact = hf.render(surface, light)[MASK]
    errors = [
        np.linalg.norm(light.coefficients(order) @ hf.harmonic_images(surface, order) - exact) / np.linalg.norm(exact)
        for order in (0, 1, 2, 16)
    ]
    assert errors == sorted(errors, reverse=True)
    assert errors[3] < 0.01


def test_colour_is_taken_as_luminance() -> None:
    colour = RNG.uniform(0, 1, (6, 5, 3))
    grey = colour @ [0.2126, 0.7152, 0.0722]
    expected = hf.harmonic_images(hf.Surface(NORMALS, grey, MASK))
    assert_allclose(hf.harmonic_images(hf.Surface(NORMALS, colour, MASK)), expected, rtol=1e-12, atol=1e-15)


def test_single_precision_stays_single() -> None:
    single = hf.harmonic_images(hf.Surface(NORMALS.astype(np.float32), ALBEDO.astype(np.float32), MASK))
    assert single.dtype == np.float32
    assert_allclose(single, hf.harmonic_images(hf.Surface(NORMALS, ALBEDO, MASK)), rtol=0, atol=2e-6)


def test_the_surface_is_left_alone() -> None:
    surface = hf.Surface(NORMALS, ALBEDO, MASK)
    before = surface.normals.copy(), surface.albedo.copy()
    hf.harmonic_images(surface)
    assert_array_equal(surface.normals, before[0])
    assert_array_equal(surface.albedo, before[1])


def test_no_order() -> None:
    with pytest.raises(hf.HarmonicFaceError, match="order: expected an integer of at least 0"):
        hf.harmonic_images(hf.Surface(NORMALS, ALBEDO, MASK), order=-1)
