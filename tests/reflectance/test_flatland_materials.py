"""Flatland's closed forms against adaptive quadrature and their limits."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import quad
from scipy.special import gamma

from harmonicface.errors import HarmonicFaceError
from harmonicface.reflectance.flatland_materials import (
    flat_directional,
    flat_lambertian,
    flat_microfacet,
    flat_mirror,
    flat_phong,
    flat_phong_gaussian,
    flat_uniform,
)
from harmonicface.reflectance.flatland_series import circle_angles, fourier_coefficients, fourier_series
from harmonicface.reflectance.rank import kernel_rank

DEGREES = [0, 1, 2, 3, 4, 9, 20]


def cosine_integral(lobe, degree: int) -> float:
    return quad(lambda a: lobe(a) * np.cos(degree * a), -np.pi / 2, np.pi / 2, epsabs=1e-13, limit=400)[0]


@pytest.mark.parametrize("degree", DEGREES)
def test_a_matte_surface(degree: int) -> None:
    filter_ = flat_lambertian(20)
    assert_allclose(filter_[20 + degree], cosine_integral(np.cos, degree), rtol=0, atol=1e-12)
    assert filter_[20 - degree] == filter_[20 + degree]


def test_a_matte_surface_loses_odd_degrees_and_falls_with_the_square() -> None:
    filter_ = flat_lambertian(1000)[1000:]
    assert_array_equal(filter_[3::2], 0)
    assert_allclose(np.abs(filter_[1000]) * 1000**2, 2, rtol=1e-5)


def test_a_matte_surfaces_energy() -> None:
    filter_ = flat_lambertian(2000)
    energy = filter_**2 / (2 * np.pi) / (np.pi / 2)
    assert_allclose(energy.sum(), 1, rtol=1e-9)
    held = [energy[2000 - order : 2001 + order].sum() for order in range(3)]
    closed = np.cumsum([4 / np.pi**2, 1 / 2, 8 / (9 * np.pi**2)])
    assert_allclose(held, closed, rtol=1e-14)
    assert round(100 * closed[2], 2) == 99.53


@pytest.mark.parametrize("shininess", [0.0, 1.0, 2.0, 7.5, 60.0])
@pytest.mark.parametrize("degree", DEGREES)
def test_phong(shininess: float, degree: int) -> None:
    def lobe(angle: float) -> float:
        return max(float(np.cos(angle)), 0.0) ** shininess

    expected = cosine_integral(lobe, degree) / cosine_integral(lobe, 0)
    assert_allclose(flat_phong(shininess, 20)[20 + degree], expected, rtol=0, atol=1e-10)


def test_phong_of_one_is_matte_and_whole_exponents_have_zeros() -> None:
    assert_allclose(2 * flat_phong(1, 30), flat_lambertian(30), rtol=1e-13, atol=0)
    assert_array_equal(flat_phong(4, 12)[12:][6::2], 0)
    assert (flat_phong(4, 12)[12:][:6] > 0).all()


def test_phong_is_the_papers_equation_79_shifted() -> None:
    s, degree = 9.3, np.arange(8)
    closed = gamma(1 + s / 2) ** 2 / (gamma(1 + (s + degree) / 2) * gamma(1 + (s - degree) / 2))
    assert_allclose(flat_phong(s, 7)[7:], closed, rtol=1e-12)


@pytest.mark.parametrize(
    ("shininess", "errors"), [(10, [0.027, 0.017]), (50, [0.0053, 0.0036]), (1000, [2.7e-4, 1.8e-4])]
)
def test_phongs_gaussians(shininess: float, errors: list[float]) -> None:
    exact = flat_phong(shininess, 200)
    found = [np.abs(flat_phong_gaussian(shininess, 200, shifted) - exact).max() for shifted in (False, True)]
    assert_allclose(found, errors, rtol=0.05)


def test_a_huge_shininess_is_a_mirror() -> None:
    assert_allclose(flat_phong(1e12, 50), 1, rtol=0, atol=3e-9)


@pytest.mark.parametrize("roughness", [0.05, 0.3, 1.0, 5.0])
@pytest.mark.parametrize("degree", DEGREES)
def test_microfacets(roughness: float, degree: int) -> None:
    def lobe(angle: float) -> float:
        return float(np.exp(-((angle / (2 * roughness)) ** 2))) / (2 * roughness * np.sqrt(np.pi))

    expected = cosine_integral(lobe, degree)
    assert_allclose(flat_microfacet(roughness, 20)[20 + degree], expected, rtol=0, atol=1e-12)


def test_microfacets_are_the_papers_gaussian_but_for_the_horizon() -> None:
    assert_allclose(flat_microfacet(0.1, 40)[40:], np.exp(-((0.1 * np.arange(41)) ** 2)), rtol=0, atol=1e-15)
    assert np.isfinite(flat_microfacet(0.3, 5000)).all() and np.isfinite(flat_microfacet(1e-6, 5000)).all()


@pytest.mark.parametrize(("first", "second"), [(0, 0), (1, -1), (2, 1), (3, -1), (0, 3)])
def test_a_mirror_over_the_upper_half_circle(first: int, second: int) -> None:
    expected = quad(lambda a: np.cos((first + second) * a), -np.pi / 2, np.pi / 2)[0] / (2 * np.pi)
    assert_allclose(flat_mirror(3, 4)[first + 3, second + 4], expected, rtol=0, atol=1e-14)


def test_a_mirror_on_both_sides_sends_light_back_turned() -> None:
    assert_array_equal(flat_mirror(2, 2, both_sides=True), np.eye(5)[::-1])
    # the two sides' halves add up, with the sign of the parity
    half = flat_mirror(4, 4)
    total = np.add.outer(np.arange(-4, 5), np.arange(-4, 5))
    assert_allclose(half + np.where(total % 2 == 0, half, -half), np.eye(9)[::-1], rtol=0, atol=1e-15)


def test_lights() -> None:
    lamp = flat_directional(0.7, 30)
    assert_allclose(np.abs(lamp), 1 / np.sqrt(2 * np.pi), rtol=1e-14)
    peak = fourier_series(lamp, [0.7, 0.7 + np.pi / 30.5]).real
    assert_allclose(peak, [61 / (2 * np.pi), 0], rtol=0, atol=1e-1)
    samples = np.full(8, 1 / (2 * np.pi))
    assert_allclose(flat_uniform(2), fourier_coefficients(samples, 2), rtol=0, atol=1e-15)


def test_the_clamped_cosines_kernel_has_its_filter_as_singular_values() -> None:
    angles = circle_angles(400)
    kernel = np.maximum(np.cos(np.subtract.outer(angles, angles)), 0)
    weights = np.full(400, 2 * np.pi / 400)
    found = kernel_rank(kernel, 0.01, weights, weights)
    expected = -np.sort(-np.abs(flat_lambertian(10)))
    assert_allclose(found.singular_values[:9], expected[:9], rtol=0, atol=1e-4)


def test_errors() -> None:
    with pytest.raises(HarmonicFaceError, match="shininess: expected a finite number of at least 0"):
        flat_phong(-1, 2)
    with pytest.raises(HarmonicFaceError, match="shininess: expected a finite number above 0"):
        flat_phong_gaussian(0, 2)
    with pytest.raises(HarmonicFaceError, match="roughness: expected a finite number above 0"):
        flat_microfacet(0, 2)
    for function in (flat_lambertian, flat_uniform, lambda order: flat_mirror(1, order)):
        with pytest.raises(HarmonicFaceError, match="order: expected an integer of at least 0"):
            function(-1)


def test_a_mirror_beyond_the_memory() -> None:
    for order, outgoing_order in ((10**6, 10**6), (10**6, 10**5)):
        with pytest.raises(
            HarmonicFaceError, match=f"mirror of order {order} by {outgoing_order}: need .* GB of memory"
        ):
            flat_mirror(order, outgoing_order)
