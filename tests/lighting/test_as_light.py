"""What passes for a light, and what does not."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.lighting.as_light import as_light
from harmonicface.lighting.published import TABLE
from harmonicface.lighting.sources import DirectionalLights

NORMALS = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, -1.0, 0.0]])
SUN, SKY = hf.lights.directional([1, 2, 2], [1.0, 0.9, 0.7]), hf.lights.sky(0.4)


def test_a_light_is_itself() -> None:
    for light in (SUN, SKY, SUN + SKY, hf.EnvironmentMap(np.ones((4, 8)))):
        assert as_light(light) is light


@pytest.mark.parametrize("name", TABLE)
def test_names(name: str) -> None:
    assert_allclose(as_light(name).coefficients(), hf.lights.published(name).coefficients(), rtol=0)


@pytest.mark.parametrize("shape", [(1,), (4,), (9,), (25,), (1, 3), (4, 3), (9, 3)])
def test_coefficients(shape: tuple[int, ...]) -> None:
    values = np.random.default_rng(0).normal(size=shape)
    light = as_light(values)
    assert isinstance(light, hf.HarmonicLight)
    assert light.values is values
    if len(shape) == 1 and shape != (1,):
        assert_allclose(as_light(values.tolist()).coefficients(), light.coefficients(), rtol=0)  # a list of numbers


def test_single_precision_coefficients_stay_single() -> None:
    assert as_light(np.ones(9, np.float32)).coefficients().dtype == np.float32


@pytest.mark.parametrize("direction", [[0, 3, 4], (0.0, 3.0, 4.0), np.array([0, 3, 4])], ids=["list", "tuple", "array"])
def test_three_numbers_are_a_lamp(direction: object) -> None:
    assert_allclose(as_light(direction).irradiance(NORMALS), [0.8, 0.64, 0.0], rtol=1e-15)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "some",
    [
        [SUN, SKY],
        (SUN, "grace", [0, 0, 1]),
        [[0, 0, 1], [1, 0, 0]],
        [[0, 0, 1]],
        [np.array([0, 0, 1.0]), np.array([0, 1.0, 0]), np.array([1.0, 0, 0]), np.array([1.0, 1, 1])],
        ["st_peters"],
        [DirectionalLights([[0, 0, 1], [0, 1, 0]], [1, 2]), (0, 0, 1)],
    ],
)
def test_lists_are_sums(some: list[object]) -> None:
    expected = sum(as_light(item).coefficients(4).reshape(25, -1) + np.zeros((25, 3)) for item in some)  # type: ignore[arg-type]
    found = as_light(some)
    assert_allclose(found.coefficients(4).reshape(25, -1) + np.zeros((25, 3)), expected, rtol=1e-12, atol=1e-15)
    exact = sum(as_light(item).irradiance(NORMALS).reshape(3, -1) + np.zeros((3, 3)) for item in some)  # type: ignore[arg-type]
    assert_allclose(found.irradiance(NORMALS).reshape(3, -1) + np.zeros((3, 3)), exact, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (
            "noon",
            "light: expected one of 'grace', 'eucalyptus', 'st_peters' .EnvironmentMap.load reads a file., got 'noon",
        ),
        (["grace", "noon"], "light: expected one of 'grace'"),
        ([], "light: expected a Light, a published name, coefficients"),
        (None, "light: expected a Light, a published name, .*, got NoneType None"),
        (3.0, "light: expected a Light, .*, got an array of shape ()"),
        ({"a": 1}, "light: expected a Light, .*, got dict"),
        (np.ones((2, 3, 3)), "light: expected a Light, .*, got an array of shape .2, 3, 3."),
        (np.ones((9, 2)), "light: expected a Light, .*, got an array of shape .9, 2."),
        (np.ones(5), "coefficients: expected .order . 1..2 of them .*, got 5"),
        (np.ones((5, 3)), "coefficients: expected .*, got 5"),
        (np.zeros(3), "directions: expected directions, got a vector of zero length"),
        (np.array([0, np.nan, 1]), "light: expected finite numbers, got 1 NaN"),
        (np.ones(4, complex), "light: expected a Light, .*complex128"),
        ([True, "grace"], "light: expected lights, names and directions .3,. in a list, got an array of shape ()"),
        ([[0, 0, 1], [0, 1]], "light: expected lights, names and directions"),
        ([SUN, [0, 0, 0]], "directions: expected directions, got a vector of zero length"),
        ([SUN, None], "light: expected a Light, .*, got NoneType"),
        ([[0, 0, 1]] * 4, "light: expected an array of coefficients or .*, got 4 rows of three numbers"),
        (np.ones((9, 3)).tolist(), "light: expected an array of coefficients or .*, got 9 rows of three numbers"),
    ],
)
def test_what_is_no_light(value: object, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message) as error:
        as_light(value)  # type: ignore[arg-type]
    assert "\n" not in str(error.value)
