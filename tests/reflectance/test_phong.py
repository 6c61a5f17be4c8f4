"""The Phong filter against exact fractions, quadrature, gamma functions and its limits."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import quad
from scipy.special import eval_legendre, gamma, gammaln, gammasgn

from harmonicface.errors import HarmonicFaceError
from harmonicface.reflectance.filters import lambertian_filter
from harmonicface.reflectance.phong import phong_filter, phong_gaussian, phong_lobe, phong_sensitivity


def exact_filter(shininess: int, order: int) -> list[Fraction]:
    """(s + 1) times the integral of u^s P_l(u), from the coefficients of the Legendre polynomials."""
    below, current = [Fraction(0)], [Fraction(1)]
    result = []
    for degree in range(order + 1):
        result.append((shininess + 1) * sum(c / (k + shininess + 1) for k, c in enumerate(current)))
        raised = [Fraction(0), *current]
        padded = below + [Fraction(0)] * (len(raised) - len(below))
        below, current = (
            current,
            [
                (Fraction(2 * degree + 1) * a - Fraction(degree) * b) / (degree + 1)
                for a, b in zip(raised, padded, strict=True)
            ],
        )
    return result


@pytest.mark.parametrize("shininess", [0, 1, 2, 3, 10, 57])
def test_equal_to_exact_fractions_and_zero_where_they_are(shininess: int) -> None:
    exact = exact_filter(shininess, 40)
    values = phong_filter(shininess, 40)
    assert_allclose(values, [float(value) for value in exact], rtol=1e-14, atol=0)
    assert_array_equal(values == 0, [value == 0 for value in exact])
    zeros = [degree for degree in range(41) if degree > shininess and (degree - shininess) % 2 == 0]
    assert_array_equal(np.flatnonzero(values == 0), zeros)


@pytest.mark.parametrize("shininess", [0.5, 2.5, 7.3, 100.25])
@pytest.mark.parametrize("degree", [0, 1, 2, 3, 8, 15])
def test_equal_to_the_integral_at_any_real_exponent(shininess: float, degree: int) -> None:
    integral = (shininess + 1) * quad(lambda u: u**shininess * eval_legendre(degree, u), 0, 1, epsabs=1e-13)[0]
    assert_allclose(phong_filter(shininess, 15)[degree], integral, rtol=0, atol=1e-11)


@pytest.mark.parametrize("shininess", [0.5, 33.3, 1000.7])
def test_equal_to_gamma_functions(shininess: float) -> None:
    degree = np.arange(301)
    first, second = 1 + (shininess - degree) / 2, (degree + shininess + 3) / 2
    logarithm = gammaln(1 + shininess) - gammaln(first) - gammaln(second) - (shininess + 1) * np.log(2)
    closed = (shininess + 1) * np.sqrt(np.pi) * gammasgn(first) * np.exp(logarithm)
    assert_allclose(phong_filter(shininess, 300), closed, rtol=1e-10, atol=0)


def test_the_papers_products() -> None:
    s = 7.5  # equation 78, written out
    expected = [
        1,
        (s + 1) / (s + 2),
        s / (s + 3),
        (s + 1) * (s - 1) / ((s + 4) * (s + 2)),
        s * (s - 2) / ((s + 5) * (s + 3)),
    ]
    assert_allclose(phong_filter(s, 4), expected, rtol=1e-15)


def test_a_matte_surface_is_shininess_one() -> None:
    assert_allclose(np.pi * phong_filter(1, 1000), lambertian_filter(1000), rtol=1e-12, atol=0)


@pytest.mark.parametrize("shininess", [0.0, 0.5, 1.0, 2.0, 50.0, 1e6, 1e300])
def test_finite_at_any_degree(shininess: float) -> None:
    values = phong_filter(shininess, 100_000)
    assert np.isfinite(values).all() and np.abs(values).max() == 1


@pytest.mark.parametrize("shininess", [0.5, 1.0, 2.0, 3.7])
def test_the_tail_falls_as_it_says(shininess: float) -> None:
    degree = np.arange(2000, 2004)
    tail = gamma(shininess + 2) * np.sqrt(2 / np.pi) * np.sin(np.pi * (degree - shininess) / 2)
    values = phong_filter(shininess, 2003)[degree] * degree ** (shininess + 1.5)
    assert_allclose(values, tail, rtol=3e-3, atol=1e-9)


def test_a_mirror_in_the_limit() -> None:
    assert_allclose(phong_filter(1e12, 100), 1, rtol=0, atol=1e-8)


def test_the_lobe_has_unit_energy_and_its_series_is_the_lobe() -> None:
    for shininess in (0.0, 1.5, 20.0):
        energy = 2 * np.pi * quad(lambda u, s=shininess: float(phong_lobe(u, s)), 0, 1)[0]
        assert_allclose(energy, 1, rtol=1e-10)
    cosines = np.linspace(-1, 1, 33)
    series = (2 * np.arange(81) + 1) / (4 * np.pi) * phong_filter(20, 80)
    assert_allclose(np.polynomial.legendre.legval(cosines, series), phong_lobe(cosines, 20), rtol=0, atol=1e-9)


def test_the_readmes_of_the_gaussians() -> None:
    # s = 50, l = 5: exact .747, equation 81 gives .779, with the linear term .741
    assert round(phong_filter(50, 5)[5], 3) == 0.747
    values = [round(phong_gaussian(50, 5, form)[5], 3) for form in ("paper", "linear", "matched")]
    assert values == [0.779, 0.741, 0.747]


@pytest.mark.parametrize("shininess", [1e2, 1e4, 1e6])
def test_the_logarithms_expansion_has_a_linear_term(shininess: float) -> None:
    # equation 80 has -l^2 (1/2s - 1/2s^2), wrong in the leading order of 1/s; -l (l + 1) / (2s + 3) is right to 1/s^2
    degree = np.arange(1, 8)
    logarithm = np.log(phong_filter(shininess, 7)[1:])
    papers = -(degree**2) * (1 / (2 * shininess) - 1 / (2 * shininess**2))
    assert_allclose((logarithm - papers) * 2 * shininess, -degree, rtol=0, atol=60 / shininess)
    better = -degree * (degree + 1) / (2 * shininess + 3)
    assert (np.abs(logarithm - better) < degree**4 * (degree + 1) / shininess**3 + 1e-14).all()


@pytest.mark.parametrize(
    ("shininess", "errors"), [(10, [0.050, 0.042, 0.016]), (50, [0.033, 0.009, 0.0035]), (200, [0.019, 0.002, 0.0009])]
)
def test_the_errors_of_the_gaussians(shininess: float, errors: list[float]) -> None:
    exact = phong_filter(shininess, 200)
    found = [np.abs(phong_gaussian(shininess, 200, form) - exact).max() for form in ("paper", "linear", "matched")]
    assert_allclose(found, errors, rtol=0.15)


def test_the_matched_gaussian_has_the_exact_degree_one() -> None:
    assert_allclose(phong_gaussian(3.3, 1), phong_filter(3.3, 1), rtol=1e-15)


@settings(max_examples=50, deadline=None)
@given(st.floats(0.1, 500), st.integers(0, 60))
def test_the_sensitivity_is_the_slope(shininess: float, order: int) -> None:
    step = 1e-5 * shininess
    slope = (phong_filter(shininess + step, order) - phong_filter(shininess - step, order)) / (2 * step)
    assert_allclose(phong_sensitivity(shininess, order), slope, rtol=1e-5, atol=1e-9 / shininess)


def test_the_sensitivity_where_the_filter_is_zero() -> None:
    assert phong_filter(2, 4)[4] == 0
    assert_allclose(phong_sensitivity(2, 4)[4], 0.4 / 7, rtol=1e-14)  # f_4 = f_2 (s - 2) / (s + 5)


@pytest.mark.parametrize("value", [-1, np.nan, np.inf])
@pytest.mark.parametrize("function", [phong_filter, phong_sensitivity, lambda s, _: phong_lobe([1.0], s)])
def test_no_shininess(function, value: float) -> None:
    with pytest.raises(HarmonicFaceError, match="shininess: expected a finite number of at least 0, got"):
        function(value, 3)


def test_other_bad_input() -> None:
    with pytest.raises(HarmonicFaceError, match="shininess: expected a number of at least 0, got str 'high'"):
        phong_filter("high", 2)
    with pytest.raises(HarmonicFaceError, match="shininess: expected a finite number above 0, got 0"):
        phong_gaussian(0, 2)
    with pytest.raises(HarmonicFaceError, match="order: expected an integer of at least 0, got int -1"):
        phong_filter(2, -1)
    with pytest.raises(HarmonicFaceError, match="order: expected at most 1000000, got 1000000000000"):
        phong_filter(2, 10**12)
    with pytest.raises(HarmonicFaceError, match="form: expected paper, linear or matched, got str 'best'"):
        phong_gaussian(2, 2, "best")
    with pytest.raises(HarmonicFaceError, match="cosines: expected finite numbers"):
        phong_lobe([np.nan], 2)


@pytest.mark.parametrize("cosine", [2.0, -1.1])
def test_cosines_that_are_none(cosine: float) -> None:
    with pytest.raises(HarmonicFaceError, match=f"cosines: expected numbers from -1 to 1, got {cosine:.6g}"):
        phong_lobe([0.5, cosine], 50)


def test_a_huge_shininess() -> None:
    assert not phong_sensitivity(1e200, 5).any()  # l (l + 1) / 2 s^2 is below the smallest float
    assert_allclose(phong_sensitivity(1e100, 3), np.array([0, 1, 3, 6]) * 1e-200, rtol=1e-12)
    with pytest.raises(HarmonicFaceError, match="shininess: expected a finite number of at least 0, got infinity"):
        phong_filter(10**400, 2)
