"""The z-buffer against closed forms, a brute-force oracle and the properties that a raster must have."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay

from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces import _triangles as module
from harmonicface.surfaces.raster import rasterize

TRIANGLE = np.array([[0.0, 0.0, 1.0], [8.0, 0.0, 2.0], [0.0, 8.0, 5.0]])
ONE = np.array([[0, 1, 2]])


def pixel_centres(shape):
    rows, columns = np.mgrid[: shape[0], : shape[1]] + 0.5
    return np.stack([columns, rows], axis=2)


def brute_force(points, faces, shape):
    """Every pixel against every triangle, by trimesh's barycentric coordinates."""
    centres = pixel_centres(shape).reshape(-1, 2)
    nearest, seen = np.full(len(centres), -np.inf), np.full(len(centres), -1)
    for number, corners in enumerate(points[faces]):
        flat = np.repeat((corners * [1, 1, 0])[None], len(centres), axis=0)
        weights = trimesh.triangles.points_to_barycentric(flat, np.pad(centres, ((0, 0), (0, 1))), method="cramer")
        depth = weights @ corners[:, 2]
        better = (weights >= 0).all(axis=1) & (depth > nearest)
        nearest[better], seen[better] = depth[better], number
    return seen.reshape(shape), np.where(seen < 0, np.nan, nearest).reshape(shape)


def test_one_triangle_has_its_closed_form():
    raster = rasterize(TRIANGLE, ONE, (8, 10))
    centres = pixel_centres((8, 10))
    inside = centres.sum(axis=2) <= 8
    np.testing.assert_array_equal(raster.mask, inside)
    expected = 1 + centres[..., 0] / 8 + centres[..., 1] / 2
    np.testing.assert_allclose(raster.depth[inside], expected[inside], atol=1e-13)
    assert np.isnan(raster.depth[~inside]).all()
    assert (raster.weights[~inside] == 0).all()
    np.testing.assert_allclose(raster.weights[inside][:, 1], centres[inside][:, 0] / 8, atol=1e-13)


def test_interpolation_returns_the_pixel_centres():
    raster = rasterize(TRIANGLE, ONE, (8, 8))
    found = raster.interpolate(TRIANGLE[:, :2], ONE)
    np.testing.assert_allclose(found[raster.mask], pixel_centres((8, 8))[raster.mask], atol=1e-13)
    assert (found[~raster.mask] == 0).all()
    assert raster.interpolate(np.arange(3, dtype=np.float32), ONE).shape == (8, 8)
    assert raster.interpolate(np.ones((3, 2), dtype=np.float32), ONE).dtype == np.float32


@pytest.mark.parametrize("seed", range(4))
def test_random_triangles_agree_with_brute_force(seed):
    rng = np.random.default_rng(seed)
    points, faces = rng.uniform(-10, 60, (120, 3)), rng.random((80, 120)).argsort(axis=1)[:, :3]
    raster = rasterize(points, faces, (45, 50))
    seen, depth = brute_force(points, faces, (45, 50))
    np.testing.assert_array_equal(raster.triangle, seen)
    np.testing.assert_allclose(raster.depth, depth, atol=1e-9)


def test_a_sphere_has_its_closed_form():
    ball = trimesh.creation.icosphere(5, radius=30.0)
    raster = rasterize(ball.vertices + np.array([32, 32, 0]), ball.faces, (64, 64))
    x, y = (pixel_centres((64, 64)) - 32).transpose(2, 0, 1)
    exact = np.sqrt(np.maximum(900 - x**2 - y**2, 0))
    well_inside = x**2 + y**2 < 28**2
    # chords of an icosphere of 10242 vertices lie below the sphere by r (1 - cos(half an edge)) ~ 0.013
    assert np.abs(raster.depth - exact)[well_inside].max() < 0.05
    normals = raster.interpolate(np.asarray(ball.vertices) / 30, ball.faces)
    np.testing.assert_allclose(normals[well_inside][:, 2], exact[well_inside] / 30, atol=2e-3)


def test_winding_and_order_of_triangles_do_not_matter():
    rng = np.random.default_rng(1)
    points, faces = rng.uniform(0, 40, (60, 3)), rng.integers(0, 60, (50, 3))
    raster = rasterize(points, faces, (40, 40))
    order = rng.permutation(50)
    other = rasterize(points, faces[order][:, ::-1], (40, 40))
    np.testing.assert_array_equal(np.where(other.mask, order[other.triangle], -1), raster.triangle)


