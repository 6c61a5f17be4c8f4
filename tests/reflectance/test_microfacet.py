"""The microfacet filter against adaptive quadrature, its Gaussians and its limits."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.special import eval_legendre

from harmonicface.errors import HarmonicFaceError
from harmonicface.reflectance.microfacet import (
    microfacet_filter,
    microfacet_gaussian,
    microfacet_lobe,
    microfacet_sensitivity,
)


@pytest.mark.parametrize("roughness", [0.05, 0.3, 1.0])
@pytest.mark.parametrize("degree", [0, 1, 2, 7, 40])
def test_equal_to_adaptive_quadrature(roughness: float, degree: int) -> None:
    def integrand(angle: float) -> float:
        lobe = np.exp(-(angle**2) / (4 * roughness**2)) / (2 * roughness**2)
        return lobe * eval_legendre(degree, np.cos(angle)) * np.sin(angle)

    expected = quad(integrand, 0, min(np.pi / 2, 14 * roughness), epsabs=1e-14, limit=400)[0]
    assert_allclose(microfacet_filter(roughness, 40)[degree], expected, rtol=0, atol=1e-13)


def test_degree_and_order_do_not_change_each_other() -> None:
    assert_allclose(microfacet_filter(0.2, 1000)[:31], microfacet_filter(0.2, 30), rtol=0, atol=1e-14)
    assert np.isfinite(microfacet_filter(0.01, 1000)).all()


def test_a_thousand_degrees_by_one_fine_rule() -> None:
    nodes, weights = np.polynomial.legendre.leggauss(1200)
    angles = np.pi / 4 * (nodes + 1)
    lobe = np.pi / 4 * weights * np.exp(-((angles / 0.6) ** 2)) * np.sin(angles) / (2 * 0.3**2)
    degree = np.array([100, 500, 900, 1000])
    expected = eval_legendre(degree[:, None], np.cos(angles)) @ lobe
    assert_allclose(microfacet_filter(0.3, 1000)[degree], expected, rtol=0, atol=1e-14)


def test_a_tiny_lobe_is_a_gaussian_of_the_plane_to_machine_precision() -> None:
    # for small angles P_l(cos t) is J_0((l + 1/2) t) and the integral exp(-(sigma (l + 1/2))^2), with errors of
    # sigma^2; a cosine instead of its complement would lose 1e-11 here
    values = microfacet_filter(1e-7, 1000)
    assert_allclose(values, np.exp(-1e-14 * np.arange(1001) * np.arange(1, 1002)), rtol=0, atol=2e-14)


def test_finite_at_the_ends_of_the_range() -> None:
    assert_allclose(microfacet_filter(1e-100, 100), 1, rtol=0, atol=1e-13)
    flat = microfacet_filter(100, 4)
    assert_allclose(flat / flat[0], [1, 1 / 2, 0, -1 / 8, 0], rtol=0, atol=1e-4)  # a half sphere's, s = 0
    assert np.isfinite(microfacet_gaussian(100, 10)).all()


def test_the_readmes_example() -> None:
    assert round(microfacet_filter(0.3, 1)[1], 3) == 0.791
    values = [round(microfacet_gaussian(0.3, 1, form)[1], 3) for form in ("paper", "linear", "matched")]
    assert values == [0.914, 0.835, 0.791]


@pytest.mark.parametrize(
    ("roughness", "errors"),
    [(0.1, [0.044, 0.0066, 2.4e-6]), (0.2, [0.091, 0.026, 3.8e-5]), (0.3, [0.139, 0.0585, 0.0015])],
)
def test_the_errors_of_the_gaussians(roughness: float, errors: list[float]) -> None:
    exact = microfacet_filter(roughness, 100)
    found = [np.abs(microfacet_gaussian(roughness, 100, form) - exact).max() for form in ("paper", "linear", "matched")]
    assert_allclose(found, errors, rtol=0.03)


def test_the_papers_expansion_at_small_degrees() -> None:
    # equation 90 with its own l (l + 1): the rest is of fourth order in sigma l
    values = microfacet_filter(0.01, 5)
    fallen = 1e-4 * np.arange(6) * np.arange(1, 7)
    rest = values / values[0] - (1 - fallen)
    assert (np.abs(rest) <= fallen**2).all()


def test_the_papers_forms_of_the_harmonics_near_the_pole() -> None:
    # equation 86 holds as printed; equation 87 lacks a factor sqrt(2 / (pi l))
    angle, degree = 1e-3, 6
    near = 1 - degree * (degree + 1) / 4 * angle**2
    assert abs(eval_legendre(degree, np.cos(angle)) - near) < (degree * angle) ** 4
    angle, degree = 0.3, np.arange(500, 520)
    wave = np.cos((degree + 0.5) * angle - np.pi / 4) / np.sqrt(np.sin(angle))
    values = eval_legendre(degree, np.cos(angle))
    assert_allclose(values, np.sqrt(2 / (np.pi * degree)) * wave, rtol=0, atol=1e-4)
    assert np.abs(values - wave).max() > 1


def test_the_lobes_energy_is_degree_zero() -> None:
    for roughness in (0.1, 0.3, 0.8):
        energy = 2 * np.pi * quad(lambda u, r=roughness: float(microfacet_lobe(u, r)), 0, 1, epsabs=1e-12, limit=200)[0]
        assert_allclose(energy, microfacet_filter(roughness, 0)[0], rtol=1e-8)
    assert microfacet_lobe(-0.2, 0.3) == 0


@pytest.mark.parametrize("roughness", [0.02, 0.3, 1.5])
def test_the_sensitivity_is_the_slope(roughness: float) -> None:
    step = 1e-4 * roughness
    slope = (microfacet_filter(roughness + step, 30) - microfacet_filter(roughness - step, 30)) / (2 * step)
    assert_allclose(microfacet_sensitivity(roughness, 30), slope, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize(
    "function",
    [microfacet_filter, microfacet_sensitivity, microfacet_gaussian, lambda value, _: microfacet_lobe([1.0], value)],
)
@pytest.mark.parametrize("value", [0, -0.1, np.nan, np.inf])
def test_no_roughness(function, value: float) -> None:
    with pytest.raises(HarmonicFaceError, match="roughness: expected a finite number above 0, got"):
        function(value, 3)


def test_other_bad_input() -> None:
    for value in (1e-200, 1e200):
        with pytest.raises(HarmonicFaceError, match="roughness: expected radians from 1e-100 to 100, got"):
            microfacet_filter(value, 3)
    with pytest.raises(HarmonicFaceError, match="order: expected an integer of at least 0, got int -1"):
        microfacet_filter(0.3, -1)
    with pytest.raises(HarmonicFaceError, match="form: expected paper, linear or matched, got str 'best'"):
        microfacet_gaussian(0.3, 2, "best")
    with pytest.raises(HarmonicFaceError, match="cosines: expected finite numbers"):
        microfacet_lobe([np.inf], 0.3)
