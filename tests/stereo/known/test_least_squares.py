from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harmonicface.stereo.known.least_squares import plain_least_squares, scaled_normals


def test_agrees_with_the_library_solver_pixel_by_pixel() -> None:
    random = np.random.default_rng(1)
    lights, observations = random.normal(size=(6, 3)), random.normal(size=(6, 50))
    weights = random.uniform(0.1, 2, (6, 50))
    scaled, _ = scaled_normals(observations, lights, weights)
    for pixel in range(50):
        root = np.sqrt(weights[:, pixel])
        expected = np.linalg.lstsq(root[:, None] * lights, root * observations[:, pixel], rcond=None)[0]
        assert_allclose(scaled[pixel], expected, rtol=1e-9, atol=1e-12)


def test_a_weight_of_zero_leaves_an_observation_out() -> None:
    random = np.random.default_rng(2)
    lights, observations = random.normal(size=(5, 3)), random.normal(size=(5, 4))
    weights = np.ones((5, 4), bool)
    weights[2] = False
    without = np.delete(np.arange(5), 2)
    assert_allclose(
        scaled_normals(observations, lights, weights)[0],
        scaled_normals(observations[without], lights[without])[0],
        rtol=1e-12,
    )


@pytest.mark.parametrize("spread", [1.0, 0.2])
def test_gain_is_the_error_that_noise_leaves(spread: float) -> None:
    random = np.random.default_rng(3)
    lights = np.array([0, 0, 1.0]) + spread * random.normal(size=(7, 3))
    lights /= np.linalg.norm(lights, axis=1, keepdims=True)
    noise = random.normal(scale=0.01, size=(7, 40_000))
    scaled, gain = scaled_normals(noise, lights)
    assert_allclose(np.sqrt((scaled**2).sum(axis=1).mean()), 0.01 * gain[0], rtol=0.02)
    assert_allclose(gain[0], np.sqrt((np.linalg.svd(lights, compute_uv=False) ** -2.0).sum()), rtol=1e-9)


def test_gain_does_not_know_the_unit_of_brightness() -> None:
    lights = np.array([[0.6, 0, 0.8], [0, 0.6, 0.8], [-0.6, 0, 0.8], [0, 0, 1.0]])
    observations = np.zeros((4, 1))
    assert_allclose(scaled_normals(observations, 1e4 * lights)[1], scaled_normals(observations, lights)[1], rtol=1e-9)


@pytest.mark.parametrize(
    "weights",
    [[1, 1, 0, 0], [0, 0, 0, 0], [1, 1, 1, 0]],
    ids=["two lights", "no light", "three lights in a plane"],
)
def test_too_little_light_has_infinite_gain_and_no_number_made_up(weights: list[int]) -> None:
    lights = np.array([[0.6, 0, 0.8], [0, 0, 1.0], [-0.6, 0, 0.8], [0, 0.6, 0.8]])
    scaled, gain = scaled_normals(np.ones((4, 1)), lights, np.array(weights, bool)[:, None])
    assert np.isposinf(gain).all()
    assert not scaled.any()


@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float32, 2e-6), (np.float64, 1e-12)])
def test_one_product_is_the_least_squares_solution(dtype: type, tolerance: float) -> None:
    generator = np.random.default_rng(5)
    lights, observations = generator.normal(size=(96, 3)), generator.random((96, 40000)).astype(dtype)
    found = plain_least_squares(observations, lights)
    assert found.dtype == dtype
    assert_allclose(found.T, np.linalg.lstsq(lights, observations.astype(np.float64), rcond=None)[0], atol=tolerance)


@pytest.mark.parametrize("brightness", [2.0**-200, 2.0**200, 1e-100, 1e100])
def test_the_unit_of_the_lamps_does_not_matter(brightness: float) -> None:
    random = np.random.default_rng(8)
    lights, observations = random.normal(size=(6, 3)), random.normal(size=(6, 20))
    expected, gain = scaled_normals(observations, lights)
    scaled, other = scaled_normals(observations, brightness * lights)
    assert_allclose(brightness * scaled, expected, rtol=1e-12)
    assert_allclose(other, gain, rtol=1e-12)
