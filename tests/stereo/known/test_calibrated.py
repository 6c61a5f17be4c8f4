from __future__ import annotations

import re
from collections.abc import Callable
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.known.calibrated import calibrated_stereo

SUBSET_1 = np.radians([(0, 0), (5, 10), (5, -10), (10, 0), (-5, 10), (-5, -10), (-10, 0)])  # azimuth, elevation


def narrow_lights() -> np.ndarray:
    """Seven lights within 11 degrees of the camera, as in a face data base."""
    azimuth, elevation = SUBSET_1.T
    return np.stack(
        [-np.sin(azimuth) * np.cos(elevation), np.sin(elevation), np.cos(azimuth) * np.cos(elevation)], axis=1
    )


def wide_lights(count: int, seed: int) -> np.ndarray:
    lights = np.random.default_rng(seed).normal(size=(count, 3))
    lights[:, 2] = np.abs(lights[:, 2]) + 0.5
    return lights / np.linalg.norm(lights, axis=1, keepdims=True)


def sphere(size: int = 41) -> tuple[np.ndarray, np.ndarray]:
    """Normals (h, w, 3) and mask (h, w) of a sphere that fills the picture."""
    y, x = np.mgrid[1 : -1 : size * 1j, -1 : 1 : size * 1j]
    inside = x**2 + y**2 < 0.97
    normals = np.dstack([x, y, np.sqrt(np.where(inside, 1 - x**2 - y**2, 0))])
    return np.where(inside[..., None], normals, [0.0, 0.0, 1.0]), inside


def photographs(normals: np.ndarray, albedo: np.ndarray, lights: np.ndarray) -> np.ndarray:
    return np.maximum(np.einsum("hwi,ni->nhw", normals, lights), 0) * albedo


def degrees_between(found: np.ndarray, true: np.ndarray) -> np.ndarray:
    return np.degrees(2 * np.arcsin(np.clip(np.linalg.norm(found - true, axis=-1) / 2, 0, 1)))


@pytest.mark.parametrize("lights", [narrow_lights(), wide_lights(12, 0)], ids=["narrow", "wide"])
def test_recovers_a_sphere_with_attached_shadows_where_three_lights_reach_it(lights: np.ndarray) -> None:
    normals, inside = sphere()
    albedo = 0.5 + 0.4 * np.sin(np.arange(41))[:, None] * np.cos(np.arange(41))
    images = photographs(normals, albedo, lights)
    assert (images[:, inside] == 0).any()
    found = calibrated_stereo(images, lights, inside)
    assert found.determined[inside].mean() > 0.95
    right = found.determined
    assert degrees_between(found.surface.normals, normals)[right].max() < 1e-3
    assert_allclose(found.surface.albedo[right], albedo[right], rtol=1e-5)
    assert_array_equal(found.used[right], (images > 0).sum(axis=0)[right])
    assert found.residual[right].max() < 1e-6


def test_cast_shadows_are_left_out() -> None:
    normals, inside = sphere()
    lights = wide_lights(15, 1)
    images = photographs(normals, np.full(inside.shape, 0.8), lights)
    shadowed = np.random.default_rng(2).random(images.shape) < 0.15
    images[shadowed] *= 0.1  # what the neighbourhood reflects into the shadow
    found = calibrated_stereo(images, lights, inside)
    error = degrees_between(found.surface.normals, normals)[inside]
    assert np.mean(error < 1e-3) > 0.99
    with_shadows = np.linalg.lstsq(lights, images[:, inside], rcond=None)[0].T
    with_shadows /= np.linalg.norm(with_shadows, axis=1, keepdims=True)
    assert degrees_between(with_shadows, normals[inside]).mean() > 5


def test_saturated_observations_are_left_out_unless_there_is_no_ceiling() -> None:
    normals, inside = sphere()
    lights = wide_lights(10, 3)
    images = np.minimum(photographs(normals, np.full(inside.shape, 1.2), lights), 1)
    clipped = calibrated_stereo(images, lights, inside)
    sure = clipped.determined & (images >= 1).any(axis=0)
    assert sure.sum() > 50
    assert degrees_between(clipped.surface.normals, normals)[sure].max() < 1e-3
    assert_allclose(clipped.surface.albedo[sure], 1.2, rtol=1e-5)
    taken = calibrated_stereo(images, lights, inside, saturation=np.inf)
    assert degrees_between(taken.surface.normals, normals)[sure].max() > 1


