"""Shapes on which surfaces are tried: the closed form of the nine harmonic images."""

from __future__ import annotations

import numpy as np
from scipy.special import sph_harm_y_all

from harmonicface.bench.stability.hard_surfaces import nine_images
from harmonicface.harmonics.conventions import to_scipy


def test_the_polynomials_are_the_harmonics_times_the_filter() -> None:
    """Against scipy's harmonics: nothing of the package but the order of coefficients."""
    normals = np.random.default_rng(0).normal(size=(20, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    polar, azimuth = np.arccos(normals[:, 2]), np.arctan2(normals[:, 1], normals[:, 0])
    theirs = sph_harm_y_all(2, 2, polar, azimuth)
    filters = np.repeat([np.pi, 2 * np.pi / 3, np.pi / 4], [1, 3, 5])
    for row, image in enumerate(nine_images(normals)):
        expected = np.tensordot(to_scipy(filters[row] * np.eye(9)[row]), theirs, ([0, 1], [0, 1]))
        np.testing.assert_allclose(image, expected.real, atol=1e-13)
