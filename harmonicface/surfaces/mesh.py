"""From a mesh to a Surface: what an orthographic camera sees of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.meshes import Mesh
from harmonicface.surfaces.raster import Raster, rasterize
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.texture import look_up, shrink_to_density
from harmonicface.surfaces.view import View

Doubles = NDArray[np.float64]
Integers = NDArray[np.integer[Any]]

SUPERSAMPLE = 4
FINEST = 1024  # pixels a side of the raster beyond which pixels are not divided any further


def surface_from_mesh(
    mesh: Mesh,
    size: int | tuple[int, int] = 64,
    *,
    rotation: Sequence[float] = (0.0, 0.0, 0.0),
    frame: Sequence[float] | None = None,
    supersample: int | None = None,
) -> Surface:
    """Return what an orthographic camera sees of a mesh.

    Each pixel is divided into `supersample` x `supersample`; it is inside the mask if at least half of them see the
    mesh, and its albedo, depth and normal (scaled to unit length) are their means. A texture is averaged to the density
    of these finer pixels first. Triangles are seen from both sides, and a normal always faces the camera: seen from
    behind it is turned round; where smooth shading bends it out of sight on a triangle that is seen, it is laid down
    sideways (z = 0); where a mesh has none, the triangle's own takes its place.

    Parameters
    ----------
    mesh
        A mesh with at least one face.
    size
        Height and width in pixels; one number means a square.
    rotation
        (yaw, pitch, roll) in degrees, see `rotation_matrix`.
    frame
        (x0, y0, x1, y1): what the picture shows, in world units after the rotation; by default all of the mesh.
    supersample
        Divisions of a pixel along each side; by default 4, or fewer where the finer raster would exceed 1024 pixels.

    Returns
    -------
    Surface of float32 arrays, with depth in world units. Its albedo is (h, w), or (h, w, 3) if the mesh has colour.

    Raises
    ------
    HarmonicFaceError
        View arguments of another form, or a frame in which nothing is seen.

    Examples
    --------
    >>> from harmonicface.io.meshes import Mesh
    >>> square = Mesh(
    ...     vertices=np.array([[0.0, 0, 2], [1, 0, 2], [1, 1, 2], [0, 1, 2]]), faces=np.array([[0, 1, 2], [0, 2, 3]]),
    ...     normals=np.tile([0.0, 0.0, 1.0], (4, 1)), uv=None, textures=(), face_texture=np.array([-1, -1]),
    ...     vertex_albedo=np.full((4, 3), 0.5))
    >>> seen = surface_from_mesh(square, size=2)
    >>> seen.albedo, seen.depth, seen.pixel_size
    (array([[0.5, 0.5], [0.5, 0.5]], dtype=float32), array([[2., 2.], [2., 2.]], dtype=float32), 0.5)
    """
    view = View.fit(mesh.vertices[np.unique(mesh.faces)], size, rotation=rotation, frame=frame)
    divisions = _divisions(supersample, view.shape)
    fine = View(view.rotation, view.frame, (view.shape[0] * divisions, view.shape[1] * divisions))
    points = fine.project(mesh.vertices)
    raster = rasterize(points, mesh.faces, fine.shape)
    seen = raster.mask
    counts = _block_sums(seen.astype(np.float64), divisions)
    inside = 2 * counts >= divisions**2
    normals = _block_sums(_facing_normals(mesh, fine, points, raster), divisions)
    length = np.linalg.norm(normals, axis=2)
    inside &= length > 1e-6 * counts  # opposite sideways normals within one pixel leave no direction
    if not inside.any():
        raise HarmonicFaceError(f"frame: expected a part of the mesh in view, got {view.frame} which shows nothing")
    albedo = _block_sums(_albedo(mesh, points, raster), divisions)
    depth = _block_sums(np.where(seen, raster.depth, 0.0), divisions)
    normals[inside] /= length[inside, None]
    albedo[inside] /= counts[inside].reshape(-1, *[1] * (albedo.ndim - 2))
    depth[inside] /= counts[inside]
    return Surface(
        normals.astype(np.float32),
        albedo.astype(np.float32),
        inside,
        depth.astype(np.float32),
        view.pixel_size,
    )


def _divisions(supersample: int | None, shape: tuple[int, int]) -> int:
    if supersample is None:
        return int(np.clip(FINEST // max(shape), 1, SUPERSAMPLE))
    if isinstance(supersample, bool) or not isinstance(supersample, (int, np.integer)) or supersample < 1:
        raise HarmonicFaceError(
            f"supersample: expected an integer of at least 1, got {_validate.describe(supersample)}"
        )
    return int(supersample)


def _block_sums(array: Floats, divisions: int) -> Floats:
    """Return the sums over blocks of pixels, (h, w, ...)."""
    height, width = array.shape[0] // divisions, array.shape[1] // divisions
    blocks = array.reshape(height, divisions, width, divisions, *array.shape[2:])
    return np.asarray(blocks.sum(axis=(1, 3)))


def _facing_normals(mesh: Mesh, view: View, points: Doubles, raster: Raster) -> Floats:
    """Return unit normals toward the camera at every pixel that sees the mesh, 0 elsewhere."""
    seen = raster.mask
    result = np.zeros((*seen.shape, 3))
    normals = raster.interpolate(view.turn(mesh.normals), mesh.faces)[seen]
    triangle = raster.triangle[seen]
    own = _triangle_normals(points[mesh.faces], view.pixel_size)[triangle]
    lost = np.linalg.norm(normals, axis=1) < 1e-6
    normals[lost] = own[lost]
    away = normals[:, 2] < 0
    behind = own[:, 2] < 0
    normals[away & behind] *= -1
    sideways = away & ~behind
    normals[sideways, 2] = 0
    length = np.linalg.norm(normals, axis=1)
    flat = length < 1e-6  # the shading normal pointed straight away from a triangle that faces the camera
    normals[flat] = own[flat]
    length[flat] = 1
    result[seen] = normals / length[:, None]
    return result


def _triangle_normals(corners: Doubles, pixel_size: float) -> Floats:
    """Return the unit normals of triangles in pixel coordinates, (m, 3), in the camera's axes; 0 without area."""
    scaled = corners * np.array([pixel_size, -pixel_size, 1.0])
    normals = np.cross(scaled[:, 1] - scaled[:, 0], scaled[:, 2] - scaled[:, 0])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(np.divide(normals, length, out=normals, where=length > 0))


