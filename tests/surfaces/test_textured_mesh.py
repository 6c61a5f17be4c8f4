from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces.depth_mesh import mesh_from_depth
from harmonicface.surfaces.perspective import rays
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.textured_mesh import MOST_TEXTURE, textured_mesh

ROWS, COLUMNS = np.mgrid[:40, :50].astype(float)


def bump(offset: float = 0.0) -> Surface:
    """A bump whose albedo grows to the right and down."""
    depth = 6 * np.exp(-((COLUMNS - 25) ** 2 + (ROWS - 20) ** 2) / 150)
    normals = np.stack([depth * (COLUMNS - 25) / 75, -depth * (ROWS - 20) / 75, np.ones_like(depth)], axis=2)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    mask = np.hypot(COLUMNS - 25, ROWS - 20) < 18
    return Surface(normals, (COLUMNS + ROWS + 5) / 100, mask, depth + offset, pixel_size=0.5)


def at(texture: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Return the pixels of a texture in which texture coordinates lie."""
    height, width = texture.shape[:2]
    return texture[((1 - uv[:, 1]) * height).astype(int), (uv[:, 0] * width).astype(int)]


def test_the_mesh_of_the_depth_wears_the_albedo() -> None:
    surface = bump()
    mesh, plain = textured_mesh(surface), mesh_from_depth(surface)
    assert_array_equal(mesh.vertices, plain.vertices)
    assert_array_equal(mesh.faces, plain.faces)
    assert (mesh.face_texture == 0).all() and len(mesh.textures) == 1
    assert_allclose(at(mesh.textures[0], mesh.uv), surface.pixel_albedo, rtol=1e-6)
    assert_allclose(mesh.vertex_albedo, 1)


def test_no_rim_shines_through() -> None:
    mesh = textured_mesh(bump())
    texture, inside = mesh.textures[0], bump().mask
    assert texture[~inside].min() >= texture[inside].min() > 0
    assert texture[20, 0] == texture[20, np.flatnonzero(inside[20])[0]]


def test_fewer_vertices_lie_on_the_same_surface_and_wear_the_same_texture() -> None:
    surface = bump()
    mesh = textured_mesh(surface, most_vertices=300)
    assert 150 < len(mesh.vertices) <= 300
    assert_array_equal(mesh.textures[0], textured_mesh(surface).textures[0])
    columns, rows = mesh.vertices[:, 0] / 0.5 + 25, 20 - mesh.vertices[:, 1] / 0.5
    inner = np.hypot(columns - 25, rows - 20) < 15
    depth = 6 * np.exp(-((columns - 0.5 - 25) ** 2 + (rows - 0.5 - 20) ** 2) / 150)
    assert_allclose(mesh.vertices[inner, 2], depth[inner], atol=0.15)
    shown = at(mesh.textures[0], mesh.uv)
    assert_allclose(shown[inner], (columns + rows + 4)[inner] / 100, atol=0.02)


@pytest.mark.parametrize("most", [100_000, 300])
def test_before_a_pinhole_vertices_lie_on_the_rays_of_their_pixels(most: int) -> None:
    camera = 120.0, 120.0, 27.0, 18.5
    surface = bump(-80.0)
    mesh = textured_mesh(surface, intrinsics=camera, most_vertices=most)
    x, y, z = mesh.vertices.T
    assert (z < 0).all()
    column, row = camera[2] - camera[0] * x / z, camera[3] + camera[1] * y / z
    assert_allclose(mesh.uv, np.stack([column / 50, 1 - row / 40], axis=1), atol=1e-6)
    if most > 300:
        ray = rays(camera, surface.shape)[surface.mask]
        assert_allclose(mesh.vertices, ray * surface.depth[surface.mask][:, None], rtol=1e-6)  # type: ignore[index]


def test_white_is_told_or_the_brightest_albedo() -> None:
    surface = bump()
    bright = Surface(surface.normals, 4 * surface.albedo, surface.mask, surface.depth)
    assert textured_mesh(bright).textures[0].max() == 1
    assert_allclose(textured_mesh(surface, white=0.5).textures[0].max(), 1)
    assert textured_mesh(surface).textures[0].max() < 1


def test_large_textures_become_smaller() -> None:
    size = MOST_TEXTURE + 200
    strip = Surface(np.tile([0.0, 0, 1], (2, size, 1)), np.full((2, size), 0.5), depth=np.zeros((2, size)))
    mesh = textured_mesh(strip)
    assert mesh.textures[0].shape == (2, MOST_TEXTURE)
    assert_allclose(mesh.textures[0], 0.5)


def test_refuses_what_makes_no_mesh() -> None:
    with pytest.raises(HarmonicFaceError, match="surface: expected one with depth, got none"):
        textured_mesh(Surface(bump().normals, bump().albedo, bump().mask))
    with pytest.raises(HarmonicFaceError, match="most_vertices: expected an integer of at least 4"):
        textured_mesh(bump(), most_vertices=3)
    with pytest.raises(HarmonicFaceError, match="white: expected a finite number above 0"):
        textured_mesh(bump(), white=0.0)
