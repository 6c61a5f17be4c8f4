from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose, assert_array_equal

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.mesh_export import write_mesh
from harmonicface.io.meshes import Mesh, read_mesh

ONE_LEVEL = 0.0045  # a level of 8 bits near white, decoded from sRGB


def sheet(textured: bool = True, colour: bool = True) -> Mesh:
    """A bumpy sheet of 3 x 4 vertices at the centres of its texture's pixels."""
    random = np.random.default_rng(0)
    rows, columns = (each.ravel() for each in np.mgrid[:3, :4])
    vertices = np.stack([columns, -rows, random.normal(size=12) / 4], axis=1).astype(float)
    squares = [(4 * r + c, 4 * r + c + 1, 4 * r + c + 4, 4 * r + c + 5) for r in range(2) for c in range(3)]
    faces = np.array([face for a, b, c, d in squares for face in ((a, c, d), (a, d, b))])
    normals = random.normal(size=(12, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    uv = np.stack([(columns + 0.5) / 4, 1 - (rows + 0.5) / 3], axis=1)
    texture = random.uniform(0, 1, (3, 4, 3) if colour else (3, 4)).astype(np.float32)
    if textured:
        return Mesh(vertices, faces, normals, uv, (texture,), np.zeros(12, np.int64), np.ones((12, 3)))
    return Mesh(vertices, faces, normals, None, (), np.full(12, -1), random.uniform(0, 1, (12, 3)))


@pytest.mark.parametrize("ending", [".glb", ".obj"])
@pytest.mark.parametrize("colour", [True, False])
def test_shape_and_texture_come_back(tmp_path: Path, ending: str, colour: bool) -> None:
    mesh = sheet(colour=colour)
    write_mesh(tmp_path / f"sheet{ending}", mesh)
    found = read_mesh(tmp_path / f"sheet{ending}")
    assert_allclose(found.vertices, mesh.vertices, atol=1e-6)
    assert_array_equal(found.faces, mesh.faces)
    assert_allclose(found.normals, mesh.normals, atol=1e-6)
    assert_allclose(found.uv, mesh.uv, atol=1e-6)
    texture = mesh.textures[0] if colour else np.repeat(mesh.textures[0][..., None], 3, axis=2)
    assert_allclose(found.textures[0], texture, atol=ONE_LEVEL)
    assert_allclose(found.vertex_albedo, 1)  # nothing darkens the texture


@pytest.mark.parametrize("ending", [".glb", ".ply"])
def test_colours_of_vertices_come_back(tmp_path: Path, ending: str) -> None:
    mesh = sheet(textured=False)
    write_mesh(tmp_path / f"sheet{ending}", mesh)
    found = read_mesh(tmp_path / f"sheet{ending}")
    assert_array_equal(found.faces, mesh.faces)
    assert_allclose(found.normals, mesh.normals, atol=1e-6)
    assert_allclose(found.vertex_albedo, mesh.vertex_albedo, atol=ONE_LEVEL)


def test_ply_takes_the_texture_at_the_vertices(tmp_path: Path) -> None:
    mesh = sheet()
    write_mesh(tmp_path / "sheet.ply", mesh)
    assert_allclose(read_mesh(tmp_path / "sheet.ply").vertex_albedo, mesh.textures[0].reshape(-1, 3), atol=ONE_LEVEL)


def test_between_pixels_ply_takes_their_mean(tmp_path: Path) -> None:
    mesh = sheet()
    moved = replace(mesh, uv=mesh.uv + np.array([0.125, 0]))
    write_mesh(tmp_path / "sheet.ply", moved)
    texture = mesh.textures[0].astype(float)
    expected = (texture[:, :-1] + texture[:, 1:]) / 2
    found = read_mesh(tmp_path / "sheet.ply").vertex_albedo.reshape(3, 4, 3)
    assert_allclose(found[:, :3], expected, atol=ONE_LEVEL)
    assert_allclose(found[:, 3], texture[:, 3], atol=ONE_LEVEL)  # beyond the last pixel's centre it stays


def test_materials_are_matte(tmp_path: Path) -> None:
    write_mesh(tmp_path / "sheet.glb", sheet())
    [shape] = trimesh.load_scene(tmp_path / "sheet.glb").geometry.values()
    assert shape.visual.material.metallicFactor == 0 and shape.visual.material.roughnessFactor == 1
    write_mesh(tmp_path / "sheet.obj", sheet())
    material = (tmp_path / "sheet.mtl").read_text()
    assert "Kd 1.0" in material and "Ks 0.0" in material and "map_Kd sheet.png" in material


def test_refuses_what_it_cannot_write(tmp_path: Path) -> None:
    mesh = sheet()
    with pytest.raises(HarmonicFaceError, match=r"expected a name that ends in .glb, .obj, .ply, got '.stl'"):
        write_mesh(tmp_path / "sheet.stl", mesh)
    with pytest.raises(HarmonicFaceError, match="expected a mesh with triangles, got none"):
        write_mesh(tmp_path / "sheet.ply", replace(mesh, faces=mesh.faces[:0]))
    with pytest.raises(HarmonicFaceError, match=r"expected one texture for all triangles.*got 2 textures"):
        write_mesh(tmp_path / "sheet.glb", replace(mesh, textures=mesh.textures * 2))
    with pytest.raises(HarmonicFaceError, match="with texture coordinates"):
        write_mesh(tmp_path / "sheet.glb", replace(mesh, uv=None))
    with pytest.raises(HarmonicFaceError, match="cannot write"):
        write_mesh(tmp_path / "no folder" / "sheet.glb", mesh)
