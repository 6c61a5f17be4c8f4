"""Renderings for the tests of unknown lamps: a bumpy ball, and lamps about the camera's axis."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

Doubles = NDArray[np.float64]


def lamps(count: int, seed: int = 0, widest: float = 50.0) -> Doubles:
    """Return directions within so many degrees of the camera's axis, (n, 3)."""
    random = np.random.default_rng(seed)
    heights = random.uniform(np.cos(np.radians(widest)), 1, count)
    around = random.uniform(0, 2 * np.pi, count)
    sideways = np.sqrt(1 - heights**2)
    return np.stack([sideways * np.cos(around), sideways * np.sin(around), heights], axis=1)


def bumpy_ball(size: int = 48, seed: int = 0) -> tuple[Doubles, NDArray[np.bool_]]:
    """Return unit normals (p, 3) and the mask of a cap of a ball with bumps of different sizes on it."""
    y, x = np.mgrid[1 : -1 : size * 1j, -1 : 1 : size * 1j]
    mask = x**2 + y**2 < 0.9**2
    bumps = gaussian_filter(np.random.default_rng(seed).normal(size=(size, size)), size / 14)
    depth = np.sqrt(np.maximum(1.05 - x**2 - y**2, 0.01)) + 0.03 * bumps / bumps.std()
    down, right = np.gradient(depth, 2 / (size - 1))
    normals = np.stack([-right, down, np.ones_like(depth)], axis=2)[mask]
    return normals / np.linalg.norm(normals, axis=1, keepdims=True), mask


def angles(found: Doubles, truth: Doubles) -> Doubles:
    """Return angles between vectors in degrees."""
    cosines = np.einsum("pk,pk->p", found, truth) / np.linalg.norm(found, axis=1) / np.linalg.norm(truth, axis=1)
    return np.degrees(np.arccos(np.clip(cosines, -1, 1)))
