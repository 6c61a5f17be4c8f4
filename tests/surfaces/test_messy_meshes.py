"""Meshes as people have them: whatever is wrong with the file, the Surface is that of the clean one."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from harmonicface.surfaces.load import load_surface

VIEW = {"size": 32, "rotation": (20, -10, 5), "frame": (-1.3, -1.3, 1.3, 1.3)}


def bumpy():
    """A ball with a nose, so that a wrong side or a shift would show; without normals in its file."""
    ball = trimesh.creation.icosphere(4)
    nose = np.exp(-8 * ((np.asarray(ball.vertices) - [0.1, 0, 1]) ** 2).sum(axis=1))
    return np.asarray(ball.vertices) * (1 + 0.25 * nose[:, None]), np.asarray(ball.faces)


def seen(tmp_path, vertices, faces, name="a.ply"):
    trimesh.Trimesh(vertices, faces, process=False).export(tmp_path / name)
    return load_surface(tmp_path / name, **VIEW)


def same(one, other, atol=2e-5):
    np.testing.assert_array_equal(one.mask, other.mask)
    np.testing.assert_allclose(one.normals, other.normals, atol=atol)
    np.testing.assert_allclose(one.depth, other.depth, atol=atol)
    np.testing.assert_allclose(one.albedo, other.albedo, atol=1e-6)


@pytest.fixture
def clean(tmp_path):
    return seen(tmp_path, *bumpy())


def inside_out(vertices, faces):
    return vertices, faces[:, ::-1]


def single_triangles_flipped(vertices, faces):
    at_random = np.random.default_rng(0).random(len(faces)) < 0.1
    return vertices, np.where(at_random[:, None], faces[:, ::-1], faces)


def no_vertex_shared(vertices, faces):
    return vertices[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3)


def vertices_twice(vertices, faces):
    second = np.random.default_rng(0).random(faces.shape) < 0.5
    return np.concatenate([vertices, vertices]), faces + len(vertices) * second


def shuffled(vertices, faces):
    rng = np.random.default_rng(0)
    order = rng.permutation(len(vertices))
    return vertices[order], np.argsort(order)[faces][rng.permutation(len(faces))]


def with_vertices_of_no_face(vertices, faces):
    return np.concatenate([vertices, [[50.0, 50, 50]]]), faces


def with_faces_without_area(vertices, faces):
    return vertices, np.concatenate([faces, [[0, 0, 1], [2, 2, 2]]])


@pytest.mark.parametrize(
    "mess",
    [
        inside_out,
        single_triangles_flipped,
        no_vertex_shared,
        vertices_twice,
        shuffled,
        with_vertices_of_no_face,
        with_faces_without_area,
    ],
)
@pytest.mark.parametrize("name", ["a.ply", "a.glb", "a.obj", "a.stl"])
def test_a_messy_mesh_is_seen_as_the_clean_one(tmp_path, clean, mess, name):
    same(seen(tmp_path, *mess(*bumpy()), name), clean)


def test_all_of_it_at_once(tmp_path, clean):
    vertices, faces = bumpy()
    for mess in (single_triangles_flipped, vertices_twice, with_faces_without_area, shuffled, inside_out):
        vertices, faces = mess(vertices, faces)
    same(seen(tmp_path, vertices, faces), clean)


def test_edges_of_three_triangles_change_nothing_elsewhere(tmp_path, clean):
    """A fin behind the ball hangs on an edge that two triangles share already."""
    vertices, faces = bumpy()
    hidden = faces[vertices[faces].mean(axis=1)[:, 2].argmin()]
    tip = vertices[hidden].mean(axis=0) * 1.1
    fin = np.array([[hidden[0], hidden[1], len(vertices)]])
    same(seen(tmp_path, np.concatenate([vertices, tip[None]]), np.concatenate([faces, fin])), clean)


@pytest.mark.parametrize(("factor", "shift"), [(1e-3, 0.0), (1e3, 0.0), (1.0, 1e4)])
def test_metres_and_millimetres_and_far_away(tmp_path, factor, shift):
    vertices, faces = bumpy()
    vertices = vertices.astype(np.float32).astype(float)
    trimesh.Trimesh(vertices, faces, process=False).export(tmp_path / "a.ply")
    placed = factor * vertices + shift
    table = "\n".join(" ".join(map(repr, row)) for row in placed.tolist())
    triangles = "\n".join(f"3 {a} {b} {c}" for a, b, c in faces.tolist())
    properties = "\n".join(f"property double {axis}" for axis in "xyz")
    header = f"ply\nformat ascii 1.0\nelement vertex {len(vertices)}\n{properties}\nelement face {len(faces)}\n"
    text = f"{header}property list uchar int vertex_indices\nend_header\n{table}\n{triangles}\n"
    (tmp_path / "b.ply").write_text(text)
    one, other = (load_surface(tmp_path / name, 32) for name in ("a.ply", "b.ply"))
    np.testing.assert_array_equal(one.mask, other.mask)
    np.testing.assert_allclose(one.normals, other.normals, atol=1e-5)
    np.testing.assert_allclose(other.depth, factor * one.depth + shift, rtol=1e-6, atol=1e-6 * factor)
    assert other.pixel_size == pytest.approx(factor * one.pixel_size, rel=1e-6)


def test_far_from_the_origin_depth_keeps_its_digits(tmp_path):
    vertices, faces = bumpy()
    trimesh.Trimesh(vertices, faces, process=False).export(tmp_path / "a.obj", digits=12)
    text = (tmp_path / "a.obj").read_text()
    assert load_surface(tmp_path / "a.obj", 16).depth.dtype == np.float32
    moved = "\n".join(
        line if not line.startswith("v ") else "v " + " ".join(repr(float(x) + 1e5) for x in line.split()[1:4])
        for line in text.splitlines()
    )
    (tmp_path / "b.obj").write_text(moved)
    one, other = load_surface(tmp_path / "a.obj", 16), load_surface(tmp_path / "b.obj", 16)
    assert other.depth.dtype == np.float64
    np.testing.assert_allclose(other.depth - 1e5, one.depth, atol=1e-6)
