"""Depth meshes: vertices are pixels, squares are filled, steps are cut."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces.depth import surface_from_depth
from harmonicface.surfaces.depth_mesh import mesh_from_depth
from harmonicface.surfaces.raster import rasterize
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.view import View


def plate(depth, mask=None, pixel_size=1.0, albedo=0.5):
    depth = np.asarray(depth, dtype=np.float64)
    normals = np.tile([0.0, 0.0, 1.0], (*depth.shape, 1))
    return Surface(normals, np.broadcast_to(albedo, depth.shape), mask, depth, pixel_size)


def triangle_normals(mesh):
    corners = mesh.vertices[mesh.faces]
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def test_vertices_are_the_masked_pixels_in_row_major_order():
    mask = np.array([[True, True, False], [True, True, True]])
    albedo = np.arange(6.0).reshape(2, 3) / 6
    surface = plate([[1, 2, 9], [3, 4, 5]], mask, pixel_size=2.0, albedo=albedo)
    mesh = mesh_from_depth(surface)
    assert mesh.vertices.tolist() == [[-2, 1, 1], [0, 1, 2], [-2, -1, 3], [0, -1, 4], [2, -1, 5]]
    assert mesh.vertex_albedo.tolist() == [[value] * 3 for value in albedo[mask]]
    assert mesh.is_grey
    assert np.array_equal(mesh.normals, surface.pixel_normals)
    assert len(mesh.faces) == len(mesh.face_texture) == 3  # a whole square, and half of one
    assert mesh.uv is None and mesh.textures == ()


def test_colour_and_types():
    colour = Surface(
        np.tile(np.float32([0, 0, 1]), (2, 2, 1)),
        np.full((2, 2, 3), [0.1, 0.2, 0.3], np.float32),
        depth=np.zeros((2, 2)),
    )
    mesh = mesh_from_depth(colour)
    assert mesh.vertex_albedo == pytest.approx(np.tile([0.1, 0.2, 0.3], (4, 1)))
    assert not mesh.is_grey
    assert {mesh.vertices.dtype, mesh.normals.dtype, mesh.vertex_albedo.dtype} == {np.dtype(np.float64)}
    assert mesh.faces.dtype == np.int64


@given(st.integers(2, 9), st.integers(2, 9), st.floats(-1, 1), st.floats(-1, 1), st.floats(1e-3, 1e3))
def test_a_plane_is_filled_once_and_faces_the_camera(height, width, across, down, pixel_size):
    rows, columns = np.mgrid[:height, :width]
    mesh = mesh_from_depth(plate((across * columns + down * rows) * pixel_size, pixel_size=pixel_size))
    area = triangle_normals(mesh)
    assert len(mesh.faces) == 2 * (height - 1) * (width - 1)
    assert area[:, 2] == pytest.approx(pixel_size**2, rel=1e-9)  # each half a pixel, none turned away
    slope = -area[:, :2] / area[:, 2:]
    assert slope == pytest.approx(np.tile([across, -down], (len(slope), 1)), abs=1e-9)


@given(st.integers(0, 10_000))
def test_the_mesh_seen_from_the_front_is_the_surface(seed):
    rng = np.random.default_rng(seed)
    mask = rng.random((7, 6)) < 0.8
    mask[:2, :2] = True
    surface = plate(rng.random((7, 6)), mask, 0.5, rng.random((7, 6)))
    mesh = mesh_from_depth(surface)
    view = View(np.eye(3), (-1.5, -1.75, 1.5, 1.75), (7, 6))
    seen = rasterize(view.project(mesh.vertices), mesh.faces, view.shape)
    whole = np.zeros(mask.shape, bool)
    whole[surface.mask] = np.isin(np.arange(len(mesh.vertices)), mesh.faces)
    assert np.array_equal(seen.mask, whole)
    assert seen.depth[whole] == pytest.approx(surface.depth[whole], abs=1e-9)
    assert seen.interpolate(mesh.vertex_albedo[:, 0], mesh.faces)[whole] == pytest.approx(surface.albedo[whole])


@pytest.mark.parametrize("missing", [(0, 0), (0, 1), (1, 0), (1, 1)])
def test_three_pixels_of_a_square_make_one_triangle(missing):
    mask = np.ones((2, 2), bool)
    mask[missing] = False
    mesh = mesh_from_depth(plate(np.zeros((2, 2)), mask))
    assert sorted(mesh.faces[0]) == [0, 1, 2] and len(mesh.faces) == 1
    assert triangle_normals(mesh)[0, 2] == 1


def test_the_diagonal_follows_the_lesser_step():
    level_down = mesh_from_depth(plate([[0, 2], [1, 0]]))
    level_up = mesh_from_depth(plate([[0, 1], [1, 2]]))
    for mesh, crease, other in ((level_down, {0, 3}, {1, 2}), (level_up, {1, 2}, {0, 3})):
        corners = [set(face) for face in mesh.faces.tolist()]
        assert all(crease <= triangle for triangle in corners)
        assert not any(other <= triangle for triangle in corners)


def test_steps_are_cut_and_slopes_are_not():
    depth = np.zeros((4, 6))
    depth[:, 3:] = 10.0  # 84 degrees
    assert len(mesh_from_depth(plate(depth)).faces) == 2 * 3 * 4
    assert len(mesh_from_depth(plate(depth), 85.0).faces) == 2 * 3 * 5
    assert len(mesh_from_depth(plate(depth * 1e6), 90.0).faces) == 2 * 3 * 5
    assert len(mesh_from_depth(plate(depth, pixel_size=10.0)).faces) == 2 * 3 * 5  # 45 degrees
    slope = np.tile(5.0 * np.arange(6), (4, 1))  # 79 degrees all along
    assert len(mesh_from_depth(plate(slope)).faces) == 2 * 3 * 5


def test_a_slope_that_the_normals_know_of_is_no_step():
    depth = np.tile(10.0 * np.arange(4), (3, 1))  # 84 degrees
    for slope, faces in ((10.0, 12), (7.0, 12), (6.5, 0), (-10.0, 0), (0.0, 0)):
        normals = np.tile(np.array([-slope, 0, 1]) / np.hypot(slope, 1), (3, 4, 1))
        surface = Surface(normals, np.ones((3, 4)), depth=depth)
        if faces:
            assert len(mesh_from_depth(surface).faces) == faces, slope
        else:
            with pytest.raises(HarmonicFaceError, match="three neighbouring pixels without a step"):
                mesh_from_depth(surface)
    sideways = np.tile([-1.0, 0.0, 0.0], (3, 4, 1))  # as steep as anything, but to one side only
    assert len(mesh_from_depth(Surface(sideways, np.ones((3, 4)), depth=depth)).faces) == 12
    with pytest.raises(HarmonicFaceError, match="without a step"):
        mesh_from_depth(Surface(-sideways, np.ones((3, 4)), depth=depth))


def test_central_differences_do_not_hide_a_step():
    depth = np.zeros((4, 6))
    depth[:, 3:] = 10.0
    assert len(mesh_from_depth(surface_from_depth(depth)).faces) == 2 * 3 * 4


def test_a_ball_keeps_its_limb():
    across = (np.arange(64) + 0.5) / 32 - 1
    x, y = np.meshgrid(across, -across)
    inside = x**2 + y**2 < 1
    depth = np.where(inside, np.sqrt(np.maximum(1 - x**2 - y**2, 0)), np.nan)
    surface = surface_from_depth(depth, pixel_size=1 / 32)
    mesh = mesh_from_depth(surface)
    whole = mesh_from_depth(surface, 90.0)
    assert np.linalg.norm(mesh.vertices, axis=1) == pytest.approx(1, abs=1e-6)
    assert len(mesh.faces) > 0.998 * len(whole.faces)


@pytest.mark.parametrize(
    ("surface", "steepest", "message"),
    [
        (Surface(np.tile([0.0, 0, 1], (2, 2, 1)), np.ones((2, 2))), 80.0, "expected one with depth, got none"),
        (plate(np.zeros((2, 2))), 91.0, "steepest: expected at most 90 degrees, got 91"),
        (plate(np.zeros((2, 2))), 0.0, "steepest: expected a finite number above 0"),
        (plate(np.zeros((1, 9))), 80.0, "depth: expected three neighbouring pixels without a step"),
        (
            plate(np.indices((4, 4)).sum(axis=0) % 2 * 99.0),
            80.0,
            "depth: expected three neighbouring pixels without a step",
        ),
    ],
)
def test_what_makes_no_mesh_is_refused(surface, steepest, message):
    with pytest.raises(HarmonicFaceError, match=message):
        mesh_from_depth(surface, steepest)
