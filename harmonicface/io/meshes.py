"""Meshes: GLB, OBJ, PLY and STL files to triangles with normals, texture coordinates and albedo."""

from __future__ import annotations

import io
import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.io._glb import prepared_glb
from harmonicface.io._mesh_bytes import check_bytes
from harmonicface.io._mesh_colours import check_textures, read_colours
from harmonicface.io._reasons import reason_of
from harmonicface.io.images import read_image
from harmonicface.io.vertex_normals import vertex_normals

LARGEST = 1e60  # beyond it the squares of areas overflow
ENDINGS = (".glb", ".obj", ".ply", ".stl")

Doubles = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles, in the order of the file; nothing is merged.

    Parameters
    ----------
    vertices
        (n, 3) float64 positions in the file's units: x right, y up, z toward the viewer.
    faces
        (m, 3) vertex indices, counterclockwise seen from outside.
    normals
        (n, 3) float64 unit normals; the zero vector where a vertex has none.
    uv
        (n, 2) float64 texture coordinates with v upward, so that (0, 1) is the top left corner; None without any.
    textures
        Linear float32 images, (h, w) or (h, w, 3). Most meshes have none or one.
    face_texture
        (m,) which texture each face wears, -1 for none.
    vertex_albedo
        (n, 3) float64 linear reflectances. A texture is multiplied by them.
    """

    vertices: Doubles
    faces: NDArray[np.int64]
    normals: Doubles
    uv: Doubles | None
    textures: tuple[NDArray[np.float32], ...]
    face_texture: NDArray[np.int64]
    vertex_albedo: Doubles

    @property
    def is_grey(self) -> bool:
        """True if no texture and no vertex has a colour."""
        flat = (self.vertex_albedo == self.vertex_albedo[:, :1]).all()
        return bool(flat) and all(texture.ndim == 2 for texture in self.textures)


def read_mesh(
    path: str | os.PathLike[str],
    *,
    texture: str | os.PathLike[str] | None = None,
    flip_texture: bool = False,
) -> Mesh:
    r"""Read the triangles of a file; the parts of a scene are placed by its transforms and follow one another.

    Normals that the file lacks are averaged over all corners at the same position, weighted by angle, as if single
    triangles that run against their neighbours ran with them; the faces themselves stay as they are. Albedo is, in
    this order: the texture given here, the texture inside the file (times its base colour factor), the colours of the
    vertices, the main colour of the material, and 0.5 where the file says nothing; in a GLB factor, texture and vertex
    colours are multiplied. Textures and vertex colours are sRGB, but a GLB's vertex colours are linear, as its
    specification says, and so are colours that a material names. A material file that an OBJ names but that is not
    there is as good as none; a texture that is not there is refused, unless one is given here. Polygons become
    triangles; an OBJ's vertices at texture seams are split, as GLB's are.

    Parameters
    ----------
    path
        A name that ends in .glb, .obj, .ply or .stl.
    texture
        An image file to use in place of what the file says about albedo.
    flip_texture
        Turn that image upside down first, for maps made for the other direction of v.

    Raises
    ------
    HarmonicFaceError
        No such file, another ending, a file cut short or corrupt, beyond the memory there is, no faces, NaN, indices
        out of range, a texture that is missing or of another mode than grey, RGB or palette, a texture for a mesh
        without texture coordinates, flip_texture without a texture.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "triangle.obj"
    >>> _ = path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    >>> mesh = read_mesh(path)
    >>> mesh.faces, mesh.normals[0], mesh.vertex_albedo[0]
    (array([[0, 1, 2]]), array([0., 0., 1.]), array([0.5, 0.5, 0.5]))
    """
    file = Path(path)
    if file.suffix.lower() not in ENDINGS:
        raise HarmonicFaceError(f"{file}: expected a mesh ({' '.join(ENDINGS)}), got the ending {file.suffix!r}")
    if flip_texture and texture is None:
        raise HarmonicFaceError("flip_texture: expected a texture to flip, got none (give texture=)")
    parts = _parts(file, check_bytes(file), textures=texture is None)
    if not parts:
        raise HarmonicFaceError(f"{file}: expected a mesh with faces, got a file without any")
    mesh = _joined(parts)
    return mesh if texture is None else _dressed(mesh, file, Path(texture), flip_texture)


@dataclass(frozen=True, eq=False)
class _Part:
    """One geometry of a scene at its place."""

    vertices: Doubles
    faces: NDArray[np.int64]
    normals: Doubles
    uv: Doubles | None
    texture: NDArray[np.float32] | None
    albedo: Doubles


def _parts(file: Path, data: bytes, *, textures: bool) -> list[_Part]:
    """Return the triangle meshes of a file in the file's order; the textures that it names must be there."""
    try:
        with _quiet():
            if textures:
                check_textures(file, data)
            scene = _parsed(file, data)
            places = [scene.graph.get(node) for node in scene.graph.nodes_geometry]
            names = list(scene.geometry)
            if file.suffix.lower() == ".obj":
                names.reverse()  # trimesh takes an OBJ's groups from the last to the first
            places.sort(key=lambda place: names.index(place[1]))
            return [
                _part(scene.geometry[name], np.asarray(matrix, dtype=np.float64))
                for matrix, name in places
                if len(getattr(scene.geometry[name], "faces", ())) > 0
            ]
    except HarmonicFaceError as error:
        raise HarmonicFaceError(f"{file}: {error}") from None
    except Exception as error:  # the parsers raise whatever they stumble over
        raise HarmonicFaceError(
            f"{file}: expected a whole mesh, got one cut short or corrupt{reason_of(error)}"
        ) from None


