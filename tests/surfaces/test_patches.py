"""Patches: each point of a mesh lies in one, on one side."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from harmonicface.io.meshes import Mesh
from harmonicface.surfaces.patches import PIECES, Patches
from harmonicface.surfaces.scene import Scene
from harmonicface.surfaces.view import View


def patches_of(vertices, faces, **changes):
    vertices = np.asarray(vertices, dtype=np.float64)
    fields = {
        "normals": np.zeros_like(vertices),
        "uv": None,
        "textures": (),
        "face_texture": np.full(len(faces), -1),
        "vertex_albedo": np.full(vertices.shape, 0.5),
    }
    mesh = Mesh(vertices, np.asarray(faces), **(fields | changes))
    return Patches(Scene(mesh, View.fit(vertices, 8)))


SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
HALVES = np.array([[0, 1, 2], [0, 2, 3]])


def test_large_triangles_are_cut_and_small_ones_are_not():
    large_and_small = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0.5], [0.01, 0, 0.5], [0, 0.01, 0.5]]
    patches = patches_of(large_and_small, [[0, 1, 2], [3, 4, 5]])
    assert patches.sides == 2 * (PIECES**2 + 1)


@given(seed=st.integers(0, 10_000))
@settings(max_examples=20)
def test_the_middle_of_each_patch_lies_in_it(seed):
    rng = np.random.default_rng(seed)
    patches = patches_of(rng.normal(size=(9, 3)), [[0, 1, 2], [3, 4, 5], [6, 7, 8]])
    sides = rng.integers(patches.sides, size=500)
    triangle, weights = patches._middles(sides // 2)
    assert weights.min() > 0
    assert weights.sum(axis=1) == pytest.approx(1)
    assert np.array_equal(patches.side(triangle, weights, sides % 2 == 1), sides)


def test_points_of_a_triangle_fall_into_its_patches_evenly():
    patches = patches_of(SQUARE, HALVES)
    weights = np.random.default_rng(0).dirichlet(np.ones(3), size=200_000)
    sides = patches.side(np.ones(len(weights), int), weights, np.zeros(len(weights), bool))
    uses = np.bincount(sides // 2, minlength=patches.sides // 2)[PIECES**2 :]
    assert uses.min() > 0
    assert uses.std() < 1.1 * np.sqrt(uses.mean())


def test_corners_and_edges_belong_to_their_triangle():
    patches = patches_of(SQUARE, HALVES)
    corners = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0.5, 0.5], [0.5, 0, 0.5], [0.5, 0.5, 0]])
    for triangle in (0, 1):
        sides = patches.side(np.full(6, triangle), corners, np.zeros(6, bool))
        assert (sides // 2 // PIECES**2 == triangle).all()


def test_sides_have_opposite_normals():
    normals = np.tile([0.6, 0.0, 0.8], (4, 1))
    samples = patches_of(SQUARE, HALVES, normals=normals).samples(np.array([10, 11]))
    assert samples.geometric.tolist() == [[0, 0, 1], [0, 0, -1]]
    assert samples.normals == pytest.approx(np.array([[0.6, 0, 0.8], [-0.6, 0, -0.8]]))
    assert np.array_equal(samples.positions[0], samples.positions[1])


def test_triangles_have_their_own_normals_where_a_mesh_has_none():
    samples = patches_of(SQUARE, HALVES).samples(np.arange(4))
    assert np.array_equal(samples.normals, samples.geometric)
    sideways = patches_of(SQUARE, HALVES, normals=np.tile([1.0, 0, 0], (4, 1))).samples(np.arange(2))
    assert np.array_equal(sideways.normals, sideways.geometric)


def test_albedo_is_that_of_the_vertices_times_the_texture():
    texture = np.zeros((64, 64), np.float32)
    texture[:, 32:] = 1
    changes = {"uv": SQUARE[:, :2], "textures": (texture,), "face_texture": np.array([0, -1])}
    patches = patches_of(SQUARE, HALVES, **changes)
    samples = patches.samples(np.arange(0, patches.sides, 2))
    x, y = samples.positions[:, 0], samples.positions[:, 1]
    expected = np.where(y > x, 0.5, np.where(x > 0.5, 0.5, 0.0))
    away = (np.abs(x - 0.5) > 0.04) & (x > 0.04) & (x < 0.96)  # from the texture's borders, where it repeats
    assert samples.albedo[away] == pytest.approx(expected[away], abs=1e-6)
    assert samples.albedo.shape == (patches.sides // 2,)


def test_coloured_meshes_have_coloured_patches():
    colours = np.tile([0.9, 0.5, 0.1], (4, 1))
    assert patches_of(SQUARE, HALVES, vertex_albedo=colours).samples(np.arange(2)).albedo == pytest.approx(colours[:2])