def _albedo(mesh: Mesh, points: Doubles, raster: Raster) -> Floats:
    """Return the albedo at every pixel that sees the mesh: the vertices', times the texture's."""
    seen = raster.mask
    tint = raster.interpolate(mesh.vertex_albedo, mesh.faces)[seen]
    wears = mesh.face_texture[raster.triangle[seen]]
    if mesh.uv is not None and mesh.textures:
        uv = raster.interpolate(mesh.uv, mesh.faces)[seen]
        for number, texture in enumerate(mesh.textures):
            here = wears == number
            if not here.any():
                continue
            texels = _texels(mesh.uv, points, mesh.faces, raster.triangle[seen][here], texture.shape[:2])
            values = look_up(shrink_to_density(texture, texels), uv[here])
            tint[here] *= values.reshape(len(values), -1)
    result = np.zeros((*seen.shape, 3))
    result[seen] = tint
    return np.ascontiguousarray(result[..., 0]) if mesh.is_grey else result


def _texels(uv: Doubles, points: Doubles, faces: Integers, triangle: Integers, shape: tuple[int, ...]) -> float:
    """Return how many texels a pixel covers along one side, the median over the pixels of some triangles."""
    texture_area = _areas(uv[faces] * np.array([shape[1], shape[0]]))[triangle]
    return float(np.sqrt(np.median(texture_area / _areas(points[faces, :2])[triangle])))


def _areas(corners: Doubles) -> Floats:
    """Return twice the areas of triangles in a plane, (m,)."""
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
