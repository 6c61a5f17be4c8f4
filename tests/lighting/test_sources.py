"""Lamps and ambient light against loops over directions and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.lighting import _clamped_cosine
from harmonicface.lighting.sources import AmbientLight, DirectionalLights

RNG = np.random.default_rng(4)
NORMALS = RNG.normal(size=(37, 3))
NORMALS /= np.linalg.norm(NORMALS, axis=1, keepdims=True)
DIRECTIONS = RNG.normal(size=(23, 3)) * RNG.uniform(0.01, 100, (23, 1))


def by_hand(strengths: np.ndarray) -> np.ndarray:
    """Sum max(n.w, 0) one normal and one lamp at a time."""
    result = np.zeros((len(NORMALS), *strengths.shape[1:]))
    for i, normal in enumerate(NORMALS):
        for direction, strength in zip(DIRECTIONS, strengths, strict=True):
            cosine = float(np.dot(normal, direction)) / float(np.sqrt(np.dot(direction, direction)))
            result[i] += strength * max(cosine, 0.0)
    return result


@pytest.mark.parametrize("shape", [(23,), (23, 3)], ids=["grey", "colour"])
def test_irradiance_is_the_sum_of_clamped_cosines(shape: tuple[int, ...]) -> None:
    strengths = RNG.uniform(0, 2, shape)
    light = DirectionalLights(DIRECTIONS, strengths)
    assert light.channels == (1 if len(shape) == 1 else 3)
    assert_allclose(light.irradiance(NORMALS), by_hand(strengths), rtol=1e-13)


@pytest.mark.parametrize("block", [1, 7, 64, 1000])
def test_blocks_change_nothing(block: int, monkeypatch: pytest.MonkeyPatch) -> None:
    strengths = RNG.uniform(0, 2, 23)
    monkeypatch.setattr(_clamped_cosine, "BLOCK", block)
    assert_allclose(DirectionalLights(DIRECTIONS, strengths).irradiance(NORMALS), by_hand(strengths), rtol=1e-13)


def test_more_normals_than_a_block_has_rows() -> None:
    many = np.tile(NORMALS, (20, 1))
    strengths = RNG.uniform(0, 2, 23)
    expected = np.tile(by_hand(strengths), 20)
    assert_allclose(DirectionalLights(DIRECTIONS, strengths).irradiance(many), expected, rtol=1e-13)


def test_coefficients_of_a_lamp_are_the_harmonics_at_its_direction() -> None:
    x, y, z = 2 / 3, -1 / 3, 2 / 3
    expected = 1.5 * np.array(
        [
            0.282095,
            0.488603 * y,
            0.488603 * z,
            0.488603 * x,
            1.092548 * x * y,
            1.092548 * y * z,
            0.315392 * (3 * z * z - 1),
            1.092548 * x * z,
            0.546274 * (x * x - y * y),
        ]
    )
    assert_allclose(hf.lights.directional([2, -1, 2], 1.5).coefficients(), expected, atol=2e-6)


def test_light_behind_gives_nothing_and_in_front_its_strength() -> None:
    lamp = hf.lights.directional([0, 0, 5], 0.8)
    assert lamp.irradiance([0.0, 0.0, 1.0]) == 0.8
    assert lamp.irradiance([0.0, 0.0, -1.0]) == 0.0
    assert lamp.irradiance([1.0, 0.0, 0.0]) == 0.0


@pytest.mark.parametrize("strength", [0.5, [0.1, 0.2, 0.3]], ids=["grey", "colour"])
def test_ambient_light_is_the_same_everywhere(strength: float | list[float]) -> None:
    light = hf.lights.ambient(strength)
    assert light.channels == (3 if isinstance(strength, list) else 1)
    expected = np.broadcast_to(strength, (len(NORMALS), *np.shape(strength)))
    assert_allclose(light.irradiance(NORMALS), expected, rtol=1e-15)


def test_ambient_light_is_the_limit_of_many_lamps() -> None:
    z, weights = np.polynomial.legendre.leggauss(60)
    angles = 2 * np.pi * np.arange(121) / 121
    across = np.sqrt(1 - z**2)[:, None]
    nodes = np.stack(np.broadcast_arrays(across * np.cos(angles), across * np.sin(angles), z[:, None]), axis=-1)
    radiance = 0.5 / np.pi  # irradiance is pi times radiance
    many = DirectionalLights(nodes.reshape(-1, 3), np.repeat(weights * 2 * np.pi / 121, 121) * radiance)
    assert_allclose(many.irradiance(NORMALS), 0.5, rtol=1e-3)
    assert_allclose(many.coefficients(4), AmbientLight(0.5).coefficients(4), rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("azimuth", "elevation", "direction"),
    [(0, 0, [0, 0, 1]), (90, 0, [1, 0, 0]), (0, 90, [0, 1, 0]), (-90, 0, [-1, 0, 0]), (180, 0, [0, 0, -1])],
)
def test_angles_turn_right_and_up(azimuth: float, elevation: float, direction: list[float]) -> None:
    assert_allclose(hf.lights.from_angles(azimuth, elevation).directions, [direction], atol=1e-15)
    half = hf.lights.from_angles(azimuth / 2, elevation / 2, 3.0)
    assert half.strengths.tolist() == [3.0]
    assert_allclose(np.linalg.norm(half.directions), 1, rtol=1e-15)


@pytest.mark.parametrize(
    ("directions", "strengths", "message"),
    [
        ([[0, 0, 0]], [1], "directions: expected directions, got a vector of zero length"),
        ([[0, 0, np.nan]], [1], "directions: expected finite numbers"),
        ([0, 0, 1], [1], r"directions: expected shape \(n, 3\), got \(3,\)"),
        (np.zeros((0, 3)), [], r"directions: expected shape \(n, 3\), got \(0, 3\)"),
        ([[0, 0, 1]], [1, 2], r"strengths: expected shape \(1,\) or \(1, 3\), got \(2,\)"),
        ([[0, 0, 1]], [[1, 2]], r"strengths: expected shape \(1,\) or \(1, 3\), got \(1, 2\)"),
        ([[0, 0, 1]], [-0.5], "strengths: expected at least 0, got -0.5"),
        ([[0, 0, 1]], [np.inf], "strengths: expected finite numbers"),
    ],
)
def test_lamps_that_are_none(directions: list, strengths: list, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        DirectionalLights(directions, strengths)


@pytest.mark.parametrize(
    ("strength", "message"),
    [
        (-1.0, "strength: expected at least 0, got -1"),
        (np.ones((2, 2)), r"strength: expected one number or three, got an array of shape \(2, 2\)"),
        ([], r"strength: expected one number or three, got an array of shape \(0,\)"),
        (np.nan, "strength: expected finite numbers"),
        ("bright", "strength: expected an array of real numbers"),
    ],
)
def test_ambient_light_that_is_none(strength: float, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message) as caught:
        hf.lights.ambient(strength)
    assert "\n" not in str(caught.value)


def test_named_lights_refuse_the_same() -> None:
    with pytest.raises(hf.HarmonicFaceError, match="directions: expected directions, got a vector of zero length"):
        hf.lights.directional([0, 0, 0])
    with pytest.raises(hf.HarmonicFaceError, match="direction: expected vectors"):
        hf.lights.directional([0, 1])
    with pytest.raises(hf.HarmonicFaceError, match="azimuth and elevation: expected finite numbers"):
        hf.lights.from_angles(np.nan, 0)
    with pytest.raises(hf.HarmonicFaceError, match="strengths: expected at least 0"):
        hf.lights.from_angles(0, 0, -1)
    with pytest.raises(hf.HarmonicFaceError, match="strengths: expected at least 0"):
        -1 * hf.lights.directional([0, 0, 1])
