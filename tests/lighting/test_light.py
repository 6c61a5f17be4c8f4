"""What every light shares: sums, scaling, and harmonic coefficients that give its irradiance back."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

import harmonicface as hf
from harmonicface.lighting.light import HarmonicLight, Light
from harmonicface.lighting.sources import DirectionalLights


def random_normals(number: int, seed: int = 0) -> np.ndarray:
    vectors = np.random.default_rng(seed).normal(size=(number, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def lamps() -> DirectionalLights:
    rng = np.random.default_rng(8)
    return DirectionalLights(rng.normal(size=(5, 3)), rng.uniform(0, 1, 5))


NORMALS = random_normals(400)
LIGHTS: dict[str, Callable[[], Light]] = {
    "one lamp": lambda: hf.lights.directional([1, 2, 3], 0.7),
    "lamps": lamps,
    "ambient": lambda: hf.lights.ambient(0.4),
    "environment": lambda: hf.lights.natural(5, size=8),
    "sum": lambda: hf.lights.directional([-1, 0, 1]) + hf.lights.ambient(0.2) + hf.lights.natural(2, size=6),
    "coloured sum": lambda: hf.lights.directional([-1, 0, 1], [0.2, 0.5, 0.9]) + hf.lights.natural(2, size=6),
}
every_light = pytest.mark.parametrize("light", [make() for make in LIGHTS.values()], ids=LIGHTS)


@every_light
def test_harmonics_give_the_irradiance_back_the_better_the_more_there_are(light: Light) -> None:
    exact = light.irradiance(NORMALS)
    scale = np.sqrt(np.mean(exact**2))
    errors = []
    for order in (2, 8, 32):
        series = HarmonicLight(light.coefficients(order)).irradiance(NORMALS)
        errors.append(np.sqrt(np.mean((series - exact) ** 2)) / scale)
    assert errors[0] < 0.15
    # the part of a lamp's irradiance beyond degree l has an RMS of about l^-1.5: 8 times the order, a 22nd of it
    assert errors[2] < max(errors[0] / 15, 1e-14)
    assert errors == sorted(errors, reverse=True) or max(errors) < 1e-14


@every_light
def test_the_mean_irradiance_is_that_of_the_first_coefficient(light: Light) -> None:
    # averaged over all normals the clamped cosine is 1/4, so E has the mean L_00 sqrt(4 pi) / 4
    z, weights = np.polynomial.legendre.leggauss(120)
    angles = 2 * np.pi * (np.arange(240) + 0.5) / 240
    across = np.sqrt(1 - z**2)[:, None]
    nodes = np.stack(np.broadcast_arrays(across * np.cos(angles), across * np.sin(angles), z[:, None]), axis=-1)
    mean = np.einsum("i,ij...->...", weights, light.irradiance(nodes)) / (2 * len(angles))
    assert_allclose(mean, light.coefficients(0)[0] * np.sqrt(4 * np.pi) / 4, rtol=2e-4)


@every_light
def test_a_lower_order_is_the_beginning_of_a_higher_one(light: Light) -> None:
    assert_allclose(light.coefficients(2), light.coefficients(6)[:9], rtol=0, atol=1e-12)
    assert light.coefficients().shape == ((9,) if light.channels == 1 else (9, 3))


@every_light
def test_twice_the_light(light: Light) -> None:
    for twice in (2 * light, light * 2, light + light):
        assert_allclose(twice.irradiance(NORMALS), 2 * light.irradiance(NORMALS), rtol=1e-13)
        assert_allclose(twice.coefficients(3), 2 * light.coefficients(3), rtol=1e-13)
        assert twice.channels == light.channels


@every_light
def test_irradiance_has_the_type_and_shape_of_the_normals(light: Light) -> None:
    single = light.irradiance(NORMALS.astype(np.float32).reshape(20, 20, 3))
    assert single.dtype == np.float32
    assert single.shape == (20, 20) + (3,) * (light.channels == 3)
    exact = light.irradiance(NORMALS)
    assert exact.dtype == np.float64
    assert_allclose(single.reshape(exact.shape), exact, rtol=0, atol=3e-6 * exact.max())
    assert_allclose(light.irradiance(NORMALS[3]), exact[3], rtol=1e-12)
    assert light.irradiance(np.zeros((0, 3))).shape[0] == 0


@every_light
def test_normals_that_are_none(light: Light) -> None:
    for normals in ([[0, 0, 2.0]], [[0, 0, np.nan]], [0.0, 1.0]):
        with pytest.raises(hf.HarmonicFaceError, match="expected"):
            light.irradiance(normals)
    with pytest.raises(hf.HarmonicFaceError, match="order: expected an integer of at least 0"):
        light.coefficients(-1)


def test_grey_light_adds_to_each_colour() -> None:
    red, grey = hf.lights.directional([0, 0, 1], [1, 0, 0]), hf.lights.directional([0, 1, 1], 0.5)
    both = grey + red
    assert (grey.channels, red.channels, both.channels) == (1, 3, 3)
    expected = red.irradiance(NORMALS) + np.repeat(grey.irradiance(NORMALS)[:, None], 3, axis=1)
    assert_array_equal(both.irradiance(NORMALS), expected)
    assert_array_equal(both.coefficients(), red.coefficients() + grey.coefficients()[:, None])


@settings(deadline=None, max_examples=20)
@given(st.floats(0, 100), st.floats(0, 100))
def test_scaling_distributes_over_a_sum(first: float, second: float) -> None:
    sun, sky = hf.lights.directional([1, 1, 1]), hf.lights.ambient(0.3)
    weighted = first * sun + second * sky
    expected = first * sun.irradiance(NORMALS[:20]) + second * sky.irradiance(NORMALS[:20])
    assert_allclose(weighted.irradiance(NORMALS[:20]), expected, rtol=1e-12, atol=1e-12)


def test_only_lights_add() -> None:
    with pytest.raises(TypeError):
        hf.lights.ambient(1) + 1  # type: ignore[operator]


def test_a_harmonic_light_by_hand() -> None:
    # constant radiance 1 and a part along z: E = pi * L00 Y00 + 2 pi / 3 * L10 Y10
    light = HarmonicLight([np.sqrt(4 * np.pi), 0, 0.5, 0])
    expected = np.pi + 2 * np.pi / 3 * 0.5 * np.sqrt(3 / (4 * np.pi)) * NORMALS[:, 2]
    assert_allclose(light.irradiance(NORMALS), expected, rtol=1e-14)
    assert (light.order, light.channels) == (1, 1)


def test_a_harmonic_light_in_colours_is_three_grey_ones() -> None:
    values = np.random.default_rng(0).normal(size=(9, 3))
    together = HarmonicLight(values).irradiance(NORMALS)
    apart = [HarmonicLight(column).irradiance(NORMALS) for column in values.T]
    assert_allclose(together, np.stack(apart, axis=-1), rtol=0, atol=1e-14)


def test_coefficients_are_cut_or_filled_with_zeros() -> None:
    light = HarmonicLight(np.arange(1.0, 10.0))
    assert light.coefficients(1).tolist() == [1, 2, 3, 4]
    assert light.coefficients(3).tolist() == [*range(1, 10), *[0] * 7]
    assert HarmonicLight(np.ones((4, 3))).coefficients(2).shape == (9, 3)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (np.ones(5), r"coefficients: expected \(order \+ 1\)\^2 of them \(1, 4, 9, 16, \.\.\.\), got 5"),
        (np.ones((9, 2)), r"coefficients: expected shape \(k,\) or \(k, 3\), got \(9, 2\)"),
        (1.0, r"coefficients: expected shape \(k,\) or \(k, 3\), got \(\)"),
        ([], r"coefficients: expected \(order \+ 1\)\^2 of them .*, got 0"),
        ([np.inf], "coefficients: expected finite numbers"),
    ],
)
def test_coefficients_that_are_none(values: np.ndarray, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        HarmonicLight(values)
