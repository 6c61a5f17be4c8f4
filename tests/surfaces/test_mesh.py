"""What a camera sees of a mesh: spheres and planes in closed form, textures, and normals that would look away."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from harmonicface import _memory
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.meshes import Mesh
from harmonicface.surfaces.depth import surface_from_depth
from harmonicface.surfaces.mesh import surface_from_mesh
from harmonicface.surfaces.view import rotation_matrix

SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
UV = SQUARE[:, :2].copy()
TWO = np.array([[0, 1, 2], [0, 2, 3]])


def a_mesh(vertices, faces, normals=None, *, uv=None, textures=(), albedo=0.5):
    facing = np.tile([0.0, 0, 1], (len(vertices), 1))
    return Mesh(
        vertices=np.asarray(vertices, dtype=float),
        faces=np.asarray(faces),
        normals=facing if normals is None else np.asarray(normals, dtype=float),
        uv=uv,
        textures=tuple(np.asarray(texture, dtype=np.float32) for texture in textures),
        face_texture=np.full(len(faces), 0 if textures else -1),
        vertex_albedo=np.broadcast_to(np.asarray(albedo, dtype=float), (len(vertices), 3)).copy(),
    )


@pytest.fixture(scope="module")
def ball():
    sphere = trimesh.creation.icosphere(5)
    return a_mesh(sphere.vertices, sphere.faces, sphere.vertices)


@pytest.mark.parametrize("rotation", [(0, 0, 0), (35, -20, 70)])
def test_a_sphere_has_its_closed_form(ball, rotation):
    surface = surface_from_mesh(ball, 64, rotation=rotation, frame=(-1, -1, 1, 1))
    centres = (np.arange(64) + 0.5) / 32 - 1
    x, y = np.meshgrid(centres, -centres)
    radius = x**2 + y**2
    assert surface.pixel_size == pytest.approx(1 / 32)
    assert surface.mask.sum() == pytest.approx(np.pi * 32**2, rel=0.005)
    core = radius < 0.9**2
    z = np.sqrt(np.where(core, 1 - radius, 0))
    np.testing.assert_allclose(surface.depth[core], z[core], atol=2e-3)
    cosine = np.einsum("ij,ij->i", surface.normals[core], np.stack([x, y, z], axis=2)[core])
    assert np.degrees(np.arccos(cosine.min())) < 0.5
    assert surface.pixel_normals[:, 2].min() > 0


def test_everything_is_float32_and_grey_stays_grey(ball):
    surface = surface_from_mesh(ball, 16)
    assert surface.normals.dtype == surface.albedo.dtype == surface.depth.dtype == np.float32
    assert surface.albedo.shape == (16, 16)
    np.testing.assert_allclose(surface.pixel_albedo, 0.5)


@settings(max_examples=25, deadline=None)
@given(st.floats(-60, 60), st.floats(-60, 60), st.floats(-180, 180))
def test_a_turned_plane_is_exact(yaw, pitch, roll):
    turn = rotation_matrix((yaw, pitch, roll))
    plane = a_mesh(SQUARE * [40, 40, 0] - [20, 20, 2], TWO)
    surface = surface_from_mesh(plane, 20, rotation=(yaw, pitch, roll), frame=(-0.9, -0.9, 0.9, 0.9))
    normal = turn @ [0, 0, 1]
    np.testing.assert_allclose(surface.pixel_normals, np.tile(normal, (surface.mask.sum(), 1)), atol=1e-6)
    centres = 0.9 * ((np.arange(20) + 0.5) / 10 - 1)
    x, y = np.meshgrid(centres, -centres)
    origin = turn @ [0, 0, -2]
    z = origin[2] - (normal[0] * (x - origin[0]) + normal[1] * (y - origin[1])) / normal[2]
    assert surface.mask.all()
    np.testing.assert_allclose(surface.depth, z, atol=1e-5)


def test_normals_and_depth_tell_the_same_shape(ball):
    stretched = dataclasses.replace(ball, vertices=ball.vertices * [3, 4, 5])
    normals = ball.normals / [3, 4, 5]
    stretched = dataclasses.replace(stretched, normals=normals / np.linalg.norm(normals, axis=1, keepdims=True))
    surface = surface_from_mesh(stretched, 96, rotation=(20, 10, 5))
    again = surface_from_depth(surface.depth.astype(float), pixel_size=surface.pixel_size)
    facing = again.mask & (surface.normals[..., 2] > 0.6)
    cosine = np.einsum("ij,ij->i", surface.normals[facing], again.normals[facing])
    assert np.degrees(np.arccos(np.median(cosine))) < 0.5
    assert facing.sum() > 2000


def test_one_sample_a_pixel_is_the_centre(ball):
    surface = surface_from_mesh(ball, 32, frame=(-1, -1, 1, 1), supersample=1)
    centres = (np.arange(32) + 0.5) / 16 - 1
    x, y = np.meshgrid(centres, -centres)
    np.testing.assert_allclose(surface.normals[..., 0][surface.mask], x[surface.mask], atol=2e-3)
    np.testing.assert_allclose(surface.normals[..., 1][surface.mask], y[surface.mask], atol=2e-3)


def test_half_of_a_pixel_decides():
    strip = a_mesh(SQUARE * [2.51, 4, 1], TWO)
    surface = surface_from_mesh(strip, 4, frame=(0, 0, 4, 4), supersample=4)
    assert surface.mask.sum(axis=1).tolist() == [3] * 4
    narrow = a_mesh(SQUARE * [2.3, 4, 1], TWO)
    assert surface_from_mesh(narrow, 4, frame=(0, 0, 4, 4), supersample=4).mask.sum(axis=1).tolist() == [2] * 4


def test_from_behind_a_surface_shows_its_other_side():
    behind = a_mesh(SQUARE, TWO, np.tile([0.6, 0, 0.8], (4, 1)))
    surface = surface_from_mesh(behind, 4, rotation=(180, 0, 0))
    # turned about y the normal is (-0.6, 0, -0.8), and its other side (0.6, 0, 0.8)
    np.testing.assert_allclose(surface.pixel_normals, np.tile([0.6, 0, 0.8], (16, 1)), atol=1e-6)


def test_winding_the_other_way_does_not_turn_good_normals():
    surface = surface_from_mesh(a_mesh(SQUARE, TWO[:, ::-1]), 4)
    np.testing.assert_allclose(surface.pixel_normals, np.tile([0, 0, 1], (16, 1)))


def test_the_inside_of_a_bowl_is_seen_from_behind(ball):
    front = ball.faces[(ball.vertices[ball.faces][:, :, 2] > 0).all(axis=1)]
    surface = surface_from_mesh(dataclasses.replace(ball, faces=front), 32, rotation=(180, 0, 0), frame=(-1, -1, 1, 1))
    centres = (np.arange(32) + 0.5) / 16 - 1
    x, y = np.meshgrid(centres, -centres)
    core = x**2 + y**2 < 0.8
    np.testing.assert_allclose(surface.depth[core], -np.sqrt((1 - x**2 - y**2)[core]), atol=0.02)
    np.testing.assert_allclose(surface.normals[..., 0][core], -x[core], atol=0.01)


def test_shading_bent_out_of_sight_is_laid_down_sideways():
    bent = np.array([np.sin(np.radians(20)), 0, np.cos(np.radians(20))])
    surface = surface_from_mesh(
        a_mesh(SQUARE, TWO, np.tile(bent, (4, 1))), 4, rotation=(80, 0, 0), frame=(0, 0, 0.17, 0.17)
    )
    count = surface.mask.sum()
    assert count == 16
    np.testing.assert_allclose(surface.pixel_normals, np.tile([1, 0, 0], (count, 1)), atol=1e-6)


@pytest.mark.parametrize("normal", [(0, 0, -1), (0, 0, 0)])  # straight away, and none at all
def test_a_triangle_whose_normals_say_nothing_has_its_own(normal):
    surface = surface_from_mesh(a_mesh(SQUARE, TWO, np.tile(normal, (4, 1))), 4)
    np.testing.assert_allclose(surface.pixel_normals, np.tile([0, 0, 1], (16, 1)), atol=1e-6)


def test_normals_that_cancel_at_the_corners_leave_the_triangles_own():
    corners = [[0.8, 0, -0.6], [-0.8, 0, -0.6], [0, 0, 1.2], [0, 0, 1]]  # to the first triangle they sum to nothing
    surface = surface_from_mesh(a_mesh(SQUARE, TWO, corners), 64, supersample=1)
    assert np.abs(np.linalg.norm(surface.pixel_normals, axis=1) - 1).max() < 1e-6
    assert surface.pixel_normals[:, 2].min() >= 0


@pytest.mark.parametrize("rotation", [(0, 0, 0), (180, 0, 0), (40, -30, 10)])
def test_winding_does_not_matter_where_there_are_normals(ball, rotation):
    """Whole, inside out, and at random: a ball open at the front shows its outer and its inner side."""
    open_ball = dataclasses.replace(ball, faces=ball.faces[ball.vertices[ball.faces].mean(axis=1)[:, 2] < 0.7])
    at_random = np.random.default_rng(0).random(len(open_ball.faces)) < 0.5
    expected = surface_from_mesh(open_ball, 32, rotation=rotation)
    for turned in (np.ones_like(at_random), at_random):
        faces = np.where(turned[:, None], open_ball.faces[:, ::-1], open_ball.faces)
        seen = surface_from_mesh(dataclasses.replace(open_ball, faces=faces), 32, rotation=rotation)
        np.testing.assert_array_equal(seen.mask, expected.mask)
        np.testing.assert_allclose(seen.normals, expected.normals, atol=1e-6)


def test_a_pixel_whose_normals_cancel_is_outside():
    vertices = np.concatenate([SQUARE * [0.5, 1, 1], SQUARE * [0.5, 1, 1] + [0.5, 0, 0], SQUARE + np.array([1, 0, 0])])
    normals = np.repeat([[1.0, 0, 0], [-1.0, 0, 0], [0, 0, 1.0]], 4, axis=0)
    mesh = a_mesh(vertices, np.concatenate([TWO, TWO + 4, TWO + 8]), normals)
    assert surface_from_mesh(mesh, (1, 2), frame=(0, 0, 2, 1), supersample=4).mask.tolist() == [[False, True]]


def test_a_texture_lies_upright_on_the_mesh():
    texture = [[0.1, 0.2], [0.3, 0.4]]
    surface = surface_from_mesh(a_mesh(SQUARE, TWO, uv=UV, textures=[texture], albedo=1), 8, supersample=1)
    corners = surface.albedo[[1, 1, 5, 5], [1, 5, 1, 5]]
    np.testing.assert_allclose(surface.albedo.mean(), 0.25, atol=1e-6)
    assert corners.argsort().tolist() == [0, 1, 2, 3]


def test_a_fine_texture_is_averaged_not_sampled():
    checkers = np.indices((512, 512)).sum(axis=0) % 2
    surface = surface_from_mesh(a_mesh(SQUARE, TWO, uv=UV, textures=[checkers], albedo=1), 16)
    np.testing.assert_allclose(surface.albedo, 0.5, atol=0.01)
    ramp = np.tile(np.linspace(0, 1, 512), (512, 1))
    surface = surface_from_mesh(a_mesh(SQUARE, TWO, uv=UV, textures=[ramp], albedo=1), 16)
    expected = np.tile((np.arange(16) + 0.5) / 16, (16, 1))
    np.testing.assert_allclose(surface.albedo[:, 1:-1], expected[:, 1:-1], atol=2e-3)


def test_vertex_albedo_tints_and_colour_makes_three_channels():
    mesh = a_mesh(SQUARE, TWO, uv=UV, textures=[np.full((2, 2), 0.5)], albedo=(1, 0.5, 0.2))
    surface = surface_from_mesh(mesh, 4)
    np.testing.assert_allclose(surface.albedo, np.tile([0.5, 0.25, 0.1], (4, 4, 1)), atol=1e-6)
    corners = a_mesh(SQUARE, TWO, albedo=SQUARE[:, :1] * [1, 1, 1])
    expected = np.tile((np.arange(4) + 0.5) / 4, (4, 1))
    np.testing.assert_allclose(surface_from_mesh(corners, 4).albedo, expected, atol=1e-6)


def test_each_face_wears_its_own_texture():
    mesh = a_mesh(SQUARE, TWO, uv=UV, textures=[np.full((2, 2), 0.2), np.full((3, 3, 3), 0.8)], albedo=1)
    mesh = dataclasses.replace(mesh, face_texture=np.array([1, -1]))
    surface = surface_from_mesh(mesh, 8)
    assert surface.albedo.shape == (8, 8, 3)
    np.testing.assert_allclose(surface.albedo[7, 6], 0.8)
    np.testing.assert_allclose(surface.albedo[0, 1], 1.0)


def test_bad_views_are_refused(ball):
    with pytest.raises(HarmonicFaceError, match="frame: expected a part of the mesh in view"):
        surface_from_mesh(ball, 8, frame=(5, 5, 6, 6))
    for supersample in (0, 1.5, True):
        with pytest.raises(HarmonicFaceError, match="supersample: expected an integer of at least 1"):
            surface_from_mesh(ball, 8, supersample=supersample)
    for supersample in (1000, 10**30):
        with pytest.raises(HarmonicFaceError, match="supersample: expected at most 16384 finer pixels a side, got 64"):
            surface_from_mesh(ball, 64, supersample=supersample)


def test_a_raster_beyond_the_memory(ball, monkeypatch):
    monkeypatch.setattr(_memory, "physical_memory", lambda: 10**8)
    with pytest.raises(HarmonicFaceError, match=r"a raster of 6400 x 6400 pixels .*: need 8\.19 GB of memory"):
        surface_from_mesh(ball, 64, supersample=100)
