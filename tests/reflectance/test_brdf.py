"""BRDFs against their formulas, and what is refused as one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from harmonicface.errors import HarmonicFaceError
from harmonicface.reflectance.brdf import Lambertian, Microfacet, Phong, Ward, values

MODELS = [Lambertian(0.7), Phong(20), Microfacet(0.3), Ward(0.2, 0.5)]
UP = np.array([0.0, 0.0, 1.0])
polar, azimuth = st.floats(0.0, 1.5), st.floats(-4.0, 4.0)


def direction(theta: float, phi: float) -> np.ndarray:
    return np.array([math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)])


def half_sphere(nodes: int) -> tuple[np.ndarray, np.ndarray]:
    """Polar angles by Gauss in theta, even azimuths."""
    at, weights = np.polynomial.legendre.leggauss(nodes)
    theta, weights = math.pi / 4 * (at + 1), math.pi / 4 * weights
    phi = np.arange(2 * nodes) * math.pi / nodes
    theta, phi = (each.ravel() for each in np.meshgrid(theta, phi, indexing="ij"))
    points = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    return points, np.repeat(weights, 2 * nodes) * np.sin(theta) * math.pi / nodes


@pytest.mark.parametrize("model", MODELS)
@given(polar, azimuth, polar, azimuth)
@settings(deadline=None)
def test_reciprocal_and_not_negative(model, theta: float, phi: float, other: float, turned: float) -> None:
    incoming, outgoing = direction(theta, phi), direction(other, turned)
    assert model(incoming, outgoing) >= 0
    assert_allclose(model(incoming, outgoing), model(outgoing, incoming), rtol=1e-9, atol=1e-300)


@given(polar, azimuth, polar, azimuth)
@settings(deadline=None)
def test_phong_is_a_power_of_the_cosine_with_the_mirror_image(
    theta: float, phi: float, other: float, turned: float
) -> None:
    incoming, outgoing = direction(theta, phi), direction(other, turned)
    mirrored = 2 * outgoing[2] * UP - outgoing
    expected = 22 / (2 * math.pi) * max(mirrored @ incoming, 0.0) ** 20
    assert_allclose(Phong(20)(incoming, outgoing), expected, rtol=1e-9, atol=1e-30)


@given(polar, azimuth, polar, azimuth)
@settings(deadline=None)
def test_half_way_lobes(theta: float, phi: float, other: float, turned: float) -> None:
    incoming, outgoing = direction(theta, phi), direction(other, turned)
    half = (incoming + outgoing) / np.linalg.norm(incoming + outgoing)
    tilt, way = math.acos(min(half[2], 1.0)), math.atan2(half[1], half[0])
    product = math.cos(theta) * math.cos(other)
    expected = math.exp(-((tilt / 0.3) ** 2)) / (4 * math.pi * 0.3**2 * product)
    assert_allclose(Microfacet(0.3)(incoming, outgoing), expected, rtol=1e-6, atol=1e-30)
    widths = (math.cos(way) / 0.2) ** 2 + (math.sin(way) / 0.5) ** 2
    expected = math.exp(-(math.tan(tilt) ** 2) * widths) / (4 * math.pi * 0.2 * 0.5 * math.sqrt(product))
    assert_allclose(Ward(0.2, 0.5)(incoming, outgoing), expected, rtol=1e-6, atol=1e-30)


@pytest.mark.parametrize("shininess", [1.0, 20.0, 33.3])
def test_all_light_along_the_normal_comes_back_from_phong(shininess: float) -> None:
    points, weights = half_sphere(60)
    assert_allclose((Phong(shininess)(UP, points) * points[:, 2] * weights).sum(), 1, rtol=1e-10)


def test_a_matte_surface_returns_its_albedo() -> None:
    points, weights = half_sphere(20)
    assert_allclose((Lambertian(0.7)(UP, points) * points[:, 2] * weights).sum(), 0.7, rtol=1e-12)


def test_only_unequal_widths_know_the_tangent() -> None:
    incoming, outgoing = direction(0.4, 0.3), direction(0.6, 2.9)
    turned = [direction(0.4, 1.3), direction(0.6, 3.9)]
    assert_allclose(Ward(0.3, 0.3)(incoming, outgoing), Ward(0.3, 0.3)(*turned), rtol=1e-12)
    assert abs(Ward(0.2, 0.5)(incoming, outgoing) / Ward(0.2, 0.5)(*turned) - 1) > 0.01


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("form", ["reciprocal", "transfer"])
def test_nothing_below_or_at_the_horizon(model, form: str) -> None:
    flat, below = direction(math.pi / 2, 0.1) * [1, 1, 0], direction(2.0, 3.0)
    for first, second in [(UP, flat), (flat, UP), (UP, below), (below, UP), (below, below)]:
        assert values(model, first, second, form) == 0


@pytest.mark.parametrize("model", MODELS)
def test_the_forms_differ_by_the_cosines(model) -> None:
    incoming, outgoing = direction(0.4, 0.3), direction(0.9, 3.0)
    plain = values(model, incoming, outgoing, "kernel")
    assert_allclose(values(model, incoming, outgoing, "transfer"), plain * math.cos(0.4), rtol=1e-14)
    assert_allclose(values(model, incoming, outgoing), plain * math.cos(0.4) * math.cos(0.9), rtol=1e-14)


def test_the_reciprocal_microfacet_is_finite_where_the_brdf_is_not() -> None:
    grazing = direction(math.pi / 2 - 1e-9, 0.0)
    assert Microfacet(0.3)(grazing, grazing * [-1, 1, 1]) > 1e15
    assert_allclose(values(Microfacet(0.3), grazing, grazing * [-1, 1, 1]), 1 / (4 * math.pi * 0.09), rtol=1e-6)


@pytest.mark.parametrize("model", MODELS)
def test_directions_broadcast(model) -> None:
    rng = np.random.default_rng(0)
    many = np.abs(rng.normal(size=(5, 1, 3)))
    others = np.abs(rng.normal(size=(1, 7, 3)))
    table = values(model, many, others)
    assert table.shape == (5, 7)
    assert_array_equal(table[3, 2], values(model, many[3, 0], others[0, 2]))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Lambertian(1.5), "albedo: expected a number from 0 to 1, got 1.5"),
        (lambda: Phong(0), "shininess: expected a finite number above 0, got 0"),
        (lambda: Microfacet(-0.1), "roughness: expected a finite number above 0, got -0.1"),
        (lambda: Microfacet(1e-200), "roughness: expected radians from 1e-100 to 100, got 1e-200"),
        (lambda: Ward(1e-200, 0.5), "along: expected a slope from 1e-100 to 100, got 1e-200"),
        (lambda: Ward(0.5, 1e200), r"across: expected a slope from 1e-100 to 100, got 1e\+200"),
        (lambda: Ward(0, 1), "along: expected a finite number above 0"),
        (lambda: Ward(1, math.nan), "across: expected a finite number above 0"),
    ],
)
def test_impossible_materials(make, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        make()


@pytest.mark.parametrize(
    ("brdf", "message"),
    [
        (0.3, "brdf: expected a function of .incoming, outgoing., got float 0.3"),
        (lambda i, o: np.zeros(4), r"brdf: expected values of shape \(\), got an array of shape \(4,\)"),
        (lambda i, o: np.nan * i[..., 0], "brdf's values: expected finite numbers, got 1 NaN"),
        (lambda i, o: np.inf, "brdf's values: expected finite numbers, got 1 NaN"),
        (lambda i, o: -o[..., 2], "brdf: expected values of at least 0, got -1"),
        (lambda i, o: "shiny", "brdf's values: expected an array of real numbers"),
        (lambda i, o: 1j, "brdf's values: expected an array of real numbers"),
    ],
)
def test_no_brdf(brdf, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message) as raised:
        values(brdf, UP, UP)
    assert "\n" not in str(raised.value)


def test_an_unknown_form() -> None:
    with pytest.raises(HarmonicFaceError, match="form: expected one of reciprocal, transfer, kernel, got str 'cosine'"):
        values(Lambertian(), UP, UP, "cosine")


@pytest.mark.parametrize(
    ("incoming", "message"),
    [
        (np.ones((4, 3)), r"outgoing: expected directions that broadcast with incoming ones of shape \(4, 3\)"),
        (np.ones(2), r"incoming: expected vectors of shape \(..., 3\)"),
        (np.full(3, np.nan), "incoming: expected finite numbers"),
    ],
)
def test_no_directions(incoming, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        values(Lambertian(), incoming, np.ones((5, 3)))


@pytest.mark.parametrize("brdf", [Lambertian(0.5), Phong(20), Microfacet(0.3), Ward(0.2, 0.5)])
def test_lists_are_directions_too(brdf) -> None:
    incoming, outgoing = [[0.0, 0.6, 0.8], [0.0, 0.0, 1.0]], [0, 0, 1]
    assert_array_equal(brdf(incoming, outgoing), brdf(np.array(incoming), np.array(outgoing, float)))
    with pytest.raises(HarmonicFaceError, match=r"incoming: expected vectors of shape \(..., 3\)"):
        brdf([0.0, 1.0], outgoing)
    with pytest.raises(HarmonicFaceError, match="outgoing: expected an array of real numbers"):
        brdf(incoming, [[1.0], [1.0, 2.0]])
    with pytest.raises(HarmonicFaceError, match="outgoing: expected directions that broadcast"):
        brdf(incoming, np.ones((3, 3)))
