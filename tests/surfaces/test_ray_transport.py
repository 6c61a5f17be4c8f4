"""Transport by rays: closed forms of what a sphere, a square and a wall hide, and what must not change."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import trimesh

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.io.meshes import Mesh
from harmonicface.reflectance.filters import lambertian_weights
from harmonicface.surfaces.blockers import MeshBlocker
from harmonicface.surfaces.mesh import surface_from_mesh
from harmonicface.surfaces.ray_transport import direct_transport, ray_transport, unshadowed_transport
from harmonicface.surfaces.rays import RayCaster
from harmonicface.surfaces.scene import FineSamples
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.visible_sums import sphere_directions

AMBIENT = np.sqrt(np.pi) / 2  # T_00 with nothing in the way: pi Y_00


def mesh_of(vertices, faces, albedo=0.5):
    vertices = np.asarray(vertices, dtype=np.float64)
    colours = np.array(np.broadcast_to(albedo, vertices.shape))
    return Mesh(vertices, np.asarray(faces), np.zeros_like(vertices), None, (), np.full(len(faces), -1), colours)


def floor_points(positions):
    """Points that look up, one a pixel."""
    positions = np.asarray(positions, dtype=np.float64)
    up, number = np.tile([0.0, 0.0, 1.0], (len(positions), 1)), np.arange(len(positions))
    return FineSamples(positions, up, up, np.ones(len(positions)), number, number[:, None])


def seen_below(vertices, faces, positions, order=0, rays=4096):
    caster = RayCaster(vertices, faces)
    samples = floor_points(positions)
    return direct_transport(MeshBlocker(caster, samples), samples, order, rays)


def bowl(side=25):
    """A grid of a bowl with a bump in it, open to the camera."""
    x, y = np.meshgrid(np.linspace(-1, 1, side), np.linspace(-1, 1, side))
    z = x**2 + y**2 + 0.7 * np.exp(-20 * ((x - 0.2) ** 2 + y**2))
    number = np.arange(side * side).reshape(side, side)
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]))
    faces = np.concatenate([np.stack([a, b, d], axis=1), np.stack([a, d, c], axis=1)])
    return mesh_of(np.stack([x, y, z], axis=-1).reshape(-1, 3), faces)


def test_below_a_sphere():
    ball = trimesh.creation.icosphere(subdivisions=4)
    across = np.repeat([0.0, 0.5, 1.0, 2.0], 64)  # each point has its own directions
    below = np.stack([across, 0 * across, 0 * across - 2], axis=1)
    share = 2 / (across**2 + 4) ** 1.5  # R^2 cos / d^2, with cos = 2 / d
    error = seen_below(ball.vertices, ball.faces, below, rays=1024)[0] / AMBIENT - (1 - share)
    assert np.abs(error).max() < 0.015
    assert np.abs(error.reshape(4, 64).mean(axis=1)).max() < 1.5e-3  # no bias but that of the inscribed polyhedron


def test_below_the_middle_of_a_square():
    square = np.array([[-1.0, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]])
    hidden = 4 / np.pi * (1 / np.sqrt(2)) * np.arctan(1 / np.sqrt(2))  # four corners, a = b = 1
    found = seen_below(square, [[0, 1, 2], [0, 2, 3]], [[0, 0, 0]])[0, 0] / AMBIENT
    assert found == pytest.approx(1 - hidden, abs=3e-3)


def test_beside_a_long_wall_seen_from_above():
    """The wall itself is not in the picture; it hides (1 - d / sqrt(d^2 + H^2)) / 2 of an even sky."""
    vertices = [[0, -50, 0], [8, -50, 0], [8, 50, 0], [0, 50, 0], [0, -50, 2], [0, 50, 2]]
    surface = surface_from_mesh(
        mesh_of(vertices, [[0, 1, 2], [0, 2, 3], [0, 3, 5], [0, 5, 4]]), (1, 8), frame=(0, 0, 8, 1)
    )
    distance = np.arange(8)[:, None] + (np.arange(4) + 0.5) / 4
    hidden = ((1 - distance / np.sqrt(distance**2 + 4)) / 2).mean(axis=1)  # the pixel's own mean
    found = ray_transport(surface, 0, rays=16384)[0] / AMBIENT
    assert found == pytest.approx(1 - hidden, abs=2e-3)


def test_nothing_in_the_way_of_a_convex_body():
    hull = trimesh.creation.icosphere(subdivisions=2)
    surface = surface_from_mesh(mesh_of(hull.vertices, hull.faces), 12)
    samples = surface.scene.samples(surface.mask)
    free = unshadowed_transport(samples, 4)
    assert ray_transport(surface, 4) == pytest.approx(free, abs=2e-6)  # float32
    direct = real_harmonics(samples.normals, 4) * lambertian_weights(4)[:, None]
    assert samples.means(direct.T) == pytest.approx(free.T)


def test_nothing_gets_into_a_closed_box():
    box = trimesh.creation.box()
    inside = -box.face_normals
    samples = FineSamples(box.triangles_center, inside, inside, np.ones(12), np.arange(12), np.arange(12)[:, None])
    blocker = MeshBlocker(RayCaster(box.vertices, box.faces), samples)
    assert np.array_equal(direct_transport(blocker, samples, 2), np.zeros((9, 12)))


def test_triangles_that_face_away_get_no_light_whatever_their_smooth_normals():
    square = mesh_of([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    square.normals[:] = [0.6, 0.0, 0.8]
    surface = surface_from_mesh(square, 2)
    lit = ray_transport(surface, 0, rays=8192)[0, 0] / AMBIENT
    assert lit == pytest.approx((1 + 0.8) / 2, abs=3e-3)  # of the hemisphere of n, what is above the plane


@pytest.mark.parametrize(("scale", "far"), [(1e-3, 0.0), (1e3, 0.0), (1.0, 1e4)])
def test_unit_and_place_make_no_difference(scale, far):
    mesh = bowl()
    oblique = (17.0, 8.0, 5.0)  # so that no sample lies on an edge, where rounding chooses the triangle
    surface = surface_from_mesh(mesh, 12, rotation=oblique)
    moved = surface_from_mesh(mesh_of((mesh.vertices + far) * scale, mesh.faces), 12, rotation=oblique)
    reference = ray_transport(surface, 2)
    assert np.abs(ray_transport(moved, 2) - reference).max() < 1e-5
    assert reference[0].min() < 0.7 * AMBIENT


def test_error_falls_with_the_number_of_rays():
    surface = surface_from_mesh(bowl(), 16)
    exact = ray_transport(surface, 4, rays=8192).astype(np.float64)
    error = {
        rays: np.sqrt(((ray_transport(surface, 4, rays=rays) - exact) ** 2).sum() / (exact**2).sum())
        for rays in (128, 512, 2048)
    }
    assert error[512] < 0.05
    assert error[2048] < 0.6 * error[512] < 0.4 * error[128]


def test_lower_orders_are_the_first_rows():
    surface = surface_from_mesh(bowl(), 8)
    four = ray_transport(surface, 4)
    assert four.shape == (25, 64)
    assert four.dtype == np.float32
    assert ray_transport(surface, 1) == pytest.approx(four[:4], abs=1e-5)


def test_bounces_add_light_and_converge():
    surface = surface_from_mesh(bowl(9), 6)
    ambient = [ray_transport(surface, 0, bounces)[0] for bounces in range(4)]
    steps = [later - before for before, later in pairwise(ambient)]
    assert all((step > 0).all() for step in steps)
    assert (steps[1] < 0.5 * steps[0]).all()  # albedo 0.5
    assert (steps[2] < 0.5 * steps[1]).all()
    assert (ambient[3] < AMBIENT).all()


def test_coloured_bounces_have_three_transports():
    mesh = bowl()
    colours = np.broadcast_to([0.8, 0.4, 0.0], mesh.vertices.shape)
    surface = surface_from_mesh(mesh_of(mesh.vertices, mesh.faces, colours), 6)
    direct, bounced = ray_transport(surface, 1), ray_transport(surface, 1, bounces=1)
    assert direct.shape == (4, 36)
    assert bounced.shape == (4, 36, 3)
    more = bounced - direct[..., None]
    assert more[..., 0] == pytest.approx(2 * more[..., 1], abs=1e-5)
    assert more[..., 2] == pytest.approx(0, abs=1e-6)


def test_directions_are_spread_evenly():
    for directions in sphere_directions(3, 500):
        assert np.linalg.norm(directions, axis=1) == pytest.approx(1)
        moments = real_harmonics(directions, 6).mean(axis=1)
        assert np.abs(moments[1:]).max() < 5e-3


def test_bad_arguments_are_refused():
    wall = Surface(np.tile([0.0, 0.0, 1.0], (2, 2, 1)), np.ones((2, 2)))
    with pytest.raises(HarmonicFaceError, match="surface: expected one with a scene"):
        ray_transport(wall)
    surface = surface_from_mesh(bowl(), 4)
    for arguments, message in (((-1,), "order"), ((0, -1), "bounces"), ((0, 0, 0), "rays")):
        with pytest.raises(HarmonicFaceError, match=f"{message}: expected an integer of at least"):
            ray_transport(surface, *arguments)
