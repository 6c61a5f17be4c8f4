"""The corollaries on non-negative light, two lights that no matte surface tells apart, and the linear program."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

import harmonicface as hf
from harmonicface.appearance import uniqueness
from harmonicface.appearance.uniqueness import light_uniqueness
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import degrees
from harmonicface.lighting.sources import DirectionalLights

Array = NDArray[np.float64]

RNG = np.random.default_rng(0)
NORMALS = RNG.normal(size=(500, 3))
NORMALS /= np.linalg.norm(NORMALS, axis=1, keepdims=True)
TETRAHEDRON = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(3)
TURNS = 2 * np.pi * np.arange(3) / 3
TRIANGLE = np.stack([np.cos(TURNS), np.sin(TURNS), 0 * TURNS], axis=1)


def clamped(directions: Array, strengths: Array) -> Array:
    """Return irradiance at the normals by the plain sum over lamps."""
    return np.maximum(NORMALS @ directions.T, 0) @ strengths


def test_two_lights_of_the_same_irradiance() -> None:
    """L = 1 and L = 1 + 5/3 cos^3 - cos (equation 30): both non-negative, no matte surface tells them apart."""
    nodes, weights = np.polynomial.legendre.leggauss(64)  # of the cosine to the normal, from 0 to 1
    nodes, weights = (nodes + 1) / 2, weights / 2
    angles = 2 * np.pi * np.arange(64) / 64
    for normal in NORMALS[:20]:
        first = np.linalg.svd(normal[None])[2][1]
        second = np.cross(normal, first)
        ring = np.sqrt(1 - nodes**2)[:, None]
        across, up = ring * np.cos(angles), ring * np.sin(angles)
        towards = across[..., None] * first + up[..., None] * second + nodes[:, None, None] * normal
        z = towards[..., 2]
        other = 1 + 5 / 3 * z**3 - z
        assert other.min() > 0.29  # at cos = 1 / sqrt(5) it is 1 - 2 / (3 sqrt(5)) = 0.70, at -1 it is 1/3
        irradiance = (other * (nodes * weights)[:, None]).sum() * 2 * np.pi / 64
        assert_allclose(irradiance, np.pi, rtol=1e-13)
    z = np.linspace(-1, 1, 201)
    assert (1 + 5 / 3 * z**3 - z).min() >= 1 / 3 - 1e-12


def test_one_and_two_sources_are_unique() -> None:
    for _ in range(20):
        assert light_uniqueness(DirectionalLights(RNG.normal(size=(1, 3)), [1.0])).reason == "one source"
        report = light_uniqueness(DirectionalLights(RNG.normal(size=(2, 3)), RNG.uniform(size=2)))
        assert report.unique
        assert report.reason == "two sources"
        assert report.bound == report.share == 0
        assert report.alternative is None
    assert light_uniqueness(DirectionalLights([[0, 0, 1], [0, 0, -1]], [1.0, 3.0])).unique


def test_three_independent_sources_are_unique_and_three_in_a_plane_may_not_be() -> None:
    """The paper's third corollary needs linear independence."""
    for _ in range(20):
        report = light_uniqueness(DirectionalLights(RNG.normal(size=(3, 3)), RNG.uniform(0.1, 1, 3)))
        assert report.unique
        assert report.reason == "three sources with linearly independent directions"
    flat = light_uniqueness(DirectionalLights(TRIANGLE, [1.0, 1.0, 2.0]))
    assert not flat.unique
    assert flat.alternative is not None
    assert_allclose([flat.share, flat.bound], 0.75)  # 1 of each lamp balances, of 4 in all
    assert_allclose(flat.alternative.irradiance(NORMALS), clamped(TRIANGLE, np.array([1.0, 1.0, 2.0])), atol=1e-12)
    narrow = TRIANGLE * [1, 1, 1] + [0.2, 0, 0] * np.array([[1], [8], [8]])  # in a plane, but in an open half of it
    assert light_uniqueness(DirectionalLights(narrow, [1.0, 1.0, 1.0])).unique


def test_light_inside_one_open_hemisphere_is_unique() -> None:
    directions = RNG.normal(size=(60, 3))
    directions[:, 2] = np.abs(directions[:, 2]) + 0.01
    report = light_uniqueness(DirectionalLights(directions, RNG.uniform(size=60)))
    assert report.unique
    assert report.reason == "all light inside one open hemisphere"
    rim = np.concatenate([directions, [[1.0, 0, 0], [-0.5, 0.9, 0], [-0.5, -0.9, 0]]])
    assert not light_uniqueness(DirectionalLights(rim, np.ones(63))).unique  # strictly inside is needed


