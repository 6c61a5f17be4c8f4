from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import nnls

from harmonicface.stereo.glossy import (
    DAMPING,
    LOWEST,
    ROUGHNESSES,
    SHARES,
    Lamps,
    before_the_camera,
    products,
    shading,
    shares_of,
    tangents,
)


def directions(count: int, seed: int) -> np.ndarray:
    found = np.random.default_rng(seed).normal(size=(count, 3))
    found[:, 2] = np.abs(found[:, 2]) + 0.3
    return found / np.linalg.norm(found, axis=1, keepdims=True)


@pytest.mark.parametrize("lobe", range(len(ROUGHNESSES)))
def test_the_facets_of_a_lobe_cover_the_surface_once(lobe: int) -> None:
    """The integral of D(h) (n.h) over the half sphere is 1: at n = v, G(n.v) = 1, so D = 4 f / G(n.l)."""
    cosines, weights = np.polynomial.legendre.leggauss(400)
    angles = (cosines + 1) * np.pi / 8  # of h, so that lamps at twice the angle stay before the surface
    lamps = np.stack([np.sin(2 * angles), np.zeros_like(angles), np.cos(2 * angles)], axis=1)
    shown = shading(np.array([[0.0, 0.0, 1.0]]), Lamps.of(lamps))[1 + lobe, :, 0].astype(float)
    area, before = ROUGHNESSES[lobe] ** 2, np.cos(2 * angles)
    masking = 2 * before / (before + np.sqrt(area + (1 - area) * before**2))
    density = 4 * shown / masking
    covered = (weights * np.pi / 8 * 2 * np.pi * np.sin(angles) * np.cos(angles)) @ density
    beyond = np.cos(np.pi / 4) ** 2  # facets tilted by more than 45 degrees, in closed form
    rest = area * beyond / (1 + (area - 1) * beyond)
    assert_allclose(covered + rest, 1, rtol=2e-4)


def test_lobes_are_reciprocal_but_for_the_view() -> None:
    """Exchanging lamp and camera leaves the reflectance f / (n.l) as it is."""
    turn = np.array([[0.8, 0.0, -0.6], [0.0, 1.0, 0.0], [0.6, 0.0, 0.8]])  # brings the lamp to the camera
    lamp, normal = turn.T @ [0.0, 0.0, 1.0], np.array([0.2, 0.3, np.sqrt(1 - 0.13)])
    there = shading(normal[None], Lamps.of(lamp[None]))[1:, 0, 0] / (normal @ lamp)
    back = shading((turn @ normal)[None], Lamps.of((turn @ [0.0, 0.0, 1.0])[None]))[1:, 0, 0] / normal[2]
    assert_allclose(there, back, rtol=1e-5)


def test_nothing_shines_where_the_lamp_is_behind() -> None:
    shown = shading(np.array([[0.6, 0.0, 0.8]]), Lamps.of(np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])))
    assert shown.shape == (SHARES, 2, 1)
    assert not shown.any()


def test_shares_are_those_of_nonnegative_least_squares() -> None:
    generator = np.random.default_rng(3)
    normals = directions(50, 4)
    pictures = shading(normals, Lamps.of(directions(40, 5))).astype(np.float64)
    seen = np.einsum("knp,kp->np", pictures, np.maximum(generator.normal(size=(SHARES, 50)), 0))
    seen += 0.02 * generator.normal(size=seen.shape)
    weights = generator.random(seen.shape)
    gram, right = products(pictures, weights, seen)
    once = shares_of(gram, right)
    found = once
    for _ in range(10):
        found = shares_of(gram, right, found)
    for pixel in range(50):
        root = np.sqrt(weights[:, pixel])
        damping = np.sqrt(DAMPING * np.einsum("kn,n->k", pictures[:, :, pixel] ** 2, weights[:, pixel]))
        matrix = np.vstack([(pictures[:, :, pixel] * root).T, np.diag(damping)])
        aim = np.append(seen[:, pixel] * root, np.zeros(SHARES))
        exact, rest = nnls(matrix, aim)
        assert np.linalg.norm(matrix @ found[:, pixel] - aim) <= rest * (1 + 1e-6)
        assert np.linalg.norm(matrix @ once[:, pixel] - aim) <= rest * 1.05  # a round's start for the next one
        assert_allclose(found[:, pixel], exact, atol=1e-3 * exact.max())


def test_tangents_are_at_right_angles() -> None:
    normals = np.vstack([directions(20, 6), np.eye(3)])
    first, second = tangents(normals)
    for one, other in ((first, normals), (second, normals), (first, second)):
        assert_allclose(np.einsum("pi,pi->p", one, other), 0, atol=1e-12)
    assert_allclose(np.linalg.norm(second, axis=1), 1)


def test_normals_are_turned_until_the_camera_sees_them() -> None:
    found = before_the_camera(np.array([[0.0, 2.0, 0.0], [0.0, 0.0, 0.5], [3.0, 0.0, -4.0], [0.0, 0.0, 0.0]]))
    assert_allclose(np.linalg.norm(found, axis=1), 1)
    assert (found[:, 2] >= LOWEST * 0.99).all()
    assert_allclose(found[1:], [[0, 0, 1], [1, 0, LOWEST / 0.6], [0, 0, 1]], atol=1e-3)
