from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.environment import EnvironmentMap
from harmonicface.lighting.light import HarmonicLight
from harmonicface.lighting.lights import ambient, directional, natural
from harmonicface.lighting.published import published
from harmonicface.stereo.general_light import general_light_normals, light_coefficients


def pixels(count: int = 300) -> tuple[np.ndarray, np.ndarray]:
    """Unit normals before the camera, and albedo."""
    generator = np.random.default_rng(0)
    normals = generator.normal(size=(count, 3)) * [0.6, 0.6, 0.2] + [0, 0, 1]
    return normals / np.linalg.norm(normals, axis=1, keepdims=True), generator.uniform(0.2, 0.9, count)


def degrees(found: np.ndarray, true: np.ndarray) -> np.ndarray:
    unit = found / np.linalg.norm(found, axis=1, keepdims=True)
    return np.degrees(2 * np.arcsin(np.clip(np.linalg.norm(unit - true, axis=1) / 2, 0, 1)))


@pytest.mark.parametrize("order", [1, 2])
def test_what_follows_the_model_is_exact(order: int) -> None:
    normals, albedo = pixels()
    skies = [published("grace").rotated(turn) for turn in Rotation.random(10, random_state=1)]
    lights = [HarmonicLight(sky.coefficients(order).mean(axis=1)) for sky in skies]
    images = np.stack([albedo * light.irradiance(normals) for light in lights])
    found = general_light_normals(images, lights, order)
    assert degrees(found.scaled, normals).max() < 1e-3
    assert_allclose(np.linalg.norm(found.scaled, axis=1), albedo, rtol=1e-5)
    assert found.residual.max() < 1e-6
    assert found.confidence.max() < 1e-3
    assert_array_equal(found.used, 10)


def test_natural_light_is_nearly_of_second_order() -> None:
    normals, albedo = pixels()
    lights = [natural(seed) for seed in range(12)]
    images = np.stack([light.irradiance(normals) for light in lights])
    images = albedo * (images if images.ndim == 2 else images.mean(axis=2))
    second = degrees(general_light_normals(images, lights).scaled, normals).mean()
    first = degrees(general_light_normals(images, lights, 1).scaled, normals).mean()
    assert second < 3
    assert second < first


def test_the_standard_error_is_that_of_noise() -> None:
    normal = np.array([[0.36, 0.48, 0.8]])
    lights = [published("st_peters").rotated(turn) for turn in Rotation.random(20, random_state=2)]
    shades = np.stack([HarmonicLight(light.coefficients(2).mean(axis=1)).irradiance(normal) for light in lights])
    images = 0.5 * shades + 0.02 * np.random.default_rng(3).normal(size=(20, 500))
    found = general_light_normals(images, lights)
    error = degrees(found.scaled, normal)
    assert 0.7 < np.sqrt(np.mean(error**2)) / np.median(found.confidence) < 1.4


def test_maps_names_lamps_and_coefficients_are_lights() -> None:
    sky = EnvironmentMap(np.random.default_rng(4).random((16, 32, 3)))
    found = light_coefficients([sky, "grace", [0.0, 0.6, 0.8], ambient(1.0), directional([1, 0, 1]), np.arange(9.0)])
    assert found.shape == (6, 9)
    assert_allclose(found[0], sky.coefficients(2).mean(axis=1), rtol=1e-6)
    assert_allclose(found[5], np.arange(9.0))
    assert_array_equal(light_coefficients(found, 1), found[:, :4])
    assert_array_equal(light_coefficients(["grace"]), light_coefficients("grace"))


def test_saturated_observations_are_left_out() -> None:
    normals, albedo = pixels()
    lights = [
        HarmonicLight(published("grace").rotated(t).coefficients(2)[:, 0]) for t in Rotation.random(12, random_state=5)
    ]
    images = np.stack([albedo * light.irradiance(normals) for light in lights])
    ceiling = np.quantile(images, 0.9)
    burnt = np.minimum(images, ceiling)
    found = general_light_normals(burnt, lights, saturation=ceiling)
    enough = found.used >= 8
    assert enough.mean() > 0.8
    assert np.median(degrees(found.scaled, normals)[enough]) < 1e-3
    masked = general_light_normals(burnt, lights, usable=burnt < ceiling)
    assert_array_equal(masked.scaled, found.scaled)
    assert np.median(degrees(general_light_normals(burnt, lights).scaled, normals)[(found.used < 12)]) > 0.5


def test_a_pixel_without_enough_observations_is_undetermined() -> None:
    normals, albedo = pixels(4)
    lights = [published("grace").rotated(turn) for turn in Rotation.random(5, random_state=6)]
    images = np.stack([albedo * light.irradiance(normals).mean(axis=1) for light in lights])
    usable = np.ones(images.shape, bool)
    usable[2:, 0] = False
    images[:, 1] = 0
    found = general_light_normals(images, lights, usable=usable)
    assert np.isinf(found.confidence[:2]).all()
    assert np.isfinite(found.confidence[2:]).all()
    assert_array_equal(
        general_light_normals(images[:3], lights[:3]).confidence, np.inf
    )  # nothing is left to tell noise


def test_what_cannot_be_solved_is_refused() -> None:
    images = np.ones((4, 5))
    lights = [published("grace").rotated(turn) for turn in Rotation.random(4, random_state=7)]
    with pytest.raises(HarmonicFaceError, match="order: expected 1 or 2, got int 3"):
        general_light_normals(images, lights, 3)
    with pytest.raises(HarmonicFaceError, match="at least 3, got 2"):
        general_light_normals(images[:2], lights[:2])
    with pytest.raises(HarmonicFaceError, match="one a photograph, 4, got 3"):
        general_light_normals(images, lights[:3])
    with pytest.raises(HarmonicFaceError, match="no mixtures of the others, got 1"):
        general_light_normals(images, [factor * lights[0] for factor in (1, 2, 3, 4)])
    with pytest.raises(HarmonicFaceError, match="9 coefficients or more"):
        general_light_normals(images, np.ones((4, 4)))
    with pytest.raises(HarmonicFaceError, match="light: expected"):
        general_light_normals(images, ["nowhere"] * 4)
