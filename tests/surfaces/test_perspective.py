"""The pinhole camera: closed forms, rays cast through every pixel, and triangles that reach behind it."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.meshes import Mesh
from harmonicface.surfaces.mesh import surface_from_mesh
from harmonicface.surfaces.perspective import PerspectiveView, rays
from harmonicface.surfaces.samples import sample

INTRINSICS = (60.0, 55.0, 24.0, 18.0)
SHAPE = (36, 50)
UPRIGHT = np.eye(3)


def a_mesh(vertices, faces, normals=None, **changes):
    vertices = np.asarray(vertices, dtype=float)
    values = {"uv": None, "textures": (), "face_texture": np.full(len(faces), -1)} | changes
    normals = np.zeros_like(vertices) if normals is None else np.asarray(normals, dtype=float)
    values.setdefault("vertex_albedo", np.full((len(vertices), 3), 0.5))
    return Mesh(vertices=vertices, faces=np.asarray(faces), normals=normals, **values)


@pytest.fixture(scope="module")
def ball():
    sphere = trimesh.creation.icosphere(5)
    return a_mesh(sphere.vertices, sphere.faces, sphere.vertices)


def at_origin(intrinsics=INTRINSICS, shape=SHAPE):
    return PerspectiveView(UPRIGHT, np.zeros(3), intrinsics, shape, 1.0)


def test_points_fall_where_the_pinhole_equations_say():
    view = at_origin()
    points = np.random.default_rng(0).uniform([-1, -1, -9], [1, 1, -2], (50, 3))
    pixels = view.project(points)
    np.testing.assert_allclose(pixels[:, 0], 24 + 60 * points[:, 0] / -points[:, 2])
    np.testing.assert_allclose(pixels[:, 1], 18 - 55 * points[:, 1] / -points[:, 2])
    np.testing.assert_array_equal(pixels[:, 2], points[:, 2])


def test_rays_lead_back_through_the_pixel_centres():
    view = at_origin()
    toward = view.toward()
    pixels = view.project((-3 * toward).reshape(-1, 3))
    rows, columns = np.mgrid[: SHAPE[0], : SHAPE[1]] + 0.5
    np.testing.assert_allclose(pixels[:, 0], columns.ravel(), atol=1e-12)
    np.testing.assert_allclose(pixels[:, 1], rows.ravel(), atol=1e-12)
    np.testing.assert_array_equal(toward, rays(INTRINSICS, SHAPE))


@settings(max_examples=30)
@given(st.tuples(*[st.floats(-180, 180)] * 3), st.floats(5, 300), st.floats(1, 29), st.floats(1, 39))
def test_the_default_distance_shows_everything_and_is_the_least(rotation, focal, cy, cx):
    points = np.random.default_rng(1).normal(size=(40, 3)) + np.array([100, -50, 7])
    view = PerspectiveView.fit(points, (30, 40), intrinsics=(focal, focal, cx, cy), rotation=rotation)
    pixels = view.project(points)
    assert pixels[:, :2].min() > -1e-6
    assert (pixels[:, :2].max(axis=0) < np.array([40, 30]) + 1e-6).all()
    slack = np.concatenate([pixels[:, :2].min(axis=0), np.array([40, 30]) - pixels[:, :2].max(axis=0)])
    assert slack.min() == pytest.approx(0, abs=1e-6)


def test_finer_pixels_show_the_same():
    view = at_origin()
    np.testing.assert_allclose(
        view.finer(3).project([[0.3, 0.2, -2]])[:, :2], 3 * view.project([[0.3, 0.2, -2]])[:, :2]
    )
    assert view.finer(3).shape == (108, 150)
    assert view.finer(2).pixel_size == pytest.approx(view.pixel_size / 2)


def test_a_sphere_has_its_closed_form(ball):
    """The ray through a pixel meets the unit sphere at distance d where (t s)^2 - 2 t s.c + c^2 = 1."""
    view = PerspectiveView.fit(ball.vertices, 64, intrinsics=(90, 90, 32, 32), distance=3.0)
    seen = sample(ball, view)
    direction = -view.toward() / np.linalg.norm(view.toward(), axis=2, keepdims=True)
    along = direction @ [0, 0, -3.0]
    root = along**2 - 8
    core = root > 0.05
    hit = (along - np.sqrt(np.maximum(root, 0)))[..., None] * direction
    np.testing.assert_allclose(seen.raster.depth[core], hit[core][:, 2], atol=3e-3)
    np.testing.assert_allclose(seen.normals[core], (hit - [0, 0, -3])[core], atol=5e-3)
    assert not seen.mask[root < -0.05].any()
    surface = surface_from_mesh(ball, 64, intrinsics=(90, 90, 32, 32), distance=3.0)
    assert surface.pixel_size == pytest.approx(-surface.depth[surface.mask].mean() / 90)
    assert surface.scene.view.distance == 3.0


def cast(mesh, view):
    """The first triangle that a ray through each pixel's centre meets, by trimesh, and the place where."""
    pytest.importorskip("embreex")
    placed = trimesh.Trimesh(view.place(mesh.vertices), mesh.faces, process=False)
    directions = -view.toward().reshape(-1, 3)
    place, ray, triangle = placed.ray.intersects_location(np.zeros_like(directions), directions, multiple_hits=False)
    numbers, depth = np.full(len(directions), -1), np.full(len(directions), np.nan)
    numbers[ray], depth[ray] = triangle, place[:, 2]
    return numbers.reshape(view.shape), depth.reshape(view.shape)


