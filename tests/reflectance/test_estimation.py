"""A material's filter from its reflection: exact, over all modes, with honest uncertainty, and silent where it must."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import degrees
from harmonicface.reflectance.estimation import estimate_reflectance
from harmonicface.reflectance.filters import lambertian_filter
from harmonicface.reflectance.phong import phong_filter
from harmonicface.reflectance.spectra import apply_filter, degree_norms, directional_spectrum, uniform_spectrum


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 8), st.integers(0, 2**32 - 1))
def test_exact_without_noise(order: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    light, filter_ = random.normal(size=(order + 1) ** 2), random.normal(size=order + 1)
    estimate = estimate_reflectance(apply_filter(filter_, light), light, noise=0.0)
    assert_allclose(estimate.filter.filled(np.nan), filter_, rtol=1e-12, atol=1e-14)
    assert estimate.lost == () and estimate.residual < 1e-14
    assert_allclose(estimate.coefficients * degree_norms(order), filter_, rtol=1e-12, atol=1e-14)


def test_equal_to_least_squares_and_its_covariance() -> None:
    random = np.random.default_rng(0)
    light, reflected = random.normal(size=49), random.normal(size=49)
    design = np.where(degrees(6)[:, None] == np.arange(7), light[:, None], 0)
    solution, squares, *_ = np.linalg.lstsq(design, reflected, rcond=None)
    estimate = estimate_reflectance(reflected, light)
    assert_allclose(estimate.filter.filled(np.nan), solution, rtol=1e-12)
    assert_allclose(estimate.noise, np.sqrt(squares[0] / (49 - 7)), rtol=1e-12)
    assert_allclose(estimate.residual, np.sqrt(squares[0] / 49), rtol=1e-12)
    covariance = estimate.noise**2 * np.linalg.inv(design.T @ design)
    assert_allclose(estimate.std, np.sqrt(np.diag(covariance)), rtol=1e-12)


def test_the_uncertainty_is_the_scatter() -> None:
    random = np.random.default_rng(1)
    light = directional_spectrum([1, 2, 3], 5)
    exact = apply_filter(phong_filter(9, 5), light)
    estimates = [estimate_reflectance(exact + 0.01 * random.normal(size=36), light) for _ in range(600)]
    scatter = np.std([estimate.filter.filled(np.nan) for estimate in estimates], axis=0)
    assert_allclose(scatter, estimate_reflectance(exact, light, noise=0.01).std, rtol=0.08)
    assert_allclose(np.mean([estimate.noise for estimate in estimates]), 0.01, rtol=0.03)


def test_uniform_light_tells_degree_zero_and_hides_the_rest() -> None:
    estimate = estimate_reflectance(apply_filter(lambertian_filter(4), uniform_spectrum(4)), uniform_spectrum(4), 0.1)
    assert_allclose(estimate.filter[0], np.pi)
    assert_array_equal(np.ma.getmaskarray(estimate.filter), [False, True, True, True, True])
    assert estimate.lost == (1, 2, 3, 4) and np.isinf(estimate.std[1:]).all()
    assert np.ma.getmaskarray(estimate.coefficients)[1:].all()


def test_complex_coefficients_of_a_general_material() -> None:
    # B_lmpq = Lambda_l L_lm rho_lpq, for each p and q by itself
    random = np.random.default_rng(2)
    light = random.normal(size=25) + 1j * random.normal(size=25)
    rho = random.normal(size=(5, 3, 4)) + 1j * random.normal(size=(5, 3, 4))
    rows = degrees(4)
    reflected = degree_norms(4)[rows, None, None] * light[:, None, None] * rho[rows]
    estimate = estimate_reflectance(reflected, light)
    assert_allclose(estimate.coefficients.filled(np.nan), rho, rtol=1e-12)
    assert estimate.filter.shape == (5, 3, 4) and estimate.noise < 1e-14


def test_one_mode_of_a_degree_is_enough() -> None:
    light = np.zeros(9)
    light[[0, 2, 8]] = [1.0, -0.5, 1e-6]
    estimate = estimate_reflectance(apply_filter([1.0, 0.5, 0.25], light), light)
    assert_allclose(estimate.filter.filled(np.nan), [1.0, 0.5, 0.25], rtol=1e-12)


def test_errors() -> None:
    with pytest.raises(HarmonicFaceError, match="reflected: expected as many coefficients as light has"):
        estimate_reflectance(np.ones(4), np.ones(9))
    with pytest.raises(HarmonicFaceError, match="reflected: expected as many coefficients as light has"):
        estimate_reflectance(np.ones((4, 3)), np.ones((4, 3)))
    with pytest.raises(HarmonicFaceError, match="light: expected a coefficient that is not 0"):
        estimate_reflectance(np.ones(4), np.zeros(4))
    with pytest.raises(HarmonicFaceError, match=r"coefficients: expected \(order \+ 1\)\^2"):
        estimate_reflectance(np.ones(5), np.ones(5))
    with pytest.raises(HarmonicFaceError, match="noise: expected a number, since these coefficients leave no residual"):
        estimate_reflectance([1.0], [1.0])
    with pytest.raises(HarmonicFaceError, match="noise: expected a finite number of at least 0, got -1"):
        estimate_reflectance(np.ones(4), np.ones(4), noise=-1)
    with pytest.raises(HarmonicFaceError, match="light: expected finite numbers, got NaN or infinite"):
        estimate_reflectance(np.ones(4), [1, 1j, 0, np.nan])
    with pytest.raises(HarmonicFaceError, match="reflected: expected finite numbers"):
        estimate_reflectance([np.nan, 0, 0, 0], np.ones(4))
