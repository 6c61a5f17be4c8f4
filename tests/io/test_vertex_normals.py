"""Vertex normals against spheres, cubes and seams."""

from __future__ import annotations

import numpy as np
import trimesh

from harmonicface.io.vertex_normals import vertex_normals


def test_a_sphere_has_radial_normals():
    ball = trimesh.creation.icosphere(4)
    normals = vertex_normals(np.asarray(ball.vertices), ball.faces)
    assert np.einsum("ij,ij->i", normals, ball.vertices).min() > np.cos(np.radians(0.2))


def test_a_cube_has_diagonal_normals_however_its_sides_are_cut():
    """Weighted by area a corner would lean to the sides whose two triangles meet there."""
    box = trimesh.creation.box()
    normals = vertex_normals(np.asarray(box.vertices), box.faces)
    np.testing.assert_allclose(normals, np.sign(box.vertices) / np.sqrt(3), atol=1e-12)


def test_split_vertices_leave_no_crease():
    ball = trimesh.creation.icosphere(2)
    whole = vertex_normals(np.asarray(ball.vertices), ball.faces)
    soup = np.asarray(ball.vertices)[ball.faces].reshape(-1, 3)
    soup[soup == 0] = -0.0  # the same position all the same
    split = vertex_normals(soup, np.arange(len(soup)).reshape(-1, 3))
    np.testing.assert_allclose(split, whole[ball.faces.ravel()], atol=1e-12)


def test_no_direction_is_the_zero_vector():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 5, 5], [2, 0, 0]])
    assert (vertex_normals(vertices, np.array([[0, 1, 4]])) == 0).all()  # no area
    assert (vertex_normals(vertices, np.array([[0, 1, 2], [0, 2, 1]])) == 0).all()  # opposite faces
    assert (vertex_normals(vertices, np.array([[0, 1, 2]]))[3] == 0).all()  # no face
