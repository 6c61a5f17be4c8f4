"""Blockers: a mesh by rays, a depth map by its horizons."""

from __future__ import annotations

import numpy as np
import pytest

from harmonicface.surfaces.blockers import DepthBlocker, MeshBlocker, pixel_samples
from harmonicface.surfaces.depth import surface_from_depth
from harmonicface.surfaces.depth_mesh import mesh_from_depth
from harmonicface.surfaces.rays import RayCaster
from harmonicface.surfaces.surface import Surface


def hills():
    x, y = np.meshgrid(np.linspace(-3, 3, 40), np.linspace(3, -3, 40))
    return surface_from_depth(np.sin(2 * x) * np.cos(2 * y), pixel_size=6 / 39)


def pairs(surface, count=4000):
    rng = np.random.default_rng(0)
    samples = rng.integers(int(surface.mask.sum()), size=count)
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    facing = np.einsum("ni,ni->n", surface.pixel_normals[samples], directions) > 0.05
    return samples[facing], directions[facing]


def test_horizons_and_rays_say_the_same():
    """Of one surface; they differ where light grazes, by the chord between neighbouring pixels."""
    surface = hills()
    mesh = mesh_from_depth(surface)
    samples = pixel_samples(surface)
    rays = MeshBlocker(RayCaster(mesh.vertices, mesh.faces), samples)
    chosen, directions = pairs(surface)
    upward = directions[:, 2] > 0.05  # rays may leave a mesh from below its rim
    chosen, directions = chosen[upward], directions[upward]
    by_rays, by_horizons = (blocker.blocked(chosen, directions) for blocker in (rays, DepthBlocker(surface)))
    assert 0.1 < by_rays.mean() < 0.6
    assert (by_rays != by_horizons).mean() < 0.02


@pytest.mark.parametrize("direction", [(0.6, 0.0, 0.8), (0.0, -0.8, 0.6), (0.48, 0.64, 0.6)])
def test_one_direction_is_as_good_as_many(direction):
    surface = hills()
    blocker = DepthBlocker(surface)
    chosen = np.flatnonzero(surface.pixel_normals @ np.array(direction) > 0)
    one = blocker.blocked_toward(chosen, np.array(direction))
    many = blocker.blocked(chosen, np.broadcast_to(direction, (len(chosen), 3)))
    assert (one != many).mean() < 0.01
    assert 0.02 < one.mean() < 0.7


def test_a_step_hides_what_is_below_its_edge():
    depth = np.array([[0.0, 0.0, 0.0, 3.0]])
    step = Surface(np.tile([0.0, 0.0, 1.0], (1, 4, 1)), np.ones((1, 4)), depth=depth)
    blocker = DepthBlocker(step)
    degrees = np.array([44.0, 46.0, 56.0, 57.0, 71.0, 72.0])  # the edge stands at 45, 56.3 and 71.6 degrees
    directions = np.stack([np.cos(np.radians(degrees)), 0 * degrees, np.sin(np.radians(degrees))], axis=1)
    pixels = np.array([0, 0, 1, 1, 2, 2])
    expected = [True, False] * 3
    assert blocker.blocked(pixels, directions).tolist() == expected
    each = [blocker.blocked_toward(pixels[[i]], directions[i])[0] for i in range(6)]
    assert each == expected
    assert not blocker.blocked(np.array([3]), np.array([[1.0, 0.0, 0.0]])).any()


def test_pixel_samples_are_the_pixels():
    surface = hills()
    samples = pixel_samples(surface)
    assert samples.pixels == 1600
    assert samples.slots.shape == (1600, 1)
    assert np.array_equal(samples.normals, surface.pixel_normals)
    assert samples.positions[:, 2] == pytest.approx(surface.depth.ravel())
