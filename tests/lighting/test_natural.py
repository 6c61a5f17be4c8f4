"""Random environments: seeded, of unit mean irradiance, lit from above, nearly all in nine harmonics."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import harmonicface as hf

NORMALS = np.random.default_rng(1).normal(size=(300, 3))
NORMALS /= np.linalg.norm(NORMALS, axis=1, keepdims=True)


def test_a_seed_is_a_light() -> None:
    assert_array_equal(hf.lights.natural(3).radiance, hf.lights.natural(3).radiance)
    assert_array_equal(hf.lights.natural(np.random.default_rng(3)).radiance, hf.lights.natural(3).radiance)
    assert not np.array_equal(hf.lights.natural(3).radiance, hf.lights.natural(4).radiance)


def test_a_generator_is_drawn_from() -> None:
    generator = np.random.default_rng(0)
    assert not np.array_equal(hf.lights.natural(generator).radiance, hf.lights.natural(generator).radiance)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("size", [1, 8, 32])
def test_the_mean_irradiance_over_all_normals_is_one(seed: int, size: int) -> None:
    light = hf.lights.natural(seed, size)
    assert light.radiance.shape == (size, 2 * size)
    assert_allclose(light.coefficients(0)[0] * np.sqrt(4 * np.pi) / 4, 1, rtol=1e-12)


def test_most_light_comes_from_above() -> None:
    up = [hf.lights.natural(seed).coefficients(1)[1] for seed in range(40)]
    assert np.mean(np.array(up) > 0) > 0.75


def test_nine_harmonics_hold_nearly_all_of_the_irradiance() -> None:
    shares = []
    for seed in range(12):
        light = hf.lights.natural(seed)
        exact = light.irradiance(NORMALS)
        error = hf.HarmonicLight(light.coefficients(2)).irradiance(NORMALS) - exact
        shares.append(np.mean(error**2) / np.mean(exact**2))
    # a single lamp, the hardest light, leaves 0.78 % of the energy
    assert max(shares) < 0.0078
    assert np.mean(shares) < 0.004


@pytest.mark.parametrize("seed", [-1, 0.5, "noon", None])
def test_a_seed_that_is_none(seed: int) -> None:
    with pytest.raises(hf.HarmonicFaceError, match="seed: expected an integer of at least 0, got"):
        hf.lights.natural(seed)


def test_no_size() -> None:
    with pytest.raises(hf.HarmonicFaceError, match="size: expected an integer of at least 1, got int 0"):
        hf.lights.natural(0, size=0)