def test_the_length_of_a_light_is_its_brightness() -> None:
    normals, inside = sphere()
    lights = wide_lights(9, 4) * np.random.default_rng(4).uniform(0.3, 1, (9, 1))
    found = calibrated_stereo(photographs(normals, np.full(inside.shape, 0.6), lights), lights, inside)
    assert degrees_between(found.surface.normals, normals)[found.determined].max() < 1e-3
    assert_allclose(found.surface.albedo[found.determined], 0.6, rtol=1e-5)


def test_noise_leaves_the_error_that_its_covariance_predicts() -> None:
    lights, sigma = narrow_lights(), 0.002
    normal, albedo = np.array([0.36, 0.48, 0.8]), 0.7
    clean = albedo * lights @ normal
    images = clean[:, None, None] + np.random.default_rng(5).normal(scale=sigma, size=(7, 200, 200))
    found = calibrated_stereo(images, lights)
    assert (found.used == 7).all()
    scaled = (found.surface.normals * found.surface.albedo[..., None]).reshape(-1, 3).astype(np.float64)
    covariance = sigma**2 * np.linalg.inv(lights.T @ lights)
    assert_allclose(scaled.mean(axis=0), albedo * normal, atol=5 * sigma / 40)
    assert_allclose(np.cov(scaled.T), covariance, atol=0.03 * covariance.max())
    assert_allclose(np.mean(found.residual.astype(np.float64) ** 2), sigma**2 * (7 - 3) / 7, rtol=0.02)


def test_finds_the_minimum_that_a_search_over_all_sets_of_shadows_finds() -> None:
    random = np.random.default_rng(6)
    lights = wide_lights(6, 6)
    scaled_normals = random.normal(size=(3, 60)) * [[0.15], [0.15], [0.0]] + [[0.0], [0.0], [0.4]]
    images = np.maximum(lights @ scaled_normals, 0)
    images[random.random(images.shape) < 0.1] = 0
    images = np.clip(images + random.normal(scale=0.005, size=images.shape), 0, 0.99)
    found = calibrated_stereo(images[:, None], lights)
    scaled = (found.surface.normals * found.surface.albedo[..., None])[0].astype(np.float64)

    def cost(pixel: int, b: np.ndarray) -> float:
        lit = (images[:, pixel] - np.maximum(lights @ b, 0)) ** 2
        return float(np.minimum(lit, images[:, pixel] ** 2).sum())

    best = np.full(60, np.inf)
    for chosen in product([False, True], repeat=6):
        rows = np.array(chosen)
        if rows.sum() >= 3:
            every = np.linalg.lstsq(lights[rows], images[rows], rcond=None)[0].T
            best = np.minimum(best, [cost(pixel, every[pixel]) for pixel in range(60)])
    ours = np.array([cost(pixel, scaled[pixel]) for pixel in range(60)])
    sure = found.determined[0]
    assert sure.sum() > 50
    assert (ours >= best - 1e-7)[sure].all()
    assert np.mean(ours[sure] <= best[sure] + 1e-7) > 0.95  # a pixel or two may end in another local minimum


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_turning_the_lights_turns_the_normals(seed: int) -> None:
    random = np.random.default_rng(seed)
    turn = Rotation.random(rng=random).as_matrix()
    lights = wide_lights(8, seed)
    images = random.uniform(0.05, 0.95, (8, 5, 6))
    straight, turned = calibrated_stereo(images, lights), calibrated_stereo(images, lights @ turn.T)
    assert_allclose(turned.surface.normals, straight.surface.normals @ turn.T, atol=2e-5)
    assert_allclose(turned.surface.albedo, straight.surface.albedo, rtol=1e-5, atol=1e-6)
    assert_array_equal(turned.used, straight.used)


@settings(max_examples=25, deadline=None)
@given(scale=st.floats(0.01, 1), seed=st.integers(0, 1000))
def test_a_darker_picture_is_a_darker_albedo(scale: float, seed: int) -> None:
    images, lights = np.random.default_rng(seed).uniform(0.05, 0.95, (6, 4, 4)), wide_lights(6, 7)
    bright, dark = calibrated_stereo(images, lights), calibrated_stereo(scale * images, lights)
    assert_allclose(dark.surface.albedo, scale * bright.surface.albedo, rtol=1e-5)
    assert_allclose(dark.surface.normals, bright.surface.normals, atol=1e-5)


def test_a_pixel_with_two_lit_images_is_shaded_and_reported() -> None:
    lights = np.array([[0.8, 0, 0.6], [0, 0.8, 0.6], [-0.8, 0, 0.6], [0, -0.8, 0.6]])
    images = np.array([0.3, 0.3, 0.0, 0.0]).reshape(4, 1, 1)
    found = calibrated_stereo(images, lights)
    assert not found.determined.any()
    assert found.used[0, 0] >= 3
    assert found.surface.albedo[0, 0] > 0
    assert_allclose(found.surface.normals[0, 0, 0], found.surface.normals[0, 0, 1], atol=1e-6)