@pytest.mark.parametrize("seed", range(3))
def test_random_triangles_agree_with_rays_cast_through_every_pixel(seed):
    """Among and around the camera: many triangles cross the near plane."""
    rng = np.random.default_rng(seed)
    vertices = rng.uniform(-3, 3, (60, 3))
    mesh = a_mesh(vertices, rng.random((40, 60)).argsort(axis=1)[:, :3])
    view = at_origin()
    crossing = np.sign(vertices[mesh.faces][:, :, 2])
    assert (np.abs(crossing.sum(axis=1)) < 3).sum() > 10
    seen = sample(mesh, view)
    numbers, depth = cast(mesh, view)
    same = seen.raster.triangle == numbers
    assert same.mean() > 0.998  # embree works in float32: edges differ by a pixel here and there
    np.testing.assert_allclose(seen.raster.depth[same], depth[same], rtol=1e-4)
    points = seen.raster.interpolate(view.place(mesh.vertices), mesh.faces)
    inside = seen.mask
    np.testing.assert_allclose(points[inside], (-seen.raster.depth[..., None] * -view.toward())[inside], atol=1e-9)
    np.testing.assert_allclose(seen.raster.weights[inside].sum(axis=1), 1, atol=1e-9)


def test_attributes_are_interpolated_in_space_not_in_the_picture():
    """A floor that runs away from the camera: its texture coordinate is where the ray meets the floor."""
    floor = np.array([[-50.0, -1, 5], [50, -1, 5], [50, -1, -60], [-50, -1, -60]])  # from behind the camera to afar
    ramp = np.tile((floor[:, 2:] + 60) / 65, (1, 3))
    mesh = a_mesh(floor, [[0, 1, 2], [0, 2, 3]], np.tile([0.0, 1, 0], (4, 1)), vertex_albedo=ramp)
    view = at_origin()
    seen = sample(mesh, view)
    slope = view.toward()[..., 1]
    exact = np.where(slope > 0, -1 / np.where(slope > 0, slope, 1), np.nan)
    visible = (exact > -59) & seen.mask
    assert visible.sum() > 400
    np.testing.assert_allclose(seen.raster.depth[visible], exact[visible], rtol=1e-9)
    np.testing.assert_allclose(seen.albedo[visible], (exact[visible] + 60) / 65, rtol=1e-9)
    np.testing.assert_allclose(seen.normals[visible], np.tile([0, 1, 0], (visible.sum(), 1)), atol=1e-12)


def test_far_away_with_a_long_lens_is_orthographic(ball):
    flat = surface_from_mesh(ball, 32, frame=(-1, -1, 1, 1), rotation=(20, 30, 5))
    deep = surface_from_mesh(ball, 32, intrinsics=(16e6, 16e6, 16, 16), distance=1e6, rotation=(20, 30, 5))
    np.testing.assert_array_equal(flat.mask, deep.mask)
    np.testing.assert_allclose(flat.normals, deep.normals, atol=1e-4)
    np.testing.assert_allclose((deep.depth + 1e6)[deep.mask], flat.depth[flat.mask], atol=1e-4)
    assert deep.depth.dtype == np.float64  # float32 would lose all of the shape


