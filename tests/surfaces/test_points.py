"""Points become surfaces: spheres and planes in closed form, one layer alone, holes closed only as far as stated."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from harmonicface import _memory
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.meshes import read_mesh
from harmonicface.surfaces import points as module
from harmonicface.surfaces.mesh import surface_from_mesh
from harmonicface.surfaces.points import surface_from_points

UP = [0.0, 0.0, 1.0]


def on_a_sphere(count, seed=0):
    points = np.random.default_rng(seed).normal(size=(count, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def on_a_wall(side=40, height=0.0):
    x, y = (grid.ravel() for grid in np.mgrid[0 : 1 : side * 1j, 0 : 1 : side * 1j])
    return np.stack([x, y, np.full_like(x, height)], axis=1)


def walls_normals(points):
    return np.tile(UP, (len(points), 1))


@pytest.mark.parametrize("count", [4000, 60000])
def test_a_sphere_has_its_closed_form(count):
    """Of n random points in a disc, weighted by (1 - s^2)^2, the mean lies R sqrt(0.3 / n) away from the middle."""
    radius = np.sqrt(8 * 4 / count)
    floor = 0.75 / 24
    inside = 8 * max(1, (floor / radius) ** 2)
    expected = np.degrees(max(radius, floor)) * np.sqrt(0.3 / inside)
    points = on_a_sphere(count)
    surface = surface_from_points(points, points, size=48, frame=(-1, -1, 1, 1), rotation=(30, 20, 10))
    centres = (np.arange(48) + 0.5) / 24 - 1
    x, y = np.meshgrid(centres, -centres)
    core = x**2 + y**2 < 0.85**2
    assert surface.mask[core].all()
    assert not surface.mask[x**2 + y**2 > 1.1].any()
    z = np.sqrt(np.where(core, 1 - x**2 - y**2, 0))
    cosine = np.einsum("pi,pi->p", surface.normals[core], np.stack([x, y, z], axis=2)[core])
    angles = np.degrees(np.arccos(np.minimum(cosine, 1)))
    assert np.sqrt(np.mean(angles**2)) < 1.25 * expected
    assert np.abs(surface.depth[core] - z[core]).max() < 0.05
    assert surface.pixel_normals[:, 2].min() >= 0


def test_a_tilted_plane_is_exact():
    points = on_a_wall()
    surface = surface_from_points(points - [0.5, 0.5, 0], walls_normals(points), size=20, rotation=(30, 0, 0))
    np.testing.assert_allclose(
        surface.pixel_normals, np.tile([0.5, 0, np.sqrt(0.75)], (surface.mask.sum(), 1)), atol=1e-6
    )
    x = (np.arange(20) + 0.5 - 10) * surface.pixel_size
    expected = np.tile(-x * np.tan(np.radians(30)), (20, 1))
    np.testing.assert_allclose(surface.depth[surface.mask], expected[surface.mask], atol=1e-6)


def test_only_the_nearest_layer_is_seen():
    front, back = on_a_wall(height=0.5), on_a_wall(height=0.0)
    normals = np.concatenate([walls_normals(front), np.tile([0.6, 0, 0.8], (len(back), 1))])
    albedo = np.concatenate([np.full(len(front), 0.2), np.full(len(back), 0.9)])
    surface = surface_from_points(np.concatenate([front, back]), normals, albedo, size=16)
    np.testing.assert_allclose(surface.normals[surface.mask], np.tile(UP, (surface.mask.sum(), 1)))
    np.testing.assert_allclose(surface.pixel_albedo, 0.2)
    np.testing.assert_allclose(surface.depth[surface.mask], 0.5)


def test_back_and_front_do_not_mix_where_they_meet():
    """A thin plate, closer than a disc is wide: its far side's normals point away and must not count."""
    front, back = on_a_wall(height=0.01), on_a_wall(height=0.0)
    normals = np.concatenate([np.tile([0.6, 0, 0.8], (len(front), 1)), np.tile([0.6, 0, -0.8], (len(back), 1))])
    surface = surface_from_points(np.concatenate([front, back]), normals, size=16)
    np.testing.assert_allclose(surface.pixel_normals, np.tile([0.6, 0, 0.8], (surface.mask.sum(), 1)), atol=1e-6)


def test_from_behind_a_wall_shows_its_other_side():
    points = on_a_wall()
    surface = surface_from_points(points, np.tile([0.6, 0, 0.8], (len(points), 1)), size=8, rotation=(180, 0, 0))
    np.testing.assert_allclose(surface.pixel_normals, np.tile([0.6, 0, 0.8], (surface.mask.sum(), 1)), atol=1e-6)


def test_small_holes_are_closed_and_large_ones_stay():
    points = on_a_wall(side=41)  # 1/40 apart: a radius is 1/40 * sqrt(2)
    distance = np.linalg.norm(points[:, :2] - 0.5, axis=1)
    small, large = points[distance > 0.02], points[distance > 0.2]
    assert surface_from_points(small, walls_normals(small), size=80).mask.all()
    mask = surface_from_points(large, walls_normals(large), size=80).mask
    open_radius = np.sqrt((~mask).sum() / np.pi) / 80
    assert 0.2 - 3 * np.sqrt(2) / 40 < open_radius <= 0.2