def test_a_pixel_saturated_everywhere_is_solved_and_reported() -> None:
    found = calibrated_stereo(np.ones((7, 2, 2)), narrow_lights())
    assert not found.determined.any()
    assert (found.used == 7).all()
    assert_allclose(found.surface.normals[0, 0], [0, 0, 1], atol=0.1)


def test_a_black_pixel_has_no_albedo_and_faces_the_camera() -> None:
    found = calibrated_stereo(np.zeros((7, 3, 2)), narrow_lights())
    assert not found.determined.any()
    assert not found.surface.albedo.any()
    assert_array_equal(found.surface.normals, np.tile([0, 0, 1], (3, 2, 1)))


def test_a_mask_keeps_its_pixels_only_and_what_is_outside_may_be_anything() -> None:
    normals, inside = sphere()
    lights = wide_lights(8, 8)
    images = photographs(normals, np.full(inside.shape, 0.5), lights)
    whole = calibrated_stereo(images, lights)
    images[:, ~inside] = np.nan
    found = calibrated_stereo(images, lights, inside)
    assert_array_equal(found.surface.mask, inside)
    assert_array_equal(found.surface.normals[inside], whole.surface.normals[inside])
    assert not found.used[~inside].any()
    assert not found.residual[~inside].any()
    assert not found.determined[~inside].any()


def test_pixels_beyond_one_chunk_come_out_in_order(monkeypatch: pytest.MonkeyPatch) -> None:
    images, lights = np.random.default_rng(9).uniform(0.1, 0.9, (5, 13, 11)), wide_lights(5, 9)
    whole = calibrated_stereo(images, lights)
    monkeypatch.setattr("harmonicface.stereo.known.calibrated.CHUNK", 50)
    parts = calibrated_stereo(images, lights)
    assert_allclose(parts.surface.normals, whole.surface.normals, atol=1e-6)
    assert_array_equal(parts.used, whole.used)


def test_results_are_float32() -> None:
    found = calibrated_stereo(np.full((3, 2, 2), 0.4), np.eye(3))
    assert {found.surface.normals.dtype, found.surface.albedo.dtype, found.residual.dtype} == {np.dtype(np.float32)}


IMAGES, LIGHTS = np.full((4, 3, 5), 0.5), wide_lights(4, 10)
IN_A_PLANE = np.array([[0, 0, 1], [0.6, 0, 0.8], [-0.6, 0, 0.8], [0.8, 0, 0.6]])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: calibrated_stereo(IMAGES[0], LIGHTS), "images: expected an array of shape (n, h, w), got"),
        (lambda: calibrated_stereo(IMAGES[:, :0], LIGHTS), "images: expected an array of shape (n, h, w), got"),
        (
            lambda: calibrated_stereo(IMAGES[:2], LIGHTS[:2]),
            "images: expected at least 3 under different lights, got 2",
        ),
        (
            lambda: calibrated_stereo(IMAGES, LIGHTS[:3]),
            "lights: expected one vector an image, shape (4, 3), got (3, 3)",
        ),
        (
            lambda: calibrated_stereo(IMAGES, LIGHTS * [[1], [0], [1], [1]]),
            "lights: expected directions, got a vector of",
        ),
        (
            lambda: calibrated_stereo(IMAGES, IN_A_PLANE),
            "lights: expected directions that span space, got 4 near one plane",
        ),
        (lambda: calibrated_stereo(IMAGES, LIGHTS * np.nan), "lights: expected finite numbers"),
        (
            lambda: calibrated_stereo(IMAGES * np.nan, LIGHTS),
            "images: expected finite intensities in the mask, got NaN",
        ),
        (lambda: calibrated_stereo(IMAGES * 255, LIGHTS), "images: expected intensities up to saturation=1, got 127.5"),
        (lambda: calibrated_stereo(IMAGES, LIGHTS, saturation=0), "saturation: expected a number above 0, got 0"),
        (
            lambda: calibrated_stereo(IMAGES, LIGHTS, saturation=np.nan),
            "saturation: expected a number above 0, got nan",
        ),
        (lambda: calibrated_stereo(IMAGES, LIGHTS, np.zeros((3, 5), bool)), "mask: expected at least one pixel"),
        (
            lambda: calibrated_stereo(IMAGES, LIGHTS, np.ones((5, 3), bool)),
            "mask: expected a boolean mask of shape (3, 5)",
        ),
    ],
)
def test_bad_input_is_one_line(call: Callable[[], object], message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=re.escape(message)) as error:
        call()
    assert "\n" not in str(error.value)
