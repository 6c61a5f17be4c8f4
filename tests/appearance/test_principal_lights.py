"""Statistics of light: closed forms, sums over lamps, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.appearance.principal_lights import LightStatistics, light_statistics
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.quadrature import project, sphere_grid
from harmonicface.lighting.light import HarmonicLight

RNG = np.random.default_rng(0)
DIRECTIONS = RNG.normal(size=(200_000, 3))
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)
NORMALS = DIRECTIONS[:40]


def power_at(statistics: LightStatistics) -> np.ndarray:
    """Return the mean square irradiance at some normals."""
    return statistics.power @ real_harmonics(NORMALS, 4)


def test_lamps_all_around() -> None:
    found = light_statistics("sphere")
    assert_allclose(found.moment, np.eye(169) / (4 * np.pi), atol=1e-15)
    assert_allclose(found.mean, np.eye(169)[0] / np.sqrt(4 * np.pi), atol=1e-15)
    assert_allclose(power_at(found), 1 / 6, rtol=1e-12)


@pytest.mark.parametrize(
    ("lights", "density"),
    [
        ("sphere", lambda w: np.ones(len(w))),
        ("frontal", lambda w: 2.0 * (w[:, 2] > 0)),
        ([3.0, 0.0, 1.0, 0.5, 0.2, 0.0, 0.1, 0.0, 0.0], None),
    ],
)
def test_statistics_of_lamps_are_those_of_random_ones(lights: str | list[float], density: object) -> None:
    found = light_statistics(lights)
    if density is None:
        share = np.array(lights) @ real_harmonics(DIRECTIONS, 2) / (3.0 / np.sqrt(4 * np.pi))
    else:
        share = density(DIRECTIONS)  # type: ignore[operator]
    harmonics = real_harmonics(DIRECTIONS, 4)
    weighted = harmonics * share / len(share)
    assert_allclose(found.mean[:25], weighted.sum(axis=1), atol=0.005)
    assert_allclose(found.moment[:25, :25], weighted @ harmonics.T, atol=0.01)
    expected = np.maximum(NORMALS @ DIRECTIONS.T, 0) ** 2 @ share / len(share)
    assert_allclose(power_at(found), expected, atol=0.012)  # degrees above 4 of a hemisphere's edge are left out


def test_a_density_of_degree_0_is_the_sphere() -> None:
    even, sphere = light_statistics([5.0]), light_statistics("sphere")
    assert_allclose(even.covariance, sphere.covariance, atol=1e-14)
    assert_allclose(even.power, sphere.power, atol=1e-15)


def test_a_density_of_higher_degree_than_is_kept() -> None:
    towards = np.array([0.6, 0.0, 0.8])
    peak = real_harmonics(towards, 14)
    degree = np.sqrt(np.arange(225)).astype(int)
    smooth = peak * np.exp(-degree * (degree + 1) / 8)  # a soft spot that is positive everywhere
    found = light_statistics(smooth)
    assert found.mean.shape == (169,)
    assert_allclose(found.mean[1:4] / np.linalg.norm(found.mean[1:4]), towards[[1, 2, 0]], atol=1e-12)


def test_several_lights_come_equally_often() -> None:
    lights = [hf.lights.natural(seed, size=8) for seed in range(3)] + ["grace"]
    found = light_statistics(lights)
    grace = hf.lights.published("grace").coefficients(12) @ [0.2126, 0.7152, 0.0722]
    values = np.stack([*(light.coefficients(12) for light in lights[:3]), grace])
    assert_allclose(found.mean, values.mean(axis=0), rtol=1e-12)
    assert_allclose(found.covariance, np.cov(values.T, bias=True), atol=1e-12)
    expected = project(
        lambda n: np.mean([HarmonicLight(one).irradiance(n) ** 2 for one in values], axis=0), 4, sphere_grid(20)
    )
    assert_allclose(found.power, expected, atol=1e-12)


def test_one_light_has_no_variance() -> None:
    found = light_statistics(hf.lights.sky())
    assert not found.covariance.any()
    assert_allclose(found.moment[:9, :9], np.outer(*[hf.lights.sky().coefficients()] * 2), rtol=1e-12)


@pytest.mark.parametrize("order", [1, 2, 14])
def test_a_covariance_of_coefficients(order: int) -> None:
    root = np.random.default_rng(order).normal(size=((order + 1) ** 2,) * 2)
    given = root @ root.T
    found = light_statistics(given)
    kept = min(len(given), 169)
    assert not found.mean.any()
    assert_allclose(found.covariance[:kept, :kept], given[:kept, :kept])
    assert not found.covariance[kept:].any()


def test_the_tail_is_what_higher_degrees_add() -> None:
    for name in ("sphere", "frontal", "natural"):
        found = light_statistics(name)
        for centered in (True, False):
            sizes = [np.abs(found.tail(order, centered)).max() for order in (0, 1, 2, 4, 12)]
            assert sizes == sorted(sizes, reverse=True)
            assert sizes[-1] < 2e-4
    # a lamp's energy beyond order 2 is 1 - 127/128 of 1/6
    assert_allclose(light_statistics("sphere").tail(2, True)[0] / np.sqrt(4 * np.pi), 1 / 6 / 128, rtol=1e-9)


def test_statistics_stay_as_they_are() -> None:
    natural = light_statistics("natural")
    assert light_statistics(natural) is natural is light_statistics("natural")


@pytest.mark.parametrize(
    ("lights", "message"),
    [
        ("moonlight", "light: expected one of .*, got 'moonlight'"),
        ([], "lights: expected one of 'sphere', 'frontal', 'natural', a Light or several"),
        (None, "lights: expected one of 'sphere', 'frontal', 'natural', a Light or several.*got NoneType"),
        (np.ones((2, 3)), r"lights: expected one of .*, got an array of shape \(2, 3\)"),
        (np.ones((2, 2, 2)), r"lights: expected one of .*, got an array of shape \(2, 2, 2\)"),
        (1.0, "lights: expected one of"),
        ([np.nan, 0, 0, 0], "lights: expected one of"),
        ([1.0, 0.0], r"coefficients: expected \(order \+ 1\)\^2 of them"),
        (np.eye(5), r"coefficients: expected \(order \+ 1\)\^2 of them"),
        ([0.0, 0.1, 0.0, 0.0], "lights: expected a density with an integral above 0, got 0 in degree 0"),
        ([1.0, 5.0, 0.0, 0.0], "lights: expected a density of at least 0, got one that is negative in some directions"),
        (np.triu(np.ones((4, 4))), "lights: expected a symmetric covariance"),
        (-np.eye(4), "lights: expected a covariance without negative eigenvalues"),
    ],
)
def test_what_is_no_distribution_is_refused(lights: object, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        light_statistics(lights)  # type: ignore[arg-type]
