"""Energies and bounds against the published tables, quadrature and random lights."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import quad

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.reflectance.energy import (
    LAMBERTIAN_ENERGY,
    degree_energies,
    energy_captured,
    lambertian_pixel_error,
    least_energy_captured,
    phong_energy,
    worst_pixel_error,
)
from harmonicface.reflectance.filters import lambertian_filter
from harmonicface.reflectance.phong import phong_filter, phong_lobe
from harmonicface.reflectance.spectra import degree_power


@pytest.mark.parametrize(
    ("order", "energy", "captured", "bound"),
    [
        (0, 37.5, 37.5, 37.5),
        (1, 50.0, 87.5, 75.0),
        (2, 11.72, 99.22, 97.96),
        (4, 0.59, 99.80, 99.48),
    ],
)
def test_the_table_of_basri_and_jacobs(order: int, energy: float, captured: float, bound: float) -> None:
    values = lambertian_filter(order)
    assert round(100 * degree_energies(values)[-1] / LAMBERTIAN_ENERGY, 2) == energy
    assert round(100 * energy_captured(values, LAMBERTIAN_ENERGY)[-1], 2) == captured
    assert round(100 * least_energy_captured(values, LAMBERTIAN_ENERGY)[-1], 2) == bound


@pytest.mark.parametrize("shininess", [1.0, 2.5, 40.0])
def test_all_degrees_of_phong_hold_all_its_energy(shininess: float) -> None:
    integral = 2 * np.pi * quad(lambda u: float(phong_lobe(u, shininess)) ** 2, 0, 1, epsabs=1e-12)[0]
    assert_allclose(phong_energy(shininess), integral, rtol=1e-9)
    assert_allclose(energy_captured(phong_filter(shininess, 1000), phong_energy(shininess))[-1], 1, rtol=1e-6)


def test_energy_of_an_enormous_shininess_is_finite() -> None:
    assert np.isfinite(phong_energy(1e300))


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 6), st.integers(0, 2**32 - 1), st.floats(0, 1))
def test_no_light_of_a_few_lamps_and_a_sky_is_below_the_bound(lamps: int, seed: int, sky: float) -> None:
    random = np.random.default_rng(seed)
    directions = random.normal(size=(lamps, 3))
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    light = real_harmonics(directions, 40) @ random.random(lamps)
    light[0] += sky
    shares = np.cumsum(lambertian_filter(40) ** 2 * degree_power(light))
    bound = least_energy_captured(lambertian_filter(40), LAMBERTIAN_ENERGY)
    assert (shares / shares[-1] >= bound - 1e-6)[:9].all()


def test_order_zero_meets_its_bound_under_a_lamp() -> None:
    light = real_harmonics(np.array([0.0, 0.0, 1.0]), 60)
    shares = lambertian_filter(60) ** 2 * degree_power(light)
    assert_allclose(shares[0] / shares.sum(), 0.375, rtol=1e-5)


def test_worst_pixel_of_a_matte_surface() -> None:
    assert_allclose(lambertian_pixel_error(2), 0.09375, rtol=0, atol=1e-11)
    assert_allclose(lambertian_pixel_error(0), 0.75, rtol=0, atol=1e-11)
    assert_allclose(lambertian_pixel_error(1), 0.25, rtol=0, atol=1e-11)
    assert_allclose(lambertian_pixel_error(4), 3 / 32 - 9 / 256, rtol=0, atol=1e-11)  # again where light grazes


def test_worst_pixel_error_is_attained_by_a_lamp_and_found_between_samples() -> None:
    cosines = np.cos(np.linspace(0, np.pi, 400_001))
    series = (2 * np.arange(8) + 1) * phong_filter(9.5, 7) / (4 * np.pi)
    errors = np.abs(np.polynomial.legendre.legval(cosines, series) - phong_lobe(cosines, 9.5))
    assert_allclose(worst_pixel_error(phong_filter(9.5, 7), lambda u: phong_lobe(u, 9.5)), errors.max(), rtol=1e-9)


def test_worst_pixel_error_between_two_samples() -> None:
    found = worst_pixel_error([0.0], lambda u: 1 - (u - 0.3217) ** 2)
    assert_allclose(found, 1, rtol=0, atol=1e-11)


def test_errors() -> None:
    with pytest.raises(HarmonicFaceError, match="total: expected at least the 2"):
        energy_captured(lambertian_filter(8), 1.0)
    with pytest.raises(HarmonicFaceError, match="total: expected a finite number above 0"):
        energy_captured(lambertian_filter(2), 0.0)
    with pytest.raises(HarmonicFaceError, match="filter: expected one number a degree, got an array of shape"):
        degree_energies([[1.0]])
    with pytest.raises(HarmonicFaceError, match="filter: expected finite numbers"):
        worst_pixel_error([np.nan], np.abs)
    with pytest.raises(HarmonicFaceError, match="shininess: expected a finite number of at least 0"):
        phong_energy(-1)
    with pytest.raises(HarmonicFaceError, match="lobe: expected finite numbers"):
        worst_pixel_error([1.0], lambda cosine: cosine * np.nan)
    with pytest.raises(HarmonicFaceError, match="lobe: expected values of shape"):
        worst_pixel_error([1.0], lambda cosine: 1.0)


def test_a_lobe_that_is_none() -> None:
    with pytest.raises(HarmonicFaceError, match="lobe: expected a function of cosines, got int 3"):
        worst_pixel_error([1.0], 3)
