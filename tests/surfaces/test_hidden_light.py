"""Integrals in elevation against quadrature, for every harmonic, horizon and normal."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from harmonicface.harmonics.basis import real_harmonics
from harmonicface.surfaces._hidden_light import VERTICAL, HiddenLight, antiderivatives, hidden_range, waves

NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)


def quadrature(order: int, normal: np.ndarray, slope: float, azimuth: float) -> np.ndarray:
    """The harmonics of the clamped cosine below a horizon, at one azimuth, by brute force (k,)."""
    towards = np.array([np.cos(azimuth), np.sin(azimuth)])
    edge = np.arctan2(-(normal[:2] @ towards), normal[2]) if normal[2] else 0.0
    edge = (edge + np.pi / 2) % np.pi - np.pi / 2  # where the tangent plane ends, if anywhere
    bounds = np.unique(np.clip([-np.pi / 2, edge, np.arctan(slope)], -np.pi / 2, np.arctan(slope)))
    total = np.zeros((order + 1) ** 2)
    for low, high in pairwise(bounds):
        e = low + (high - low) * (NODES + 1) / 2
        directions = np.stack([np.cos(e) * towards[0], np.cos(e) * towards[1], np.sin(e)], axis=1)
        clamped = np.maximum(directions @ normal, 0) * np.cos(e)
        total += (high - low) / 2 * (real_harmonics(directions, order) * clamped) @ WEIGHTS
    return total


@pytest.mark.parametrize("order", [0, 1, 2, 4, 8, 12])
def test_integrals_are_exact(order):
    rng = np.random.default_rng(order)
    normals = rng.normal(size=(40, 3))
    normals[:4] = [[0, 0, 1], [1, 0, 0], [0, 1, 0], [0, 0, -1]]
    normals[4:8, 2] *= 1e-9
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    azimuths = rng.uniform(-np.pi, np.pi, 3)
    slopes = np.tan(rng.uniform(-np.pi / 2, np.pi / 2, (3, 40)))
    slopes[0, ::7], slopes[1, ::7] = -np.inf, 1e9
    result = np.zeros(((order + 1) ** 2, 40))
    HiddenLight.of(order).take_away(result, normals, slopes, azimuths, 0.25)
    expected = -0.25 * sum(
        np.stack([quadrature(order, n, s, azimuth) for n, s in zip(normals, row, strict=True)], axis=1)
        for azimuth, row in zip(azimuths, slopes, strict=True)
    )
    np.testing.assert_allclose(result, expected, rtol=0, atol=1e-11)


def test_the_whole_half_plane_is_the_unshadowed_wall():
    # of a wall that faces the camera, all azimuths hide pi Y_00 / 2 each over 2 pi, whose sum is A_0 Y_00
    result = np.zeros((1, 1))
    everything = np.full((4, 1), np.inf)
    HiddenLight.of(0).take_away(result, np.array([[0.0, 0, 1]]), everything, np.arange(4.0), 2 * np.pi / 4)
    np.testing.assert_allclose(result, -np.pi / np.sqrt(4 * np.pi), rtol=1e-12)


@pytest.mark.parametrize("order", [0, 1, 2, 3, 4, 8])
def test_each_wave_is_needed_by_one_group(order):
    groups = HiddenLight.of(order).groups
    everything = np.concatenate([group.harmonics for group in groups])
    np.testing.assert_array_equal(np.sort(everything), np.arange((order + 1) ** 2))
    for name in ("of_horizontal", "of_vertical"):
        needed = np.concatenate([getattr(group, name) for group in groups])
        assert len(np.unique(needed)) == len(needed)


def test_antiderivatives_of_the_constant():
    # Y_00 times the integrals of cos^2 = (e + sin 2e / 2) / 2 and of sin cos = -cos 2e / 4
    constant = 1 / np.sqrt(4 * np.pi)
    np.testing.assert_allclose(
        antiderivatives(0)[:, 0], [[constant / 2, 0, constant / 4, 0, 0], [0, 0, 0, 0, -constant / 4]], atol=1e-15
    )


def test_waves_are_those_of_the_angle():
    angles = np.radians([-90, -89.9, -45, 0, 1e-7, 30, 89.9])
    slopes = np.clip(np.tan(angles), -VERTICAL, VERTICAL)
    k = np.arange(1, 11)[:, None]
    expected = np.concatenate([angles[None], np.sin(k * angles), np.cos(k * angles)])
    np.testing.assert_allclose(waves(slopes, 10), expected, rtol=0, atol=1e-10)


def test_nothing_is_hidden_below_the_tangent_plane_or_by_nothing():
    horizontal, vertical = np.array([[0.6, 0.6, -0.6, 0.6]]), np.array([0.8, 0.8, 0.8, 0.0])
    lower, upper = hidden_range(horizontal, vertical, np.array([[-0.8, -np.inf, 0.7, -np.inf]]))
    np.testing.assert_array_equal(lower, upper)
