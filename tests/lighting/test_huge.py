"""Huge but finite light: up to 1e30 it is light like any other, without a warning, beyond it is refused in one line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.lighting.light import HarmonicLight

NORMALS = np.array([[0.0, 0.0, 1.0], [0.0, 0.6, 0.8], [1.0, 0.0, 0.0]])
MAKERS: dict[str, Callable[[Any], hf.Light]] = {
    "latlong": lambda value: hf.EnvironmentMap(np.full((64, 128, 3), value)),
    "odd latlong": lambda value: hf.EnvironmentMap(np.full((33, 65), value)),
    "angular": lambda value: hf.EnvironmentMap(np.full((64, 64), value), "angular"),
    "cube": lambda value: hf.EnvironmentMap(np.full((6, 16, 16, 3), value), "cube"),
    "lamp": lambda value: hf.lights.directional([0, 0, 1], value),
    "ambient": lambda value: hf.lights.ambient(value),
    "disc": lambda value: hf.lights.area([0, 0, 1], 30, value),
}
every_maker = pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)


@every_maker
@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_the_brightest_light_is_light_like_any_other(make: Callable[[Any], hf.Light], kind: type) -> None:
    bright, light = make(kind(1e30)), make(kind(1.0))
    tolerance = {"rtol": 1e-5, "atol": 1e24}
    for normals in (NORMALS, NORMALS.astype(np.float32)):
        expected = light.irradiance(normals) * np.float64(1e30)
        assert_allclose(bright.irradiance(normals), expected, **tolerance)
        for order in (2, 5):
            series, plain = (HarmonicLight(one.coefficients(order)).irradiance(normals) for one in (bright, light))
            assert_allclose(series, plain * np.float64(1e30), **tolerance)


@every_maker
@pytest.mark.parametrize("value", [np.float64(1e308), np.float32(3e38), np.float64(1e39), 2e30])
def test_light_beyond_it(make: Callable[[Any], hf.Light], value: Any) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=r"^(radiance|strengths?): expected at most 1e\+30, got [0-9.]+e\+"):
        make(value)


@pytest.mark.parametrize("value", [1e36, -1e308])
def test_coefficients_beyond_those_of_a_light(value: float) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=r"^coefficients: expected at most 1e\+35, got 1e\+"):
        HarmonicLight([1.0, value, 0.0, 0.0])
    with pytest.raises(hf.HarmonicFaceError, match=r"^strength: expected at most 1e\+35, got 1e\+"):
        HarmonicLight([1.0]).with_linear_term([0, 1, 0], value)


@pytest.mark.parametrize("transfer", ["linear", "srgb", None])
def test_a_file_of_numbers_beyond_single_precision(tmp_path: Path, transfer: str | None) -> None:
    np.save(tmp_path / "sky.npy", np.full((4, 8), 1e300))
    with pytest.raises(hf.HarmonicFaceError, match=r"expected finite (pixels|numbers), got 32 NaN or infinite"):
        hf.EnvironmentMap.load(tmp_path / "sky.npy", transfer=transfer)
    np.save(tmp_path / "sky.npy", np.full((4, 8), 1e37))
    with pytest.raises(hf.HarmonicFaceError, match="expected"):
        hf.EnvironmentMap.load(tmp_path / "sky.npy", transfer=transfer)