def test_of_triangles_at_the_same_depth_the_first_is_seen():
    faces = np.repeat(ONE, 5, axis=0)
    assert set(np.unique(rasterize(TRIANGLE, faces, (8, 8)).triangle)) == {-1, 0}


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.01, 100), st.floats(-1000, 1000))
def test_triangulated_plane_has_no_cracks_and_one_depth(seed, scale, offset):
    """Corners on a grid of half pixels put many edges exactly through pixel centres."""
    rng = np.random.default_rng(seed)
    xy = np.concatenate([rng.integers(0, 41, (60, 2)) / 2, [[0, 0], [20, 0], [0, 20], [20, 20]]]).astype(float)
    mesh = Delaunay(xy)
    points = np.column_stack([xy, xy @ [scale, -scale] + offset])
    raster = rasterize(points, mesh.simplices, (20, 20))
    assert raster.mask.all()
    expected = pixel_centres((20, 20)) @ [scale, -scale] + offset
    np.testing.assert_allclose(raster.depth, expected, atol=1e-10 * (scale + abs(offset)))
    assert raster.weights.min() >= 0
    np.testing.assert_allclose(raster.weights.sum(axis=2), 1, atol=1e-12)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_slanted_edges_leave_no_cracks(seed):
    """An irrational turn of a fan of slivers: every pixel within the rim is covered."""
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0, 2 * np.pi, 300))
    rim = 40 + 30 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    centre = rng.uniform(30, 50, 2)
    points = np.column_stack([np.vstack([rim, centre]), np.zeros(301)])
    faces = np.stack([np.arange(300), np.roll(np.arange(300), -1), np.full(300, 300)], axis=1)
    raster = rasterize(points, faces, (80, 80))
    reference = rasterize(points, Delaunay(rim).simplices, (80, 80))
    radius = np.linalg.norm(pixel_centres((80, 80)) - 40, axis=2)
    near_rim = radius > 30 * np.cos(np.diff(angle, append=angle[0] + 2 * np.pi).max() / 2)
    assert raster.mask[~near_rim].all()
    np.testing.assert_array_equal(raster.mask, reference.mask)


def test_triangles_without_area_are_not_seen():
    line = [[0.5, 0.5, 9.0], [4.5, 4.5, 9.0], [2.5, 2.5, 9.0]]
    thin = [[0.0, 0.0, 9.0], [8.0, 8.0, 9.0], [4.0, 4.0 + 1e-15, 9.0]]
    points = np.concatenate([TRIANGLE, line, thin])
    faces = np.array([[3, 4, 5], [6, 7, 8], [0, 1, 2], [0, 0, 1]])
    assert set(np.unique(rasterize(points, faces, (8, 8)).triangle)) == {-1, 2}


def test_big_triangles_are_cut_into_tiles_without_a_seam(monkeypatch):
    rng = np.random.default_rng(3)
    points, faces = rng.uniform(-400, 700, (30, 3)), rng.integers(0, 30, (12, 3))
    whole = rasterize(points, faces, (200, 300))
    monkeypatch.setattr(module, "LARGEST_TILE", 16)
    monkeypatch.setattr(module, "TILES", 50)
    monkeypatch.setattr(module, "CANDIDATES", 500)
    monkeypatch.setattr(module, "FEW", 0)
    cut = rasterize(points, faces, (200, 300))
    np.testing.assert_array_equal(whole.triangle, cut.triangle)
    np.testing.assert_array_equal(whole.depth, cut.depth)


def test_what_lies_outside_the_picture_is_not_seen():
    far = TRIANGLE + np.array([1e9, -1e9, 0])
    assert not rasterize(far, ONE, (8, 8)).mask.any()
    huge = np.array([[-1e7, -1e7, 3.0], [3e7, -1e7, 3.0], [-1e7, 3e7, 3.0]])
    np.testing.assert_allclose(rasterize(huge, ONE, (8, 8)).depth, 3.0)
    assert not rasterize(TRIANGLE, np.empty((0, 3), dtype=int), (8, 8)).mask.any()


@pytest.mark.parametrize(
    ("points", "faces", "shape", "message"),
    [
        ([[0, 0, np.nan]] * 3, ONE, (4, 4), "points: expected finite"),
        (np.zeros((3, 2)), ONE, (4, 4), "points: expected vectors"),
        (np.zeros((1, 3, 3)), ONE, (4, 4), r"points: expected shape \(n, 3\)"),
        (TRIANGLE, [[0, 1]], (4, 4), "faces: expected integers of shape"),
        (TRIANGLE, [[0.0, 1.0, 2.0]], (4, 4), "faces: expected integers of shape"),
        (TRIANGLE, [[0, 1, 3]], (4, 4), "faces: expected indices from 0 to 2, got 0 to 3"),
        (TRIANGLE, [[-1, 1, 2]], (4, 4), "faces: expected indices from 0 to 2, got -1 to 2"),
        (TRIANGLE, ONE, (0, 4), "size: expected pixels"),
    ],
)
def test_bad_input_is_refused(points, faces, shape, message):
    with pytest.raises(HarmonicFaceError, match=message):
        rasterize(points, faces, shape)


def test_interpolation_refuses_other_vertices_and_faces():
    raster = rasterize(TRIANGLE, np.repeat(ONE, 2, axis=0)[::-1], (8, 8))
    with pytest.raises(HarmonicFaceError, match="attribute: expected shape"):
        raster.interpolate(np.zeros((3, 2, 2)), ONE)
    with pytest.raises(HarmonicFaceError, match="attribute: expected finite"):
        raster.interpolate([np.nan, 0, 0], ONE)
    with pytest.raises(HarmonicFaceError, match="faces: expected at least 1 triangles, got 0"):
        raster.interpolate([0.0, 0, 0], np.empty((0, 3), dtype=int))
