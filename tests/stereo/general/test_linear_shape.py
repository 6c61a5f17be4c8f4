"""The search for the linear map of factors: its costs fall, what it expects counts."""

from __future__ import annotations

import numpy as np
import pytest

from harmonicface.stereo.factors import leading_factors
from harmonicface.stereo.general.linear_shape import LinearShape, away_from_behind, unit
from harmonicface.stereo.general.silhouette import balloon_depth, balloon_normals
from harmonicface.stereo.general.sky_cells import cell_shades


@pytest.fixture(scope="module")
def ball():
    """Return a ball's mask and normals, and photographs of it under a few bright cells of the sky."""
    y, x = np.mgrid[0.95:-0.95:17j, -0.95:0.95:17j]
    mask = x**2 + y**2 < 0.85
    normals = unit(np.stack([x, y, np.sqrt(np.maximum(1 - x**2 - y**2, 0))], axis=-1)[mask])
    rng = np.random.default_rng(0)
    sky = rng.uniform(0.2, 0.4, (14, 192)) + 4 * (rng.random((14, 192)) < 0.03)
    return mask, normals, 0.5 * sky @ cell_shades(normals)


def start_of(mask, photographs):
    factors = leading_factors(photographs, 4).right * np.sqrt(photographs.shape[1])
    bent = unit(balloon_normals(mask) * [1, 0.6, 1])
    linear = np.linalg.lstsq(factors.T, photographs.mean(axis=0)[:, None] * bent, rcond=None)[0]
    return factors, linear


def angles(found, normals):
    return np.degrees(np.arccos(np.clip((unit(found) * normals).sum(axis=1), -1, 1))).mean()


def test_search_comes_nearer_at_falling_costs(ball):
    mask, normals, photographs = ball
    factors, linear = start_of(mask, photographs)
    search = LinearShape(photographs, factors, mask, shadows=False)
    found, costs = search.search(linear, 4)
    pairs = np.reshape(costs, (-1, 2))
    assert len(pairs) >= 2 and (pairs[:, 1] < pairs[:, 0]).all()
    assert angles(search.normals(found), normals) < 0.8 * angles(search.normals(linear), normals)


def test_what_is_expected_draws(ball):
    mask, _, photographs = ball
    factors, linear = start_of(mask, photographs)
    upright = np.tile([0.0, 0.0, 1.0], (int(mask.sum()), 1))
    search = LinearShape(photographs, factors, mask, False, expected=upright, trust=np.full(len(upright), 10.0))
    found, _ = search.search(linear, 3)
    assert angles(search.normals(found), upright) < 0.5 * angles(search.normals(linear), upright)


def test_even_albedo_costs_nothing(ball):
    mask, _, photographs = ball
    factors, linear = start_of(mask, photographs)
    plain, even = (LinearShape(photographs, factors, mask, False, weight) for weight in (0.0, 0.1))
    assert even.explain(linear).cost >= plain.explain(linear).cost


def test_vectors_without_length_face_the_camera():
    assert unit(np.array([[0.0, 0.0, 0.0], [0.0, 3.0, 4.0]])).tolist() == [[0, 0, 1], [0, 0.6, 0.8]]


def test_normals_straight_away_are_turned():
    grid = np.array([[[0.0, 0.0, -1.0], [0.6, 0.0, -0.8]]])
    assert away_from_behind(grid, np.ones((1, 2), bool)).tolist() == [[[0, 0, 1], [0.6, 0, -0.8]]]


def test_balloon_over_a_disc_is_a_hemisphere():
    y, x = np.mgrid[-15:16, -15:16]
    mask = x**2 + y**2 <= 225
    depth = balloon_depth(mask)
    inside = x**2 + y**2 < 150
    exact = np.sqrt(15.7**2 - x**2 - y**2, where=inside, out=np.zeros((31, 31)))
    assert np.abs(depth - exact)[inside].max() < 0.7
    assert depth[~mask].max() == 0
    assert np.allclose(np.linalg.norm(balloon_normals(mask), axis=1), 1)
