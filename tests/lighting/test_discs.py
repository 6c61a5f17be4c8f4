"""Discs of light: irradiance against quadrature, coefficients against Legendre integrals, and their limits."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from numpy.polynomial import legendre
from numpy.testing import assert_allclose
from scipy import integrate, special

import harmonicface as hf
from harmonicface.lighting.discs import DiscLight

RADII = [0.27, 5, 45, 89, 90, 91, 135, 179, 180]
TILTS = np.linspace(0, np.pi, 25)


def irradiance_by_quadrature(tilt: float, sigma: float) -> float:
    """Integrate max(n.w, 0) over rings around the disc's centre; the integral along a ring is elementary."""

    def ring(angle: float) -> float:
        mean, swing = np.cos(angle) * np.cos(tilt), np.sin(angle) * np.sin(tilt)
        if abs(mean) >= swing:
            return 2 * np.pi * max(mean, 0.0) * np.sin(angle)
        end = np.arccos(-mean / swing)
        return 2 * (mean * end + swing * np.sin(end)) * np.sin(angle)

    kinks = [kink for kink in (np.pi / 2 - tilt, tilt - np.pi / 2, 1.5 * np.pi - tilt) if 0 < kink < sigma]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", integrate.IntegrationWarning)  # it has reached rounding error and says so
        return float(integrate.quad(ring, 0, sigma, points=kinks or None, epsabs=1e-13, epsrel=1e-13, limit=200)[0])


@pytest.mark.parametrize("radius", RADII)
def test_irradiance_against_quadrature(radius: float) -> None:
    light = hf.lights.area([0, 0, 1], radius, 2.0)
    sigma = np.radians(radius)
    normals = np.stack([np.sin(TILTS), np.zeros_like(TILTS), np.cos(TILTS)], axis=-1)
    expected = [light.radiance * irradiance_by_quadrature(tilt, sigma) for tilt in TILTS]
    assert_allclose(light.irradiance(normals), expected, rtol=0, atol=1e-12)
    assert_allclose(light.irradiance(normals)[0], 2.0, rtol=1e-14)


@pytest.mark.parametrize("radius", RADII)
def test_zonal_coefficients_against_legendre_integrals(radius: float) -> None:
    light = hf.lights.cone([0, 0, 3], radius, 1.0)
    nodes, weights = legendre.leggauss(40)
    cosine = np.cos(np.radians(radius))
    points = cosine + (1 - cosine) * (nodes + 1) / 2
    for degree, value in enumerate(light.coefficients(20)[[degree * (degree + 1) for degree in range(21)]]):
        integral = weights @ special.eval_legendre(degree, points) * (1 - cosine) / 2
        expected = light.radiance * 2 * np.pi * np.sqrt((2 * degree + 1) / (4 * np.pi)) * integral
        assert_allclose(value, expected, rtol=0, atol=1e-12 * light.radiance * (1 - cosine) * 2 * np.pi)
    others = [index for index in range(441) if index != int(np.sqrt(index)) * (int(np.sqrt(index)) + 1)]
    assert_allclose(light.coefficients(20)[others], 0, atol=1e-15)


def test_coefficients_in_any_direction_against_many_lamps() -> None:
    light = hf.lights.area([1, -2, 0.5], 35, [1.0, 0.5, 0.0])
    fine = hf.EnvironmentMap(np.ones((600, 1200)))
    inside = (fine.directions @ light.direction > np.cos(np.radians(35))).astype(float)
    lamps = hf.EnvironmentMap(inside[..., None] * light.radiance)
    assert_allclose(light.coefficients(5), lamps.coefficients(5), rtol=0, atol=2e-3)


