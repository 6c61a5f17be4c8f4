"""Directional and uniform light, mirrors and filtering, against their closed forms and quadrature."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import quad
from scipy.special import assoc_legendre_p

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.reflectance.filters import lambertian_filter
from harmonicface.reflectance.phong import phong_filter
from harmonicface.reflectance.spectra import (
    apply_filter,
    degree_norms,
    degree_power,
    directional_spectrum,
    mirror_coefficients,
    mirror_filter,
    uniform_spectrum,
)


def test_norms() -> None:
    assert_allclose(degree_norms(2), np.sqrt(4 * np.pi / np.array([1, 3, 5])), rtol=1e-15)


def test_light_from_the_pole_has_one_over_the_norm_at_each_degree() -> None:
    spectrum = directional_spectrum([0, 0, 3], 20)
    degree = np.arange(21)
    assert_allclose(spectrum[degree * (degree + 1)] * degree_norms(20), 1, rtol=1e-13)
    spectrum[degree * (degree + 1)] = 0
    assert_array_equal(spectrum, 0)


def test_the_power_of_a_lamp_is_the_same_from_everywhere() -> None:
    for direction in ([0, 0, 1], [1, 2, -3], [-1, 0, 0]):
        power = degree_power(directional_spectrum(direction, 12))
        assert_allclose(power, (2 * np.arange(13) + 1) / (4 * np.pi), rtol=1e-12)


def test_power_of_colours() -> None:
    light = np.random.default_rng(0).normal(size=(9, 3))
    assert_allclose(degree_power(light)[2], (light[4:] ** 2).sum(axis=0), rtol=1e-14)


def test_uniform_light_is_the_average_of_lamps() -> None:
    directions = np.random.default_rng(1).normal(size=(200, 3))
    both = np.concatenate([directions, -directions])  # odd degrees cancel exactly
    average = np.mean([directional_spectrum(direction, 1) for direction in both], axis=0)
    assert_allclose(uniform_spectrum(1), average, rtol=0, atol=1e-14)


def test_uniform_light_tells_nothing_but_degree_zero() -> None:
    chalk = apply_filter(lambertian_filter(8) / np.pi, uniform_spectrum(8))
    assert_allclose(chalk, apply_filter(mirror_filter(8), uniform_spectrum(8)), rtol=0, atol=1e-16)


def test_a_lamp_shows_the_filter_itself() -> None:
    normals = np.array([[np.sin(a), 0, np.cos(a)] for a in (0.0, 0.6, 1.3, 2.9)])
    picture = apply_filter(phong_filter(6, 20), directional_spectrum([0, 0, 1], 20)) @ real_harmonics(normals, 20)
    expected = 7 / (2 * np.pi) * np.maximum(normals[:, 2], 0) ** 6
    assert_allclose(picture, expected, rtol=0, atol=1e-4)  # the tail beyond degree 20


def test_blurred_light_in_a_mirror_is_light_in_a_gloss() -> None:
    light = np.random.default_rng(2).normal(size=(49, 3))
    gloss = phong_filter(12, 6)
    assert_array_equal(apply_filter(mirror_filter(6), apply_filter(gloss, light)), apply_filter(gloss, light))
    matte = lambertian_filter(6)
    assert_allclose(apply_filter(matte, apply_filter(gloss, light)), apply_filter(matte * gloss, light), rtol=1e-14)


def test_two_lights_that_no_matte_surface_tells_apart() -> None:
    # 1 and 1 + 5/3 cos^3 - cos; the second is nowhere negative
    heights, weights = np.polynomial.legendre.leggauss(16)
    polar = np.stack([np.sqrt(1 - heights**2), 0 * heights, heights], axis=-1)
    harmonics = real_harmonics(polar, 8)
    zonal = np.arange(9) * np.arange(1, 10)
    lights = np.zeros((81, 2))
    for column, radiance in enumerate([np.ones(16), 1 + 5 / 3 * heights**3 - heights]):
        assert radiance.min() >= 0
        lights[zonal, column] = 2 * np.pi * harmonics[zonal] @ (weights * radiance)
    irradiance = apply_filter(lambertian_filter(8), lights)
    assert np.abs(lights[:, 1] - lights[:, 0]).max() > 0.5
    assert_allclose(irradiance[:, 1], irradiance[:, 0], rtol=0, atol=1e-14)

    def brute_force(tilt: float, radiance) -> float:
        azimuths = np.arange(64) * np.pi / 32
        up, around = np.meshgrid(np.linspace(-1, 1, 4001), azimuths, indexing="ij")
        facing = np.sin(tilt) * np.sqrt(np.maximum(1 - up**2, 0)) * np.cos(around) + np.cos(tilt) * up
        ring = (np.maximum(facing, 0) * radiance(up)).mean(axis=1) * 2 * np.pi
        return float(np.trapezoid(ring, up[:, 0]))

    for tilt in (0.0, 0.7, 1.9):
        assert_allclose(brute_force(tilt, lambda u: 1 + 5 / 3 * u**3 - u), np.pi, rtol=2e-4)
        assert_allclose(brute_force(tilt, np.ones_like), np.pi, rtol=2e-4)


@pytest.mark.parametrize(("degree", "mode"), [(0, 0), (1, 0), (1, 1), (3, -2), (4, 3)])
def test_a_mirror_over_the_upper_half_sphere(degree: int, mode: int) -> None:
    values = mirror_coefficients(6, degree, mode)
    for other in range(7):
        integral = 0.0
        if other >= abs(mode):

            def product(u: float, p: int = other) -> float:
                first = assoc_legendre_p(degree, abs(mode), u, norm=True)[0]
                second = assoc_legendre_p(p, abs(mode), u, norm=True)[0]
                return float(first * second)

            integral = (-1) ** mode * quad(product, 0, 1)[0]
        assert_allclose(values[other], integral, rtol=0, atol=1e-10)
    assert_allclose(values[degree], (-1) ** mode / 2, rtol=1e-13)


def test_the_whole_mirror_is_diagonal() -> None:
    # the lower half adds the same for equal parity and takes it away for unequal: equation 66 for both sides
    values = mirror_coefficients(8, 3, 1)
    parity = (-1.0) ** (np.arange(9) + 3)
    assert_allclose(values + parity * values, -(np.arange(9) == 3).astype(float), rtol=0, atol=1e-14)


def test_errors() -> None:
    with pytest.raises(HarmonicFaceError, match="direction: expected directions, got a vector of zero length"):
        directional_spectrum([0, 0, 0], 2)
    with pytest.raises(HarmonicFaceError, match="direction: expected three numbers, got"):
        directional_spectrum([[0, 0, 1]], 2)
    with pytest.raises(HarmonicFaceError, match="mode: expected an integer from -1 to 1, got 2"):
        mirror_coefficients(3, 1, 2)
    with pytest.raises(HarmonicFaceError, match="degree: expected an integer of at least 0"):
        mirror_coefficients(3, -1, 0)
    with pytest.raises(HarmonicFaceError, match="filter: expected at least 3 degrees for the coefficients, got 2"):
        apply_filter([1, 1], np.ones(9))
    with pytest.raises(HarmonicFaceError, match=r"coefficients: expected \(order \+ 1\)\^2 of them"):
        degree_power(np.ones(5))
    with pytest.raises(HarmonicFaceError, match="coefficients: expected finite numbers"):
        apply_filter([1.0], [np.nan])
    with pytest.raises(HarmonicFaceError, match="order: expected an integer of at least 0"):
        mirror_filter(-1)
    with pytest.raises(HarmonicFaceError, match="order: expected an integer of at least 0"):
        degree_norms(-1)
    with pytest.raises(HarmonicFaceError, match="filter: expected one number a degree"):
        apply_filter(np.ones((3, 3)), np.ones(9))


def test_spectra_beyond_the_memory() -> None:
    with pytest.raises(HarmonicFaceError, match=r"mirror of degrees up to 1000000: need .* GB of memory"):
        mirror_coefficients(10**6, 1, 0)
    with pytest.raises(HarmonicFaceError, match=r"mirror of degrees up to 1000000: need .* GB of memory"):
        mirror_coefficients(1, 10**6, 0)
    with pytest.raises(HarmonicFaceError, match=r"light of order 1000000: need 8e\+03 GB of memory"):
        uniform_spectrum(10**6)
