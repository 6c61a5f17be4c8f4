"""Positions are exact, triangles are turned the way of their neighbours, and what cannot agree is left alone."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from harmonicface.io import winding
from harmonicface.io.vertex_normals import vertex_normals
from harmonicface.io.winding import against_neighbours, positions


@pytest.fixture
def ball():
    return trimesh.creation.icosphere(3)


def random_places():
    rng = np.random.default_rng(0)
    return rng.integers(-3, 4, (500, 3)) * np.array([1.0, 1e-300, 1e300])


def test_positions_are_those_of_a_search_for_equal_rows():
    places = random_places()
    expected = np.unique(places + 0.0, axis=0, return_inverse=True)[1].reshape(-1)
    numbers = positions(places)
    assert sorted(set(numbers)) == list(range(expected.max() + 1))
    np.testing.assert_array_equal(numbers[:, None] == numbers, expected[:, None] == expected)


def test_places_with_the_same_hash_are_told_apart(monkeypatch):
    expected = positions(random_places())
    monkeypatch.setattr(winding, "MULTIPLIERS", np.zeros(3, dtype=np.uint64))
    numbers = positions(random_places())
    np.testing.assert_array_equal(numbers[:, None] == numbers, expected[:, None] == expected)
    assert positions(np.zeros((0, 3))).shape == (0,)


@pytest.mark.parametrize("share", [0.02, 0.3, 0.49])
def test_single_triangles_are_turned_back(ball, share):
    turned = np.random.default_rng(1).random(len(ball.faces)) < share
    faces = np.where(turned[:, None], ball.faces[:, ::-1], ball.faces)
    np.testing.assert_array_equal(against_neighbours(faces, ball.area_faces), turned)
    normals = vertex_normals(np.asarray(ball.vertices), faces)
    np.testing.assert_allclose(normals, vertex_normals(np.asarray(ball.vertices), ball.faces), atol=1e-12)


def test_triangles_that_share_no_vertex_are_turned_back_too(ball):
    soup = np.asarray(ball.vertices)[ball.faces].reshape(-1, 3)
    faces = np.arange(len(soup)).reshape(-1, 3)
    faces[::7] = faces[::7, ::-1]
    assert np.einsum("ij,ij->i", vertex_normals(soup, faces), soup).min() > 0.99


def test_each_part_goes_by_its_own_majority(ball):
    inside_out = ball.faces[:, ::-1].copy()
    inside_out[::9] = inside_out[::9, ::-1]
    both = np.concatenate([ball.faces, inside_out + len(ball.vertices)])
    vertices = np.concatenate([ball.vertices, np.asarray(ball.vertices) + np.array([9.0, 0, 0])])
    normals = vertex_normals(vertices, both)
    outward = np.concatenate([ball.vertices, ball.vertices])
    side = np.einsum("ij,ij->i", normals, outward)
    assert side[: len(ball.vertices)].min() > 0.99
    assert side[len(ball.vertices) :].max() < -0.99


def test_an_edge_of_three_triangles_connects_nothing():
    fins = np.array([[0, 1, 2], [0, 1, 3], [1, 0, 4]])
    assert not against_neighbours(fins, np.ones(3)).any()


def test_a_moebius_strip_is_left_as_it_is():
    top, bottom = np.arange(0, 10, 2), np.arange(1, 10, 2)
    after_top, after_bottom = np.append(top[1:], bottom[0]), np.append(bottom[1:], top[0])
    faces = np.concatenate([np.stack([top, bottom, after_top], 1), np.stack([bottom, after_bottom, after_top], 1)])
    assert not against_neighbours(faces, np.ones(len(faces))).any()


def test_triangles_with_a_corner_twice_have_no_neighbours_there():
    assert not against_neighbours(np.array([[0, 0, 1], [0, 0, 2], [0, 0, 0]]), np.zeros(3)).any()
