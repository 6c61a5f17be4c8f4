"""Coefficients of latitude-longitude maps: separable sums against one harmonic a pixel."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.lighting import _latlong_coefficients


@pytest.mark.parametrize("order", [0, 1, 2, 3, 4, 7, 12])
@pytest.mark.parametrize("shape", [(1, 1), (2, 4, 3), (7, 5), (16, 32, 3)])
def test_against_a_sum_over_pixels(order: int, shape: tuple[int, ...]) -> None:
    light = hf.EnvironmentMap(np.random.default_rng(order).gamma(0.3, 1.0, shape))
    expected = np.tensordot(real_harmonics(light.directions, order), light.strengths, 2)
    assert_allclose(light.coefficients(order), expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_single_precision_and_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    radiance = np.random.default_rng(1).gamma(0.3, 1.0, (64, 128, 3)).astype(np.float32)
    exact = hf.EnvironmentMap(radiance.astype(np.float64)).coefficients(2)
    found = hf.EnvironmentMap(radiance).coefficients(2)
    assert found.dtype == np.float64
    assert_allclose(found, exact, rtol=0, atol=1e-6 * exact[0].max())
    monkeypatch.setattr(_latlong_coefficients, "BLOCK", 1)
    assert_allclose(hf.EnvironmentMap(radiance).coefficients(2), exact, rtol=0, atol=1e-6 * exact[0].max())


def test_a_view_is_summed_as_what_it_shows() -> None:
    whole = np.random.default_rng(2).uniform(size=(8, 32, 3))
    expected = hf.EnvironmentMap(whole[::2, ::2].copy()).coefficients(2)
    assert_allclose(hf.EnvironmentMap(whole[::2, ::2]).coefficients(2), expected, rtol=1e-14)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, -1e-30])
def test_one_bad_pixel_is_found(bad: float) -> None:
    radiance = np.ones((512, 1024, 3), np.float32)
    radiance[300, 700, 1] = bad
    with pytest.raises(hf.HarmonicFaceError, match="radiance: expected"):
        hf.EnvironmentMap(radiance)


def test_a_sky_and_a_sun_at_order_40_of_a_map_with_fewer_columns() -> None:
    light = hf.EnvironmentMap(np.random.default_rng(3).uniform(size=(12, 24)))
    expected = np.tensordot(real_harmonics(light.directions, 40), light.strengths, 2)
    assert_allclose(light.coefficients(40), expected, rtol=0, atol=1e-11)


def test_sums_beyond_single_precision() -> None:
    radiance = np.full((64, 128), 1e30, np.float32)
    assert_allclose(hf.EnvironmentMap(radiance).coefficients(2)[0], 1e30 * np.sqrt(4 * np.pi), rtol=1e-6)
