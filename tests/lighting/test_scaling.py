"""Factors: one number, a tint of three, and what is neither; arguments of lights that are no arrays."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf

NORMALS = np.array([[0.0, 0.0, 1.0], [0.0, 0.6, 0.8], [1.0, 0.0, 0.0]])
TINT = [1.0, 0.5, 0.2]
COLOUR = [0.3, 0.6, 0.9]
LIGHTS: dict[str, hf.Light] = {
    "grey lamp": hf.lights.directional([1, 1, 1], 0.7),
    "lamp": hf.lights.directional([1, 1, 1], COLOUR),
    "grey ambient": hf.lights.ambient(0.7),
    "ambient": hf.lights.ambient(COLOUR),
    "grey disc": hf.lights.area([0, 1, 1], 40, 0.7),
    "disc": hf.lights.area([0, 1, 1], 40, COLOUR),
    "grey map": hf.lights.natural(0, 8),
    "map of three columns": hf.EnvironmentMap(np.random.default_rng(0).uniform(size=(4, 3))),
    "cube": hf.EnvironmentMap(np.random.default_rng(0).uniform(size=(6, 3, 3)), "cube"),
    "map": hf.EnvironmentMap(np.random.default_rng(0).uniform(size=(4, 8, 3))),
    "grey harmonics": hf.HarmonicLight([1.0, 0.2, 0.1, 0.3]),
    "harmonics": hf.lights.published("grace"),
    "sum": hf.lights.directional([1, 1, 1], COLOUR) + hf.lights.ambient(0.2),
}
every_light = pytest.mark.parametrize("light", LIGHTS.values(), ids=LIGHTS)


@every_light
@pytest.mark.parametrize("kind", [list, tuple, np.array])
def test_a_tint_is_a_factor_a_colour(light: hf.Light, kind: Callable[[list[float]], Any]) -> None:
    grey = light.irradiance(NORMALS)
    expected = (grey if light.channels == 3 else grey[..., None]) * TINT
    for tinted in (light * kind(TINT), kind(TINT) * light):
        assert isinstance(tinted, hf.Light)
        assert tinted.channels == 3
        assert_allclose(tinted.irradiance(NORMALS), expected, rtol=1e-12, atol=1e-15)


@every_light
@pytest.mark.parametrize("factor", [2, 2.0, np.float64(2), np.float32(2), np.int64(2), np.array(2.0)])
def test_a_number_is_a_factor(light: hf.Light, factor: Any) -> None:
    for twice in (light * factor, factor * light):
        assert isinstance(twice, type(light))
        assert twice.channels == light.channels
        assert_allclose(twice.irradiance(NORMALS), 2 * light.irradiance(NORMALS), rtol=1e-12)


def test_a_map_keeps_its_type() -> None:
    for factor in (2.0, np.float64(2), TINT):
        assert (hf.EnvironmentMap(np.ones((2, 4), np.float32)) * factor).radiance.dtype == np.float32


@every_light
@pytest.mark.parametrize(
    ("factor", "message"),
    [
        ("a", "factor: expected an array of real numbers, got str 'a'"),
        (None, "factor: expected an array of real numbers, got NoneType None"),
        ([1, [2]], "factor: expected an array of real numbers, got list"),
        ([1, 2], r"factor: expected one number or three, got an array of shape \(2,\)"),
        (np.ones((1, 3)), r"factor: expected one number or three, got an array of shape \(1, 3\)"),
        (np.nan, "factor: expected finite numbers, got 1 NaN"),
        ([1.0, np.inf, 1.0], "factor: expected finite numbers, got 1 NaN or infinite of 3"),
        (1e308, "expected (at most|finite numbers)"),
    ],
)
def test_what_is_no_factor(light: hf.Light, factor: Any, message: str) -> None:
    for call in (lambda: light * factor, lambda: factor * light):
        with pytest.raises(hf.HarmonicFaceError, match=message) as found:
            call()
        assert "\n" not in str(found.value)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: hf.lights.published(["grace"]), r"name: expected one of 'grace', .*, got \['grace'\]"),
        (lambda: hf.lights.published({}), "name: expected one of"),
        (lambda: hf.lights.area([1, [2, 3]], 10), "direction: expected an array of real numbers, got list"),
        (lambda: hf.lights.area([0, 0, 1], 10, [1, [2]]), "strength: expected an array of real numbers, got list"),
        (lambda: hf.lights.area([0, 0, 1], [1, [2]]), "radius: expected a number above 0, got list"),
        (lambda: hf.lights.cone("up", 10), "direction: expected an array of real numbers, got str 'up'"),
        (lambda: hf.lights.sky([1, [2]]), "strength: expected an array of real numbers, got list"),
        (lambda: hf.lights.sky(1, up=[1, [2]]), "up: expected an array of real numbers, got list"),
        (lambda: hf.lights.ambient([1, [2]]), "strength: expected an array of real numbers, got list"),
        (lambda: hf.lights.directional([0, 0, 1], [1, [2]]), "strength: expected an array of real numbers, got list"),
    ],
)
def test_arguments_that_are_no_arrays(call: Callable[[], Any], message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=f"^{message}"):
        call()
