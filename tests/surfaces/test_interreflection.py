"""Interreflection: furnaces, a groove with known form factors, and the triangles of a depth map."""

from __future__ import annotations

import gc
from unittest import mock

import numpy as np
import pytest
import trimesh

from harmonicface.io.meshes import Mesh
from harmonicface.surfaces import interreflection
from harmonicface.surfaces.depth import surface_from_depth
from harmonicface.surfaces.interreflection import depth_exchange, exchange_of, mesh_exchange, with_bounces
from harmonicface.surfaces.mesh import surface_from_mesh
from harmonicface.surfaces.patches import Patches
from harmonicface.surfaces.scene import Scene
from harmonicface.surfaces.view import View


def mesh_of(vertices, faces, albedo=0.5):
    vertices = np.asarray(vertices, dtype=np.float64)
    colours = np.array(np.broadcast_to(albedo, vertices.shape))
    return Mesh(vertices, np.asarray(faces), np.zeros_like(vertices), None, (), np.full(len(faces), -1), colours)


def groove_factor(x: np.ndarray, cosine: float) -> np.ndarray:
    """The form factor from x on one strip of a groove to the whole other strip, both one wide: (1 + sin) / 2."""
    gap = np.sqrt(1 + x**2 - 2 * x * cosine)  # from x to the far edge of the other strip
    return (1 + (cosine - x) / gap) / 2


def groove_kernel(x: np.ndarray, y: np.ndarray, sine: float, cosine: float) -> np.ndarray:
    """The density of that form factor over the other strip."""
    return sine**2 * x * y / (2 * (x**2 + y**2 - 2 * x * y * cosine) ** 1.5)


@pytest.mark.parametrize("shape", ["box", "ball"])
def test_inside_a_closed_white_furnace_each_bounce_is_the_albedo_of_the_last(shape):
    body = trimesh.creation.box() if shape == "box" else trimesh.creation.icosphere(subdivisions=3)
    scene = Scene(mesh_of(body.vertices, body.faces, 0.7), View.fit(body.vertices, 8))
    patches = Patches(scene)
    samples = patches.samples(np.arange(1, patches.sides, 998))  # backs: the inner sides
    exchange = mesh_exchange(scene, samples, 2, rays=64)
    assert exchange.to_pixels.sum(axis=1) == pytest.approx(1, abs=1e-6)
    even = np.ones((exchange.pieces.pixels, 1))
    assert exchange.bounced(even, 1) == pytest.approx(0.7, abs=1e-6)
    assert exchange.bounced(even, 2) == pytest.approx(0.7 + 0.49, abs=1e-6)


@pytest.mark.parametrize("opening", [60.0, 90.0])
def test_a_groove_of_two_planes(opening):
    """Long strips at an angle under an even sky: E_0 = 1 - F, E_1 = albedo times the integral of the kernel."""
    sine, cosine = np.sin(np.radians(opening)), np.cos(np.radians(opening))
    half = np.radians(opening / 2)
    right = np.array([np.sin(half), 0.0, np.cos(half)])
    length = np.array([0.0, 20.0, 0.0])
    left = right * (-1, 1, 1)
    vertices = np.array([-length, right - length, right + length, length, left - length, left + length])
    scene_mesh = mesh_of(vertices, [[0, 1, 2], [0, 2, 3], [0, 3, 5], [0, 5, 4]], 0.6)
    surface = surface_from_mesh(scene_mesh, (2, 16), frame=(-right[0], -0.1, right[0], 0.1))
    scene = surface.scene
    samples = scene.samples(surface.mask)
    exchange = mesh_exchange(scene, samples, 1, rays=8192)
    x = np.linalg.norm(samples.positions[:, [0, 2]], axis=1)
    seen = np.asarray(exchange.to_pixels.sum(axis=1))[:, 0]
    assert seen == pytest.approx(samples.means(groove_factor(x, cosine)), abs=0.01)
    y = np.linalg.norm(exchange.pieces.positions[:, [0, 2]], axis=1)
    sky = 1 - groove_factor(y, cosine)
    fine = (np.arange(2000) + 0.5) / 2000
    thrown = 0.6 * (groove_kernel(x[:, None], fine, sine, cosine) * (1 - groove_factor(fine, cosine))).mean(axis=1)
    found = exchange.bounced(sky[:, None], 1)[:, 0]
    assert found == pytest.approx(samples.means(thrown), abs=0.006)