def test_four_sources_are_the_counterexample() -> None:
    """A regular tetrahedron of lamps and the opposite one: the same irradiance, both non-negative, all light moved."""
    one = np.ones(4)
    assert_allclose(clamped(TETRAHEDRON, one), clamped(-TETRAHEDRON, one), atol=1e-14)
    for strengths, share in (([1.0, 1, 1, 1], 1.0), ([1.0, 2, 3, 4], 0.4)):
        light = DirectionalLights(TETRAHEDRON, strengths)
        report = light_uniqueness(light)
        assert not report.unique
        assert report.alternative is not None
        assert_allclose([report.share, report.bound], share, rtol=1e-9)
        assert report.alternative.strengths.min() >= 0
        assert_allclose(report.alternative.irradiance(NORMALS), clamped(TETRAHEDRON, np.array(strengths)), atol=1e-12)
        change = report.alternative.coefficients(8) - light.coefficients(8)
        seen = (degrees(8) < 2) | (degrees(8) % 2 == 0)
        assert_allclose(change[seen], 0, atol=1e-12)
        assert np.abs(change[degrees(8) == 3]).max() > 0.3


def test_invisible_parts_are_the_odd_degrees_above_one() -> None:
    """Theorem 2: adding any of them to a light that stays non-negative leaves the irradiance of every normal."""
    base = hf.EnvironmentMap(np.ones((32, 64)))
    odd = (degrees(7) % 2 == 1) & (degrees(7) > 1)
    change = RNG.normal(size=64) * odd @ real_harmonics(base.directions, 7).reshape(64, -1)
    other = hf.EnvironmentMap(1 + 0.9 * change.reshape(32, 64) / np.abs(change).max())
    assert_allclose(other.irradiance(NORMALS), base.irradiance(NORMALS), rtol=3e-3)  # of 32 rows of pixels
    assert np.ptp(other.radiance) > 1


def test_opposite_sources() -> None:
    pairs = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]])
    report = light_uniqueness(DirectionalLights(pairs, [1.0, 2, 3, 4]))
    assert report.unique
    assert report.reason == "no sources balance each other"
    turned = np.array([[0.6, 0.8, 0], [-0.6, -0.8, 0]])
    report = light_uniqueness(DirectionalLights(np.concatenate([pairs, turned]), [1.0, 1, 1, 1, 1, 1]))
    assert not report.unique  # three pairs in a plane are dependent
    assert report.alternative is not None
    expected = clamped(np.concatenate([pairs, turned]), np.ones(6))
    assert_allclose(report.alternative.irradiance(NORMALS), expected, atol=1e-12)
    assert 0.2 < report.share <= report.bound <= 0.5


def test_an_environment_may_be_quite_another_one() -> None:
    light = hf.lights.natural(0, 16)
    report = light_uniqueness(light)
    assert not report.unique
    assert report.alternative is not None
    assert_allclose(report.alternative.irradiance(NORMALS), light.irradiance(NORMALS), rtol=1e-11)
    assert report.share > 0.5
    assert 0 <= report.bound - report.share < 1e-3
    strengths = light.strengths.ravel()
    opposite = strengths.reshape(16, 32)[::-1, (np.arange(32) + 16) % 32].ravel()
    assert report.bound <= np.maximum(strengths, opposite).sum() / 2 / strengths.sum() + 1e-9  # lemma 1 alone


def test_sums_colours_and_darkness() -> None:
    white = hf.lights.directional(TETRAHEDRON[0]) + DirectionalLights(TETRAHEDRON[1:], np.ones((3, 3)) / 3)
    assert_allclose(light_uniqueness(white).share, 1)
    doubled = DirectionalLights(np.concatenate([TRIANGLE, TRIANGLE]), np.ones(6))
    assert_allclose(light_uniqueness(doubled).share, 1)
    assert light_uniqueness(DirectionalLights(TETRAHEDRON, np.zeros(4))).unique


def test_bad_input(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(
        hf.HarmonicFaceError, match="light: expected lamps, an environment map or a sum of them, got Am"
    ):
        light_uniqueness(hf.lights.ambient())
    with pytest.raises(hf.HarmonicFaceError, match="light: expected a map whose pixels have opposite ones"):
        light_uniqueness(hf.EnvironmentMap(np.ones((8, 15))))
    monkeypatch.setattr(uniqueness, "linprog", lambda *_, **__: SimpleNamespace(x=None, message="no"))
    with pytest.raises(hf.HarmonicFaceError, match="light: expected strengths that a linear program can balance"):
        light_uniqueness(DirectionalLights(TETRAHEDRON, np.ones(4)))
