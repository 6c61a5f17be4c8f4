"""What every light shares: sums, scaling, and harmonic coefficients that give its irradiance back."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

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
TURN = Rotation.from_rotvec([0.4, -1.1, 2.0])
LIGHTS: dict[str, Callable[[], Light]] = {
    "one lamp": lambda: hf.lights.directional([1, 2, 3], 0.7),
    "lamps": lamps,
    "ambient": lambda: hf.lights.ambient(0.4),
    "disc": lambda: hf.lights.area([1, 1, -2], 20, [0.3, 0.2, 0.1]),
    "more than half a sphere": lambda: hf.lights.cone([0, -1, 0], 130, 0.8),
    "cube": lambda: hf.EnvironmentMap(np.random.default_rng(2).gamma(0.2, 1.0, (6, 5, 5, 3)), "cube"),
    "light probe": lambda: hf.EnvironmentMap(np.random.default_rng(3).gamma(0.2, 1.0, (9, 9)), "angular"),
    "turned environment": lambda: hf.lights.natural(7, size=6).rotated(TURN),
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


@every_light
def test_a_turned_light_is_the_light_seen_by_normals_turned_back(light: Light) -> None:
    for turn in (TURN, Rotation.from_euler("x", 180, degrees=True), Rotation.identity()):
        matrix = turn.as_matrix()
        turned = light.rotated(turn)
        scale = light.irradiance(NORMALS).max()
        assert_allclose(turned.irradiance(NORMALS @ matrix.T), light.irradiance(NORMALS), rtol=0, atol=2e-14 * scale)
        assert_array_equal(light.rotated(matrix).coefficients(3), turned.coefficients(3))
        assert turned.channels == light.channels


@every_light
def test_coefficients_turn_with_the_light(light: Light) -> None:
    # by projection: the coefficients of f(R^T w) are sums over w of weight times f times Y(R w), seen here in degree 1
    before, after = light.coefficients(6), light.rotated(TURN).coefficients(6)
    cartesian = [3, 1, 2]
    assert_allclose(
        after[cartesian], TURN.as_matrix() @ before[cartesian], rtol=0, atol=1e-13 * np.abs(before[0]).max()
    )
    for degree in range(7):
        block = slice(degree**2, (degree + 1) ** 2)
        size = np.linalg.norm(before[block], axis=0)
        assert_allclose(np.linalg.norm(after[block], axis=0), size, rtol=1e-10, atol=1e-13 * np.abs(before[0]).max())


@every_light
@pytest.mark.parametrize(
    ("rotation", "message"),
    [
        (np.eye(2), "rotation: expected .* 3 x 3 matrix, got shape"),
        (-np.eye(3), "rotation: expected an orthogonal matrix of determinant 1"),
        (2 * np.eye(3), "rotation: expected an orthogonal matrix of determinant 1"),
        (np.full((3, 3), np.nan), "rotation: expected finite numbers"),
        ("left", "rotation: expected an array of real numbers"),
    ],
)
def test_what_turns_no_light(light: Light, rotation: np.ndarray, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        light.rotated(rotation)


def test_light_from_below_by_one_coefficient() -> None:
    above = hf.HarmonicLight([1.0, 0.4, 0.0, 0.1])
    below = above.with_coefficient(1, -1, -0.4)
    up = np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
    assert_allclose(below.irradiance(up), above.irradiance(up)[::-1], rtol=1e-15)
    assert above.values[1] == 0.4
    assert_array_equal(above.with_coefficient(2, 1, 5.0).values, [1, 0.4, 0, 0.1, 0, 0, 0, 5, 0])
    grace = hf.lights.published("grace").with_coefficient(0, 0, [1.0, 2.0, 3.0])
    assert_array_equal(grace.values[0], [1, 2, 3])
    assert_array_equal(hf.lights.published("grace").with_coefficient(1, 0, 0.5).values[2], [0.5, 0.5, 0.5])


def test_a_linear_term_adds_its_cosine() -> None:
    direction = np.array([0.6, 0.0, -0.8])
    before = hf.HarmonicLight(np.random.default_rng(0).normal(size=(9, 3)))
    after = before.with_linear_term(5 * direction, [0.1, 0.2, -0.3])
    added = 2 * np.pi / 3 * (NORMALS @ direction)[:, None] * [0.1, 0.2, -0.3]
    assert_allclose(after.irradiance(NORMALS) - before.irradiance(NORMALS), added, rtol=0, atol=1e-14)
    assert_allclose(
        hf.HarmonicLight([0.0]).with_linear_term([0, 0, 1], 1.0).irradiance([[0.0, 0.0, 1.0]]), 2 * np.pi / 3
    )


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (lambda light: light.with_coefficient(1, 2, 0.0), "mode: expected an integer from -1 to 1, got 2"),
        (lambda light: light.with_coefficient(-1, 0, 0.0), "degree: expected an integer of at least 0"),
        (lambda light: light.with_coefficient(1, 0, np.nan), "value: expected finite numbers"),
        (lambda light: light.with_coefficient(1, 0, [1.0, 2.0, 3.0]), "value: expected one number, got an array"),
        (lambda light: light.with_linear_term([0, 0, 0], 1.0), "direction: expected directions"),
        (
            lambda light: light.with_linear_term([[0, 0, 1]], 1.0),
            r"direction: expected one of shape \(3,\), got \(1, 3\)",
        ),
        (lambda light: light.with_linear_term([0, 0, 1], [1.0, 2.0]), "strength: expected one number, got an array"),
    ],
)
def test_edits_that_are_none(edit: Callable[[hf.HarmonicLight], Light], message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        edit(hf.HarmonicLight([1.0, 0, 0, 0]))


def test_coloured_light_takes_one_value_or_three() -> None:
    with pytest.raises(hf.HarmonicFaceError, match="value: expected one number or three, got an array"):
        hf.lights.published("grace").with_coefficient(1, 0, [1.0, 2.0])


@every_light
def test_an_order_beyond_the_memory(light: Light) -> None:
    with pytest.raises(hf.HarmonicFaceError, match="of memory, expected at most") as caught:
        light.coefficients(10_000_000)
    assert "\n" not in str(caught.value)