def test_a_normal_may_look_away_from_the_axis_if_it_looks_at_the_pinhole():
    """A wall seen at the picture's border from its side: its normal has z < 0, and yet it is seen."""
    normal = np.array([-1.0, 0, -0.1]) / np.hypot(1, 0.1)
    along = np.array([normal[2], 0, -normal[0]])
    wall = np.array([2.0, 0, -5]) + np.array([s * along + [0, t, 0] for s, t in [(-1, -1), (1, -1), (1, 1), (-1, 1)]])
    mesh = a_mesh(wall, [[0, 1, 2], [0, 2, 3]], np.tile(normal, (4, 1)))
    seen = sample(mesh, at_origin())
    assert seen.mask.sum() > 10
    np.testing.assert_allclose(seen.normals[seen.mask], np.tile(normal, (seen.mask.sum(), 1)), atol=1e-12)


def test_a_texture_is_reduced_to_the_magnification_of_the_picture():
    square = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    checkers = (np.indices((512, 512)).sum(axis=0) % 2).astype(np.float32)
    mesh = a_mesh(
        square, [[0, 1, 2], [0, 2, 3]], uv=(square[:, :2] + 1) / 2, textures=(checkers,), face_texture=np.zeros(2, int),
        vertex_albedo=np.ones((4, 3)),
    )  # fmt: skip
    surface = surface_from_mesh(mesh, 16, intrinsics=(40, 40, 8, 8), distance=5.0)
    np.testing.assert_allclose(surface.pixel_albedo, 0.5, atol=0.01)


def test_what_lies_behind_the_camera_is_not_seen():
    mesh = a_mesh([[0, 0, 1], [1, 0, 1], [0, 1, 1]], [[0, 1, 2]])
    assert not sample(mesh, at_origin()).mask.any()
    with pytest.raises(HarmonicFaceError, match="expected all before the camera, got 3"):
        at_origin().project(mesh.vertices)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"intrinsics": (60, 60, 8)}, r"intrinsics: expected \(fx, fy, cx, cy\) in pixels"),
        ({"intrinsics": (0, 60, 8, 8)}, "intrinsics: expected focal lengths above 0, got fx = 0"),
        ({"intrinsics": (60, -1, 8, 8)}, "intrinsics: expected focal lengths above 0"),
        ({"intrinsics": (1e-9, 1e-9, 8, 8)}, "intrinsics: expected focal lengths of at least 0.001 pixels, got 1e-09"),
        ({"intrinsics": (60, 60, 8, -1e9)}, r"intrinsics: expected \(cx, cy\) within 100 sizes of the picture of"),
        (
            {"intrinsics": (60, 60, 8, 8), "distance": 1e-300},
            "distance: expected at least 1e-60 world units, got 1e-300",
        ),
        ({"intrinsics": (60, np.nan, 8, 8)}, "intrinsics: expected finite"),
        ({"intrinsics": "wide"}, "intrinsics: expected an array of real numbers"),
        ({"intrinsics": (60, 60, 99, 8)}, "distance: expected one"),
        ({"intrinsics": (60, 60, 999, 8), "distance": 5.0}, "intrinsics: expected a part of the mesh in view"),
        ({"intrinsics": (60, 60, 8, 8), "distance": -1.0}, "distance: expected a finite number above 0"),
        ({"intrinsics": (60, 60, 8, 8), "distance": np.inf}, "distance: expected a finite number above 0"),
        ({"intrinsics": (60, 60, 8, 8), "frame": (0, 0, 1, 1)}, "frame: expected none beside intrinsics"),
        ({"distance": 5.0}, "distance: expected intrinsics beside it"),
    ],
)
def test_bad_cameras_are_refused_in_one_line(ball, arguments, message):
    with pytest.raises(HarmonicFaceError, match=message) as caught:
        surface_from_mesh(ball, 16, **arguments)
    assert "\n" not in str(caught.value)


def test_points_without_extent_are_refused():
    with pytest.raises(HarmonicFaceError, match="points: expected some extent"):
        PerspectiveView.fit(np.zeros((3, 3)), 8, intrinsics=(9, 9, 4, 4))
    with pytest.raises(HarmonicFaceError, match="expected at least one, got none"):
        PerspectiveView.fit(np.zeros((0, 3)), 8, intrinsics=(9, 9, 4, 4))
