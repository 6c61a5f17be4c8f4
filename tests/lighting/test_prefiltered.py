"""Prefiltered maps: harmonic reflection maps against brute force, and irradiance maps both ways."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.lighting.layouts import layout_named
from harmonicface.lighting.prefiltered import irradiance_map, reflected, reflected_exactly, reflection_map
from harmonicface.reflectance.filters import lambertian_filter
from harmonicface.reflectance.microfacet import microfacet_filter, microfacet_lobe
from harmonicface.reflectance.phong import phong_filter, phong_lobe

SKY = hf.EnvironmentMap(np.random.default_rng(3).gamma(0.3, 1.0, (16, 32, 3)))
DIRECTIONS = np.random.default_rng(4).normal(size=(300, 3))
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)


@pytest.mark.parametrize(
    ("lobe", "filter_of", "orders"),
    [
        (lambda cosines: phong_lobe(cosines, 10), lambda order: phong_filter(10, order), (2, 6, 10, 20)),
        (lambda cosines: phong_lobe(cosines, 40), lambda order: phong_filter(40, order), (4, 10, 20, 40)),
        (lambda cosines: microfacet_lobe(cosines, 0.3), lambda order: microfacet_filter(0.3, order), (2, 6, 10, 40)),
    ],
    ids=["phong 10", "phong 40", "microfacet 0.3"],
)
def test_the_error_against_brute_force_falls_with_the_order(lobe, filter_of, orders) -> None:
    exact = reflected_exactly(SKY, lobe, DIRECTIONS)
    errors = [np.linalg.norm(reflected(SKY, filter_of(order), DIRECTIONS) - exact) for order in orders]
    errors = np.array(errors) / np.linalg.norm(exact)
    assert (np.diff(errors) < 0).all()
    assert errors[-1] < 1e-3


def test_a_phong_lobe_of_even_exponent_needs_no_more_than_its_own_degrees_and_the_odd_ones() -> None:
    # max(u, 0)^s is half of u^s plus half of sign(u) |u|^s: for s = 4 the even harmonics end at degree 4
    even = phong_filter(4, 12)[6::2]
    assert_allclose(even, 0, atol=1e-16)


def test_brute_force_by_a_loop() -> None:
    light = hf.EnvironmentMap(np.random.default_rng(1).uniform(size=(4, 8)))
    expected = [
        sum(
            light.radiance[pixel] * light.solid_angles[pixel] * 3.5 / np.pi * max(light.directions[pixel] @ r, 0) ** 6
            for pixel in np.ndindex(4, 8)
        )
        for r in DIRECTIONS[:20]
    ]
    assert_allclose(
        reflected_exactly(light, lambda cosines: phong_lobe(cosines, 6), DIRECTIONS[:20]), expected, rtol=1e-12
    )


def test_the_lambertian_filter_gives_irradiance() -> None:
    expected = hf.HarmonicLight(SKY.coefficients(6)).irradiance(DIRECTIONS)
    assert_allclose(reflected(SKY, lambertian_filter(6), DIRECTIONS), expected, rtol=1e-13)
    matte = reflected_exactly(SKY, lambda cosines: np.maximum(cosines, 0), DIRECTIONS)
    assert_allclose(matte, SKY.irradiance(DIRECTIONS), rtol=1e-12)


@pytest.mark.parametrize("layout", ["latlong", "angular", "cube", "mirrorball"])
def test_maps_hold_what_their_directions_see(layout: str) -> None:
    chosen = layout_named(layout)
    directions = chosen.directions(chosen.shape(8))
    assert_allclose(irradiance_map(SKY, 8, layout), SKY.irradiance(directions), rtol=1e-14)
    series = hf.HarmonicLight(SKY.coefficients(2)).irradiance(directions)
    assert_allclose(irradiance_map(SKY, 8, layout, order=2), series, rtol=1e-14)
    found = reflection_map(SKY, phong_filter(20, 8), 8, layout)
    assert_allclose(found, reflected(SKY, phong_filter(20, 8), directions), rtol=1e-14)


def test_a_lamp_s_reflection_is_the_lobe() -> None:
    lamp = hf.lights.directional([0, 0.6, 0.8], 2.0)
    exact = 2 * phong_lobe(DIRECTIONS @ [0, 0.6, 0.8], 3)
    assert_allclose(reflected(lamp, phong_filter(3, 60), DIRECTIONS), exact, rtol=0, atol=2e-4)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: reflected(SKY, np.ones((2, 2)), DIRECTIONS), r"filter_: expected shape \(order \+ 1,\), got \(2, 2\)"),
        (lambda: reflected(SKY, [], DIRECTIONS), r"filter_: expected shape \(order \+ 1,\), got \(0,\)"),
        (lambda: reflected(SKY, [np.nan], DIRECTIONS), "filter_: expected finite numbers"),
        (lambda: reflected(SKY, [1.0], [0.0, 0.0, 2.0]), "directions: expected unit vectors"),
        (lambda: reflected_exactly(SKY, np.abs, [0.0, 0.0, 2.0]), "directions: expected unit vectors"),
        (lambda: reflected_exactly(hf.lights.ambient(), np.abs, DIRECTIONS), "expected an EnvironmentMap, got Ambient"),
        (lambda: reflected_exactly(3, np.abs, DIRECTIONS), "environment: expected an EnvironmentMap, got int"),
        (lambda: reflected_exactly(SKY, 3, DIRECTIONS), "lobe: expected a function of cosines, got int 3"),
        (lambda: reflected_exactly(SKY, lambda c: np.nan * c, DIRECTIONS), "lobe: expected finite numbers, got"),
        (lambda: reflected_exactly(SKY, lambda c: None, DIRECTIONS), "lobe: expected an array of real numbers, got"),
        (lambda: reflected_exactly(SKY, lambda c: c[0], DIRECTIONS), "lobe: expected a value for each cosine, shape"),
        (lambda: reflected_exactly(SKY, lambda c: 1.0, DIRECTIONS), "lobe: expected a value for each cosine, shape"),
        (lambda: irradiance_map(3), "light: expected a light, got int 3"),
        (lambda: irradiance_map("sun", order=2), "light: expected a light, got str 'sun'"),
        (lambda: reflected(np.ones((4, 8)), [1.0], DIRECTIONS), r"light: expected a light, got an array of shape"),
        (lambda: reflection_map(None, [1.0]), "light: expected a light, got NoneType None"),
        (lambda: reflection_map(SKY, [1.0], size=0), "size: expected an integer of at least 1"),
        (lambda: irradiance_map(SKY, layout="globe"), "layout: expected one of"),
        (lambda: irradiance_map(SKY, order=-1), "order: expected an integer of at least 0"),
    ],
)
def test_maps_that_cannot_be(call, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        call()


def test_kept_harmonics_are_those_of_each_map() -> None:
    for layout, size in (("latlong", 8), ("cube", 8), ("latlong", 8), ("angular", 200)):
        chosen = layout_named(layout)
        directions = chosen.directions(chosen.shape(size))
        expected = hf.HarmonicLight(SKY.coefficients(2)).irradiance(directions)
        assert_allclose(irradiance_map(SKY, size, layout, order=2), expected, rtol=1e-12)
    with pytest.raises(hf.HarmonicFaceError, match="layout: expected one of"):
        irradiance_map(SKY, 8, ["latlong"], order=2)  # type: ignore[arg-type]