def test_the_two_sides_of_a_sheet_throw_light_each_for_itself():
    sheet = [[-1.0, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]]  # above a floor, counterclockwise from above
    floor = [[-3.0, -3, 0], [3, -3, 0], [3, 3, 0], [-3, 3, 0]]
    faces = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]
    surface = surface_from_mesh(mesh_of(sheet + floor, faces), 6)
    samples = surface.scene.samples(surface.mask)
    exchange = mesh_exchange(surface.scene, samples, 1, rays=256)
    assert (exchange.pieces.geometric[:, 2] == -1).all()  # what the camera's pixels see of the sheet is its underside
    assert exchange.pieces.positions[:, 2] == pytest.approx(1)


def test_a_depth_map_throws_light_as_its_mesh_does():
    x, y = np.meshgrid(np.linspace(-1, 1, 20), np.linspace(1, -1, 20))
    surface = surface_from_depth(x**2 + y**2, 0.5, pixel_size=2 / 19)
    exchange = depth_exchange(surface, rays=2048)
    assert exchange.to_pixels.shape == (400, 400)
    assert np.array_equal(exchange.pieces.normals, surface.pixel_normals)
    seen = np.asarray(exchange.to_pixels.sum(axis=1))[:, 0]
    middle = seen.reshape(20, 20)[9:11, 9:11]
    rim = 2.0  # all that is above the floor's slope, up to the corners of the square
    assert 0.3 < middle.min() < middle.max() < rim / (1 + rim)
    assert exchange.bounced(np.ones((400, 1)), 1)[:, 0] == pytest.approx(0.5 * seen)
    assert (exchange.bounced(np.ones((400, 1)), 2) > exchange.bounced(np.ones((400, 1)), 1)).any()


def test_a_plane_throws_nothing_on_itself():
    tilted = surface_from_depth(np.add.outer(0.3 * np.arange(9.0), 0.5 * np.arange(8.0)))
    assert depth_exchange(tilted).to_pixels.nnz == 0


def test_the_back_of_a_depth_map_throws_nothing():
    """Through the gap at a step, rays from below may meet the upper plate from behind."""
    depth = np.zeros((12, 12))
    depth[:, 6:] = 3.0
    surface = surface_from_depth(depth)
    exchange = depth_exchange(surface, rays=1024)
    high = surface.depth[surface.mask] > 1
    assert exchange.to_pixels[:, high].nnz == 0 or exchange.to_pixels[:, high][high].nnz == 0


def test_colours_are_thrown_each_by_its_own_albedo():
    box = trimesh.creation.box()
    scene = Scene(mesh_of(box.vertices, box.faces, [0.2, 0.5, 0.8]), View.fit(box.vertices, 8))
    patches = Patches(scene)
    exchange = mesh_exchange(scene, patches.samples(np.array([1, 2001])), 1, rays=64)
    count = exchange.pieces.pixels
    grey = exchange.bounced(np.ones((count, 4)), 1)
    assert grey.shape == (2, 4, 3)
    assert grey == pytest.approx(np.broadcast_to([0.2, 0.5, 0.8], grey.shape), abs=1e-6)
    light = np.broadcast_to([3.0, 2.0, 1.0], (count, 1, 3))
    assert exchange.bounced(light, 1) == pytest.approx(np.broadcast_to([0.6, 1.0, 0.8], (2, 1, 3)), abs=1e-6)


def test_bounces_add_to_transport():
    direct = np.ones((4, 5))
    assert np.array_equal(with_bounces(direct, np.ones((5, 4))), np.full((4, 5), 2.0))
    assert with_bounces(direct, np.ones((5, 4, 3))).shape == (4, 5, 3)


def test_many_bounced_pictures_of_a_surface_cost_one_exchange():
    bowl = np.add.outer(np.linspace(-1, 1, 9) ** 2, np.linspace(-1, 1, 9) ** 2)
    surface, other = (surface_from_depth(bowl, albedo, pixel_size=0.25) for albedo in (0.5, 0.9))
    with mock.patch.object(interreflection, "depth_exchange", wraps=depth_exchange) as computed:
        first = exchange_of(surface, 1)
        assert exchange_of(surface, 3) is first  # of depth, all is in it at once
        assert computed.call_count == 1
        assert exchange_of(other, 1).pieces.albedo[0] == 0.9
        assert exchange_of(surface, 1) is not first  # only the latest is kept
        assert computed.call_count == 3
        computed.reset_mock()  # it remembers what it was called with
    del surface, other, first
    gc.collect()
    assert not interreflection._LATEST  # and not beyond its Surface's life


def test_a_scene_knows_by_how_many_bounces():
    tent = [[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [0, 0, 1]]
    surface = surface_from_mesh(mesh_of(tent, [[0, 1, 2], [0, 2, 3], [0, 1, 4]]), 6)
    with mock.patch.object(interreflection, "mesh_exchange", wraps=mesh_exchange) as computed:
        once, twice = exchange_of(surface, 1), exchange_of(surface, 2)
        assert exchange_of(surface, 2) is twice is not once
        assert computed.call_count == 2
