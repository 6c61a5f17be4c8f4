"""First order: the null cone, integrability, and what neither can know."""

from __future__ import annotations

import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.factors import leading_factors
from harmonicface.stereo.lorentz import METRIC, _lorentz_rows, first_order_normals, integrable, null_cone


def hilly(size=64):
    """Return normals and albedo of hills that no symmetry helps, (h, w, 3) and (h, w)."""
    y, x = np.mgrid[1 : -1 : size * 1j, -1 : 1 : size * 1j]
    depth = 0.6 * np.exp(-2 * (x**2 + 1.5 * y**2)) + 0.2 * np.exp(-8 * ((x - 0.4) ** 2 + y**2))
    depth -= 0.15 * np.exp(-6 * ((x + 0.5) ** 2 + (y - 0.3) ** 2))
    down, right = np.gradient(depth, x[0, 1] - x[0, 0])
    normals = np.stack([-right, down, np.ones_like(depth)], axis=-1)
    return normals / np.linalg.norm(normals, axis=2, keepdims=True), 0.5 + 0.2 * np.sin(5 * x) * np.cos(4 * y)


@pytest.fixture(scope="module")
def coordinates():
    normals, albedo = hilly()
    return np.vstack([albedo.ravel(), (albedo[..., None] * normals).reshape(-1, 3).T])


def photographs(coordinates, noise=0.0, seed=1):
    rng = np.random.default_rng(seed)
    lights = np.hstack([np.full((20, 1), 2.0), 0.7 * rng.normal(size=(20, 3))])
    return lights @ coordinates + noise * rng.normal(size=(20, coordinates.shape[1]))


def error(found, coordinates):
    """Return the mean angle in degrees, convex or concave whichever is nearer."""
    unit = found / np.linalg.norm(found, axis=1, keepdims=True)
    true = (coordinates[1:] / coordinates[0]).T
    return min(
        np.degrees(np.arccos(np.clip((unit * sign * true).sum(axis=1), -1, 1))).mean()
        for sign in ([1, 1, 1], [-1, -1, 1])
    )


def test_factors_lie_on_the_cone_after_the_map(coordinates):
    factors = leading_factors(photographs(coordinates), 4).right
    found = null_cone(factors) @ factors
    assert np.abs(METRIC @ found**2).max() < 1e-6 * (found**2).sum(axis=0).max()
    assert found[0].sum() > 0


@pytest.mark.parametrize(("noise", "degrees"), [(0.0, 0.2), (1e-3, 1.0)])
def test_normals_but_for_convex_or_concave(coordinates, noise, degrees):
    mask = np.ones((64, 64), bool)
    factors = leading_factors(photographs(coordinates, noise), 4).right
    found = first_order_normals(factors, mask)
    assert error(found, coordinates) < degrees
    assert (found[:, 2] > 0).mean() > 0.99


def test_a_boost_changes_nothing(coordinates):
    """The cone map is free up to a Lorentz transformation; integrability takes it out."""
    mask = np.ones((64, 64), bool)
    boost = np.eye(4)
    boost[np.ix_([0, 1], [0, 1])] = [[np.cosh(0.4), np.sinh(0.4)], [np.sinh(0.4), np.cosh(0.4)]]
    turned = integrable(boost @ coordinates, mask) @ boost @ coordinates
    assert error(np.sign(np.median(turned[2])) * turned.T, coordinates) < 0.2


def test_factors_in_fewer_dimensions_are_refused(coordinates):
    flat = coordinates.copy()
    flat[3] = 0
    with pytest.raises(HarmonicFaceError, match="expected four independent factors"):
        null_cone(flat)


def test_too_few_neighbours_are_refused(coordinates):
    with pytest.raises(HarmonicFaceError, match="at least 24 pixels with four neighbours"):
        integrable(coordinates[:, :16], np.ones((4, 4), bool))


def test_coordinates_that_no_surface_gives_are_refused():
    with pytest.raises(HarmonicFaceError, match="expected coordinates of a surface, got some that slope one way"):
        _lorentz_rows(np.zeros((4, 4)), np.eye(4))
    with pytest.raises(HarmonicFaceError, match="expected coordinates of a surface, got zeros"):
        integrable(np.zeros((4, 100)), np.ones((10, 10), bool))
