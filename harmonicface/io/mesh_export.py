"""Mesh export: triangles with albedo to GLB, OBJ and PLY files that other programs open."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import trimesh
from numpy.typing import NDArray
from PIL import Image

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.files import replacing
from harmonicface.io.meshes import Mesh
from harmonicface.io.transfer import linear_to_srgb

WRITTEN = (".glb", ".obj", ".ply")


def write_mesh(path: str | os.PathLike[str], mesh: Mesh) -> None:
    """Write a mesh with its albedo; each file is replaced whole or not at all.

    A texture is stored in 8 bits, sRGB-encoded, as these formats have it: inside a GLB, beside an OBJ with its material
    file (`face.obj` has `face.mtl` and `face.png`). PLY holds no texture: each vertex takes its colour from it.
    Materials are matte, so that viewers add no gloss. Reflectances above 1 are clipped.

    Parameters
    ----------
    path
        A name that ends in .glb, .obj or .ply.
    mesh
        Triangles, with one texture for all of them or none.

    Raises
    ------
    HarmonicFaceError
        Another ending, no triangles, several textures or one without texture coordinates, a file that cannot be
        written.

    Examples
    --------
    >>> import tempfile
    >>> from harmonicface.io.meshes import read_mesh
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    >>> triangle = Mesh(corners, np.array([[0, 1, 2]]), np.tile([0.0, 0, 1], (3, 1)), None, (), np.array([-1]),
    ...     np.full((3, 3), 0.25))
    >>> file = Path(tempfile.mkdtemp()) / "triangle.ply"
    >>> write_mesh(file, triangle)
    >>> read_mesh(file).vertex_albedo[0].round(2)
    array([0.25, 0.25, 0.25])
    """
    target = Path(path)
    ending = target.suffix.lower()
    if ending not in WRITTEN:
        raise HarmonicFaceError(f"{path}: expected a name that ends in {', '.join(WRITTEN)}, got {ending!r}")
    if len(mesh.faces) == 0:
        raise HarmonicFaceError(f"{path}: expected a mesh with triangles, got none")
    if ending == ".ply":
        visual = _vertex_visual(mesh, linear_to_srgb)
        files = {target: _shape(mesh, visual).export(file_type="ply", vertex_normal=True)}
    elif ending == ".glb":
        scene = trimesh.Scene(_shape(mesh, _visual(mesh, _matte_gltf, np.asarray)))
        files = {target: trimesh.exchange.gltf.export_glb(scene, include_normals=True)}
    else:
        files = _obj_files(target, mesh)
    for name, data in files.items():
        with replacing(name) as temporary:
            temporary.write_bytes(data)


def _obj_files(target: Path, mesh: Mesh) -> dict[Path, bytes]:
    """Return an OBJ and what stands beside it; the OBJ last, so that what it names is there."""
    text, beside = trimesh.exchange.obj.export_obj(
        _shape(mesh, _visual(mesh, partial(_matte_obj, target.stem), linear_to_srgb)),
        include_normals=True,
        return_texture=True,
        mtl_name=f"{target.stem}.mtl",
    )
    files = {target.parent / name: data for name, data in beside.items()}
    return {**files, target: text.encode("utf-8")}


def _shape(mesh: Mesh, visual: Any) -> Any:
    """Return trimesh's mesh, nothing merged."""
    return trimesh.Trimesh(mesh.vertices, mesh.faces, vertex_normals=mesh.normals, visual=visual, process=False)


def _visual(mesh: Mesh, material: Callable[[Image.Image], Any], encode: Callable[[Floats], Floats]) -> Any:
    """Return a texture where there is one, vertex colours otherwise."""
    if not mesh.textures:
        return _vertex_visual(mesh, encode)
    return trimesh.visual.TextureVisuals(uv=mesh.uv, material=material(_picture(mesh)))


def _matte_gltf(picture: Image.Image) -> Any:
    """Return a material without gloss that is seen from both sides."""
    return trimesh.visual.material.PBRMaterial(
        baseColorTexture=picture, metallicFactor=0.0, roughnessFactor=1.0, doubleSided=True
    )


def _matte_obj(name: str, picture: Image.Image) -> Any:
    """Return a white material without gloss, by whose name the picture's file is called."""
    white, black = [255, 255, 255, 255], [0, 0, 0, 255]
    return trimesh.visual.material.SimpleMaterial(
        image=picture, diffuse=white, ambient=white, specular=black, name=name
    )


def _vertex_visual(mesh: Mesh, encode: Callable[[Floats], Floats]) -> Any:
    """Return the colours of the vertices, of the texture's there where there is one; a GLB's are linear."""
    albedo = mesh.vertex_albedo
    if mesh.textures:
        albedo = albedo * _texture_at(mesh)
    colours = np.rint(encode(np.clip(albedo, 0, 1)) * 255).astype(np.uint8)
    return trimesh.visual.ColorVisuals(vertex_colors=colours)


def _picture(mesh: Mesh) -> Image.Image:
    """Return the texture as a picture; grey becomes RGB, which every viewer takes."""
    texture = _texture(mesh)
    stored = np.rint(linear_to_srgb(np.clip(texture, 0, 1)) * 255).astype(np.uint8)
    return Image.fromarray(stored if stored.ndim == 3 else np.repeat(stored[..., None], 3, axis=2))


def _texture(mesh: Mesh) -> NDArray[np.float32]:
    """Return the one texture."""
    if len(mesh.textures) > 1 or (mesh.face_texture != 0).any() or mesh.uv is None:
        raise HarmonicFaceError(
            f"mesh: expected one texture for all triangles, with texture coordinates, got {len(mesh.textures)} textures"
        )
    return mesh.textures[0]


def _texture_at(mesh: Mesh) -> NDArray[np.float64]:
    """Return what the texture shows at the vertices, between its pixels, (n, 3)."""
    texture = _texture(mesh)
    assert mesh.uv is not None
    height, width = texture.shape[:2]
    across, down = mesh.uv[:, 0] * width - 0.5, (1 - mesh.uv[:, 1]) * height - 0.5
    row = 1 << 14  # a remapped picture has fewer than 32,768 pixels a side
    count = -(-len(across) // row) * row
    columns, rows = (np.resize(each, count).reshape(-1, row).astype(np.float32) for each in (across, down))
    found = cv2.remap(texture, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    colours = found.reshape(count, -1)[: len(across)]
    return np.asarray(np.broadcast_to(colours, (len(across), 3)), np.float64)
