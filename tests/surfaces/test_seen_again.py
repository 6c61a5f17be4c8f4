"""A mesh seen again is what the same camera saw the first time."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import harmonicface as hf
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.meshes import Mesh, read_mesh
from harmonicface.surfaces.mesh import surface_from_mesh
from harmonicface.surfaces.operations import resize
from harmonicface.surfaces.seen_again import see_again
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.turning import turn
from harmonicface.surfaces.view import View

FRAME = (-1.524, -0.479, 1.364, 2.409)  # brow to chin of the scan


def ball(colour: bool = False) -> Mesh:
    """Make a ball of radius 1."""
    v, u = np.meshgrid(np.linspace(-np.pi / 2, np.pi / 2, 30), np.linspace(0, 2 * np.pi, 60), indexing="ij")
    points = np.stack([np.cos(v) * np.sin(u), np.sin(v), np.cos(v) * np.cos(u)], axis=-1).reshape(-1, 3)
    number = np.arange(len(points)).reshape(v.shape)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
    faces = np.concatenate([np.stack([a, b, d], -1).reshape(-1, 3), np.stack([a, d, c], -1).reshape(-1, 3)])
    albedo = 0.5 + 0.3 * points * ([1, 0.5, 0.2] if colour else [0, 0, 0])
    return Mesh(points, faces, points, None, (), np.full(len(faces), -1), albedo)


@pytest.mark.parametrize("colour", [False, True])
@pytest.mark.parametrize("size", [24, (20, 30), 300])
def test_the_same_camera_sees_the_same(size: int | tuple[int, int], colour: bool) -> None:
    first = surface_from_mesh(ball(colour), size, rotation=(20.0, 10.0, 5.0))
    assert first.scene is not None
    again = see_again(first.scene.mesh, first.scene.view)
    np.testing.assert_array_equal(again.mask, first.mask)
    for name in ("normals", "albedo", "depth"):
        before, after = getattr(first, name), getattr(again, name)
        assert before.dtype == after.dtype and before.shape == after.shape
        np.testing.assert_allclose(after, before, atol=2e-7)
    assert again.pixel_size == first.pixel_size


def test_far_from_the_origin_depth_keeps_its_steps() -> None:
    mesh = ball()
    far = replace(mesh, vertices=mesh.vertices + np.array([0, 0, 1e6]))
    seen = see_again(far, View.fit(far.vertices, 32))
    assert seen.depth is not None and seen.depth.dtype == np.float64
    near = see_again(mesh, View.fit(mesh.vertices, 32))
    np.testing.assert_allclose(seen.depth[seen.mask] - 1e6, near.depth[near.mask], atol=1e-6)  # type: ignore[index]


def test_a_camera_that_sees_nothing_is_refused() -> None:
    aside = View.fit(ball().vertices, 8, frame=(5, 5, 6, 6))
    with pytest.raises(
        HarmonicFaceError, match="view: expected a part of the mesh in it, got a camera that sees nothing"
    ):
        see_again(ball(), aside)


@pytest.fixture(scope="module")
def scan(data_dir: Path) -> hf.Surface:
    folder = data_dir / "heads" / "LeePerrySmith"
    mesh = read_mesh(folder / "LeePerrySmith.glb", texture=folder / "Map-COL.jpg", flip_texture=True)
    return surface_from_mesh(mesh, 128, frame=FRAME)


def without_mesh(surface: Surface) -> Surface:
    return Surface(surface.normals, surface.albedo, surface.mask, surface.depth, surface.pixel_size)


def angles(one: Surface, other: Surface) -> np.ndarray:
    """Return the degrees between the normals of pixels that both have."""
    both = one.mask & other.mask
    return np.degrees(np.arccos(np.clip(np.einsum("pi,pi->p", one.normals[both], other.normals[both]), -1, 1)))


@pytest.mark.data
def test_pixels_resized_are_the_scan_seen_smaller(scan: hf.Surface) -> None:
    small, exact = resize(without_mesh(scan), 32), resize(scan, 32)
    assert (small.mask ^ exact.mask).sum() <= 3
    assert angles(small, exact).mean() < 0.2
    both = small.mask & exact.mask
    assert np.linalg.norm((small.albedo - exact.albedo)[both]) < 0.01 * np.linalg.norm(exact.albedo[both])


@pytest.mark.data
def test_depth_turned_is_the_scan_turned(scan: hf.Surface) -> None:
    turned, exact = turn(without_mesh(scan), (20.0, 0.0, 0.0)), turn(scan, (20.0, 0.0, 0.0))
    both = turned.mask & exact.mask
    assert both.sum() > 0.95 * exact.mask.sum()
    assert (turned.mask & ~exact.mask).sum() == 0
    assert np.median(angles(turned, exact)) < 0.06
    assert np.linalg.norm((turned.albedo - exact.albedo)[both]) < 0.02 * np.linalg.norm(exact.albedo[both])