def test_limits() -> None:
    normals = np.random.default_rng(0).normal(size=(200, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    lamp, point = hf.lights.directional([1, 2, 3], 0.7), hf.lights.area([1, 2, 3], 1e-4, 0.7)
    assert_allclose(point.irradiance(normals), lamp.irradiance(normals), rtol=0, atol=1e-6)
    assert_allclose(point.coefficients(8), lamp.coefficients(8), rtol=0, atol=1e-9)
    ambient, everywhere = hf.lights.ambient(0.7), hf.lights.area([1, 2, 3], 180, 0.7)
    assert_allclose(everywhere.irradiance(normals), ambient.irradiance(normals), rtol=1e-14)
    assert_allclose(everywhere.coefficients(8), ambient.coefficients(8), rtol=0, atol=1e-14)
    high = hf.lights.area([1, 2, 3], 90 - 1e-7, 0.7).irradiance(normals)
    assert_allclose(high, hf.lights.area([1, 2, 3], 90, 0.7).irradiance(normals), rtol=0, atol=1e-8)


@pytest.mark.parametrize("radius", [1e-4, 1e-6, 1e-8, 1e-12, 1e-100, 1e-200, 5e-324])
def test_tiny_discs_at_the_horizon(radius: float) -> None:
    light, sine = hf.lights.area([0, 0, 1], radius, 2.0), np.sin(np.radians(radius))
    heights = np.linspace(-1.5, 1.5, 301)  # of the disc's centre over the horizon, in radii
    normals = np.stack([np.ones(301), np.zeros(301), heights * sine], axis=-1)
    found, lamp = light.irradiance(normals), hf.lights.directional([0, 0, 1], 2.0).irradiance(normals)
    assert (found >= 0).all()
    assert np.abs(found - lamp).max() <= 2 * 2 / (3 * np.pi) * sine * (1 + 1e-9)  # most where the horizon halves it
    # a small disc is flat: the integral of max(h + x, 0) over a unit circle, by hand
    within = np.clip(heights, -1, 1)
    flat = within * np.arccos(-within) + np.sqrt(1 - within**2) * (2 + within**2) / 3
    expected = 2 * sine * np.where(np.abs(heights) < 1, flat / np.pi, np.maximum(heights, 0))
    assert_allclose(found, expected, rtol=0, atol=1e-11 * sine)
    towards = hf.lights.directional([0, 0, 1], 2.0).coefficients(4)
    assert_allclose(light.coefficients(4), towards, rtol=0, atol=1e-10)


def test_the_radiance_of_a_disc_that_is_too_small_for_one() -> None:
    assert_allclose(hf.lights.area([0, 0, 1], 1e-100).radiance, (180 / np.pi) ** 2 * 1e200 / np.pi, rtol=1e-12)
    for radius, strength in ((1e-200, 1.0), (1e-145, 1e30), (1e-200, 0.0)):
        with pytest.raises(hf.HarmonicFaceError, match="radius: expected one of finite radiance, got 1e-"):
            _ = hf.lights.area([0, 0, 1], radius, strength).radiance


def test_the_sky_is_half_of_one_plus_the_cosine() -> None:
    normals = np.random.default_rng(0).normal(size=(200, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    assert_allclose(hf.lights.sky(3.0).irradiance(normals), 3 * (1 + normals[:, 1]) / 2, rtol=1e-13)
    assert_allclose(
        hf.lights.sky(1.0, up=[2, 0, 0]).irradiance(normals), (1 + normals[:, 0]) / 2, rtol=1e-13, atol=1e-15
    )
    # its odd harmonics reach no matter surface beyond degree 1: nine numbers are exact for it up to the even ones
    sky = hf.lights.sky(1.0)
    assert_allclose(
        hf.HarmonicLight(sky.coefficients(2)).irradiance(normals), sky.irradiance(normals), rtol=0, atol=1e-14
    )


def test_a_disc_and_its_complement_are_everything() -> None:
    normals = np.random.default_rng(1).normal(size=(100, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    small, large = hf.lights.area([1, 0, 1], 70), hf.lights.area([-1, 0, -1], 110)
    both = small * (1 / float(small.radiance)) + large * (1 / float(large.radiance))
    assert_allclose(both.irradiance(normals), np.pi, rtol=1e-13)
    assert_allclose(both.coefficients(6)[1:], 0, atol=1e-14)


def test_scaling_and_turning_keep_the_disc() -> None:
    light = 2 * hf.lights.area([0, 0, 1], 30, [0.1, 0.2, 0.3]).rotated([[0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    assert isinstance(light, DiscLight)
    assert_allclose(light.direction, [1, 0, 0])
    assert_allclose(light.strength, [0.2, 0.4, 0.6])
    assert light.radius == 30


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([0, 0, 0], 10), "direction: expected directions, got a vector of zero length"),
        (([[0, 0, 1]], 10), r"direction: expected one of shape \(3,\), got \(1, 3\)"),
        (([0, 0, 1], 0), "radius: expected a finite number above 0, got 0"),
        (([0, 0, 1], 181), "radius: expected degrees above 0 to 180, got 181"),
        (([0, 0, 1], np.nan), "radius: expected a finite number above 0"),
        (([0, 0, 1], 10, -1), "strength: expected at least 0, got -1"),
        (([0, 0, 1], 10, [1, 2]), "strength: expected one number or three"),
        (([0, 0, 1], 10, np.inf), "strength: expected finite numbers"),
    ],
)
def test_discs_that_are_none(arguments: tuple, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        hf.lights.area(*arguments)