def _parsed(file: Path, data: bytes) -> Any:
    """Return trimesh's scene of a file."""
    ending = file.suffix.lower()
    stream = io.BytesIO(prepared_glb(data) if ending == ".glb" else data)
    resolver = trimesh.resolvers.FilePathResolver(str(file.resolve()))
    return trimesh.load_scene(stream, file_type=ending[1:], resolver=resolver, process=False)


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep the parser from logging, and let numpy's warning about unreadable numbers be an error."""
    logger = trimesh.util.log
    disabled = logger.disabled
    logger.disabled = True
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            warnings.simplefilter("error", DeprecationWarning)
            yield
    finally:
        logger.disabled = disabled


def _part(geometry: Any, matrix: Doubles) -> _Part:
    """Place a geometry by its transform and read its colours."""
    vertices = np.array(geometry.vertices, dtype=np.float64)
    faces = np.array(geometry.faces, dtype=np.int64)
    given = np.array(geometry.vertex_normals, dtype=np.float64) if "vertex_normals" in geometry._cache else None
    if not np.array_equal(matrix, np.eye(4)):
        linear = matrix[:3, :3]
        determinant = np.linalg.det(linear)
        vertices = vertices @ linear.T + matrix[:3, 3]
        if determinant < 0:
            faces = np.ascontiguousarray(faces[:, ::-1])  # a mirrored triangle runs the other way round
        if given is not None and determinant != 0:
            given = given @ np.linalg.inv(linear)  # normals go by the inverse transpose
    _check(vertices, faces)
    uv, texture, albedo = read_colours(geometry, len(vertices))
    return _Part(vertices, faces, _normals(vertices, faces, given), uv, texture, albedo)


def _normals(vertices: Doubles, faces: NDArray[np.int64], given: Doubles | None) -> Doubles:
    """Return the unit normals that are given; where there are none, those of the triangles around."""
    if given is None:
        return vertex_normals(vertices, faces)
    length = np.linalg.norm(given, axis=1, keepdims=True)
    if not np.isfinite(length).all():
        raise HarmonicFaceError("expected finite normals, got NaN or infinite ones")
    normals = np.zeros_like(given) if (length > 0).all() else vertex_normals(vertices, faces)
    return np.asarray(np.divide(given, length, out=normals, where=length > 0))


def _check(vertices: Doubles, faces: NDArray[np.int64]) -> None:
    if not np.isfinite(vertices).all():
        count = int((~np.isfinite(vertices)).any(axis=1).sum())
        raise HarmonicFaceError(f"expected finite vertices, got {count} NaN or infinite of {len(vertices)}")
    if np.abs(vertices).max(initial=0.0) > LARGEST:
        raise HarmonicFaceError(f"expected vertices within {LARGEST:g}, got {np.abs(vertices).max():.3g}")
    if faces.ndim != 2 or faces.shape[1] != 3 or faces.min() < 0 or faces.max() >= len(vertices):
        raise HarmonicFaceError(
            f"expected triangles of vertices 0 to {len(vertices) - 1}, got indices {faces.min()} to {faces.max()}"
        )


def _joined(parts: list[_Part]) -> Mesh:
    """Lay the parts behind one another."""
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    numbers = np.cumsum([part.texture is not None for part in parts]) - 1
    uv = None
    if any(part.uv is not None for part in parts):
        uv = np.concatenate([np.zeros((len(part.vertices), 2)) if part.uv is None else part.uv for part in parts])
    wears = [-1 if part.texture is None else number for part, number in zip(parts, numbers, strict=True)]
    return Mesh(
        vertices=np.concatenate([part.vertices for part in parts]),
        faces=np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=False)]),
        normals=np.concatenate([part.normals for part in parts]),
        uv=uv,
        textures=tuple(part.texture for part in parts if part.texture is not None),
        face_texture=np.repeat(np.array(wears, dtype=np.int64), [len(part.faces) for part in parts]),
        vertex_albedo=np.concatenate([part.albedo for part in parts]),
    )


def _dressed(mesh: Mesh, file: Path, texture: Path, flip: bool) -> Mesh:
    """Return the mesh with another texture in place of its own albedo."""
    if mesh.uv is None:
        raise HarmonicFaceError(f"{file}: expected texture coordinates for {texture.name}, got a mesh without any")
    image = read_image(texture)
    image = np.ascontiguousarray(image[::-1]) if flip else image
    everywhere = np.zeros(len(mesh.faces), dtype=np.int64)
    return Mesh(
        mesh.vertices, mesh.faces, mesh.normals, mesh.uv, (image,), everywhere, np.ones_like(mesh.vertex_albedo)
    )
