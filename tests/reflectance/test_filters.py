"""The Lambertian filter against quadrature, and how much of its energy each order holds."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import quad
from scipy.special import eval_legendre, gammaln

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import degrees
from harmonicface.reflectance.filters import lambertian_filter, lambertian_weights


@pytest.mark.parametrize("degree", range(21))
def test_equal_to_the_integral_over_the_hemisphere(degree: int) -> None:
    integral = 2 * np.pi * quad(lambda t: eval_legendre(degree, t) * t, 0, 1, epsabs=1e-13, limit=200)[0]
    assert_allclose(lambertian_filter(20)[degree], integral, rtol=0, atol=1e-11)


def test_the_papers_values() -> None:
    expected = np.pi * np.array([1, 2 / 3, 1 / 4, 0, -1 / 24, 0, 1 / 64])
    assert_allclose(lambertian_filter(6), expected, rtol=1e-15)


def test_odd_degrees_are_exactly_nothing() -> None:
    assert_array_equal(lambertian_filter(101)[3::2], 0.0)


@pytest.mark.parametrize(("order", "percent"), [(0, 37.50), (1, 87.50), (2, 99.22), (4, 99.80)])
def test_energy_captured(order: int, percent: float) -> None:
    # the energy of max(cos, 0) is its squared integral, 2 pi / 3; each degree holds (2l + 1) A_l^2 / 4 pi of it
    energies = (2 * np.arange(order + 1) + 1) * lambertian_filter(order) ** 2 / (4 * np.pi)
    assert round(100 * energies.sum() / (2 * np.pi / 3), 2) == percent


def test_all_degrees_together_hold_all_energy() -> None:
    energies = (2 * np.arange(401) + 1) * lambertian_filter(400) ** 2 / (4 * np.pi)
    assert_allclose(energies.sum(), 2 * np.pi / 3, rtol=1e-6)


def test_the_series_is_the_clamped_cosine() -> None:
    cosines = np.linspace(-1, 1, 41)
    terms = [
        (2 * degree + 1) / (4 * np.pi) * value * eval_legendre(degree, cosines)
        for degree, value in enumerate(lambertian_filter(200))
    ]
    assert_allclose(np.sum(terms, axis=0), np.maximum(cosines, 0), rtol=0, atol=2e-3)


def test_order_one_thousand_by_the_closed_form() -> None:
    # 2 pi (-1)^(l/2 - 1) / ((l + 2) (l - 1)) l! / (2^l (l/2)!^2), the factorials by their logarithms
    degree = np.arange(2, 1001, 2)
    bracket = np.exp(gammaln(degree + 1) - degree * np.log(2) - 2 * gammaln(degree / 2 + 1))
    closed = 2 * np.pi * (-1.0) ** (degree // 2 - 1) / ((degree + 2) * (degree - 1)) * bracket
    assert_allclose(lambertian_filter(1000)[2::2], closed, rtol=1e-11, atol=0)


def test_the_tail_falls_with_its_constant() -> None:
    degree = np.arange(2, 100_001, 2)
    scaled = lambertian_filter(100_000)[2::2] * degree**2.5 * (-1.0) ** (degree // 2 - 1)
    assert_allclose(scaled[-1], 2 * np.sqrt(2 * np.pi), rtol=3e-5)
    rates = np.diff(np.log(np.abs(scaled[[499, 4999, 49999]])))
    assert np.abs(rates).max() < 1e-3 * np.log(10)  # no power of l is left


def test_the_fourth_degree_is_four_percent_of_the_first() -> None:
    assert_allclose(abs(lambertian_filter(4)[4] / lambertian_filter(4)[0]), 1 / 24, rtol=1e-15)


@pytest.mark.parametrize("order", range(6))
def test_a_weight_for_each_harmonic_and_the_same_filter_at_any_order(order: int) -> None:
    assert_array_equal(lambertian_filter(order), lambertian_filter(20)[: order + 1])
    assert_array_equal(lambertian_weights(order), lambertian_filter(20)[degrees(order)])


@pytest.mark.parametrize("function", [lambertian_filter, lambertian_weights])
def test_no_order(function) -> None:
    with pytest.raises(HarmonicFaceError, match="order: expected an integer of at least 0, got int -1"):
        function(-1)


def test_no_order_beyond_reason() -> None:
    with pytest.raises(HarmonicFaceError, match="order: expected at most 1000000, got 1000000000000"):
        lambertian_filter(10**12)


def test_weights_beyond_the_memory() -> None:
    with pytest.raises(HarmonicFaceError, match=r"weights of order 1000000: need 1.6e\+04 GB of memory"):
        lambertian_weights(10**6)
