"""Harmonic images against the papers' polynomials, and against pictures that are rendered exactly."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import harmonicface as hf
from harmonicface.surfaces.transfer import transport
from harmonicface.surfaces.transport import Transport

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


def stairs(albedo: np.ndarray | float = 0.5) -> hf.Surface:
    depth = np.repeat(np.cumsum([0.0, 0, 3, 0, 0, 2, -4, 0, 0, 1]), 2).reshape(1, -1) * np.ones((12, 1))
    depth[4:6, 7:9] = np.nan
    return hf.surface_from_depth(depth, albedo)


@pytest.mark.parametrize("order", [0, 2, 4, 8])
def test_images_with_shadows_are_albedo_times_transport(order: int) -> None:
    surface = stairs(RNG.uniform(0.1, 1, (12, 20)))
    expected = surface.pixel_albedo * transport(surface, order).values
    images = hf.harmonic_images(surface, order, shadows=True)
    assert images.flags.c_contiguous
    assert_allclose(images, expected, rtol=1e-14)
    assert np.linalg.norm(images - hf.harmonic_images(surface, order)) > 0.05 * np.linalg.norm(images)


def test_bounces_imply_shadows_and_bring_light() -> None:
    surface = stairs()
    direct = hf.harmonic_images(surface, 0, shadows=True)
    bounced = hf.harmonic_images(surface, 0, bounces=1)
    assert_allclose(bounced, 0.5 * transport(surface, 0, bounces=1).values, rtol=1e-14)
    assert (bounced >= direct).all() and bounced.sum() > direct.sum()


@pytest.mark.parametrize("bounces", [0, 1])
def test_coloured_shadows_are_the_luminance_of_the_coloured_picture(bounces: int) -> None:
    colour = RNG.uniform(0.1, 1, (12, 20, 3))
    surface = stairs(colour)
    values = transport(surface, 2, bounces).values
    assert values.ndim == 2 + bounces
    light = RNG.normal(size=9)
    arriving = np.tensordot(light, values, (0, 0)).reshape(len(surface.pixel_albedo), -1)
    expected = (surface.pixel_albedo * arriving) @ [0.2126, 0.7152, 0.0722]
    grey = light @ hf.harmonic_images(surface, 2, shadows=True, bounces=bounces)
    assert_allclose(grey, expected, rtol=0, atol=1e-12)


def test_grey_skin_with_coloured_transport() -> None:
    coloured = Transport(RNG.normal(size=(4, int(MASK.sum()), 3)), bounces=1)
    surface = hf.Surface(NORMALS, ALBEDO, MASK, transports=[coloured])
    expected = ALBEDO[MASK] * (coloured.values @ [0.2126, 0.7152, 0.0722])
    assert_allclose(hf.harmonic_images(surface, 1, bounces=1), expected, rtol=0, atol=1e-12)


def test_single_precision_stays_single_in_the_shadow() -> None:
    double = stairs()
    single = hf.Surface(double.normals.astype(np.float32), double.albedo.astype(np.float32), double.mask, double.depth)
    images = hf.harmonic_images(single, 4, shadows=True)
    assert images.dtype == np.float32
    assert_allclose(images, hf.harmonic_images(double, 4, shadows=True), rtol=0, atol=2e-6)


def test_a_ball_casts_no_shadow_on_itself() -> None:
    y, x = np.mgrid[15.5:-16:-1, -15.5:16] / 15
    z = np.sqrt(np.maximum(1 - x**2 - y**2, 0))
    ball = hf.Surface(np.stack([x, y, z], axis=2) * (z > 0)[..., None], np.ones(z.shape), z > 0, 15 * z)
    assert_allclose(hf.harmonic_images(ball, 4, shadows=True), hf.harmonic_images(ball, 4), rtol=0, atol=1e-14)


def test_shadows_need_depth() -> None:
    with pytest.raises(hf.HarmonicFaceError, match="neither depth nor scene"):
        hf.harmonic_images(hf.Surface(NORMALS, ALBEDO, MASK), shadows=True)
    with pytest.raises(hf.HarmonicFaceError, match="bounces: expected"):
        hf.harmonic_images(stairs(), bounces=-1)


def test_orders_without_end_are_refused() -> None:
    wall = hf.Surface(np.tile([0.0, 0.0, 1.0], (2, 2, 1)), np.ones((2, 2)), depth=np.zeros((2, 2)))
    with pytest.raises(hf.HarmonicFaceError, match=r"order: expected at most 200, .* got 1000"):
        hf.harmonic_images(wall, 1000)
    with pytest.raises(hf.HarmonicFaceError, match=r"order: expected at most 12 with shadows, .* got 99"):
        hf.harmonic_images(wall, 99, shadows=True)
    with pytest.raises(hf.HarmonicFaceError, match="shadows: expected True or False, got int 2"):
        hf.harmonic_images(wall, shadows=2)  # type: ignore[arg-type]