def test_a_point_alone_fills_no_more_than_three_radii():
    points = np.concatenate([on_a_wall(), [[6.0, 0.5, 0]]])
    surface = surface_from_points(points, walls_normals(points), size=(20, 140), frame=(0, 0, 7, 1))
    alone = surface.mask[:, 80:].sum() * surface.pixel_size**2
    assert 0 < alone < 1.2 * np.pi * (3 * np.sqrt(2) / 39) ** 2


def test_colour_is_kept_and_sizes_chunked(monkeypatch):
    points = on_a_sphere(3000)
    colours = (points + 1) / 2
    whole = surface_from_points(points, points, colours, size=24)
    assert whole.albedo.shape == (24, 24, 3)
    monkeypatch.setattr(module, "FRAGMENTS", 100)
    cut = surface_from_points(points, points, colours, size=24)
    np.testing.assert_allclose(whole.albedo, cut.albedo, atol=1e-6)
    np.testing.assert_array_equal(whole.mask, cut.mask)


@pytest.mark.parametrize("tilt", [0.0, 1e-300, 1e-9])
def test_discs_seen_edge_on_are_not_seen(tilt):
    points = np.concatenate([on_a_wall(), on_a_wall(height=0.5)])
    normals = walls_normals(points)
    normals[1600:] = [1, 0, tilt]
    surface = surface_from_points(points, normals, size=8)
    np.testing.assert_allclose(surface.depth[surface.mask], 0, atol=1e-12)


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_units_do_not_matter(scale):
    points = on_a_sphere(3000)
    one, other = (surface_from_points(unit * points, points, size=24) for unit in (1.0, scale))
    np.testing.assert_array_equal(one.mask, other.mask)
    np.testing.assert_allclose(one.normals, other.normals, atol=1e-5)
    np.testing.assert_allclose(one.depth * scale, other.depth, rtol=1e-4, atol=1e-5 * scale)


@pytest.mark.data
def test_the_points_of_a_scan_look_like_its_mesh(data_dir):
    head = read_mesh(data_dir / "heads" / "LeePerrySmith" / "LeePerrySmith.glb", texture=None)
    chosen = trimesh.Trimesh(head.vertices, head.faces, process=False)
    places, faces = trimesh.sample.sample_surface(chosen, 200_000, seed=0)
    weights = trimesh.triangles.points_to_barycentric(head.vertices[head.faces[faces]], places)
    normals = np.einsum("nk,nki->ni", weights, head.normals[head.faces[faces]])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    frame = (-1.524, -0.479, 1.364, 2.409)
    mesh, cloud = surface_from_mesh(head, 64, frame=frame), surface_from_points(places, normals, size=64, frame=frame)
    both = mesh.mask & cloud.mask
    assert both.sum() > 0.98 * mesh.mask.sum()
    cosine = np.einsum("pi,pi->p", mesh.normals[both], cloud.normals[both])
    assert np.degrees(np.arccos(np.minimum(np.median(cosine), 1))) < 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.zeros((1, 3)), [UP]), r"points: expected shape \(n, 3\) with n of at least 2"),
        ((np.zeros((2, 2)), [UP, UP]), "points: expected vectors"),
        ((np.zeros((2, 3)), [UP, UP]), "expected some extent"),
        (([[0, 0, 0], [1, 1, np.nan]], [UP, UP]), "points: expected finite"),
        (([[0, 0, 0], [1, 1, 1e200]], [UP, UP]), r"points: expected positions within 1e\+60, got 1e\+200"),
        (([[0, 0, 0], [1, 1, 1]], [UP]), "normals: expected shape"),
        (([[0, 0, 0], [1, 1, 1]], [UP, [0, 0, 2]]), "normals: expected unit vectors"),
        (([[0, 0, 0], [1, 1, 1]], [UP, UP], [1.0]), "albedo: expected shape"),
        (([[0, 0, 0], [1, 1, 1]], [UP, UP], [1.0, -1]), "albedo: expected at least 0, got -1"),
        (([[0, 0, 0], [1, 1, 1]], [UP, UP], None, 0), "size: expected pixels"),
    ],
)
def test_bad_points_are_refused(arguments, message):
    with pytest.raises(HarmonicFaceError, match=message):
        surface_from_points(*arguments)


def test_views_of_nothing_and_points_beyond_memory_are_refused(monkeypatch):
    points = on_a_wall()
    with pytest.raises(HarmonicFaceError, match="frame: expected some of the points in view"):
        surface_from_points(points, walls_normals(points), frame=(5, 5, 6, 6))
    monkeypatch.setattr(_memory, "physical_memory", lambda: 1000)
    with pytest.raises(HarmonicFaceError, match="a surface of 1600 points: need"):
        surface_from_points(points, walls_normals(points))
