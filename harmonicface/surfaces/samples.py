"""Samples: normals, albedo and depth of a mesh at the pixel centres of a view."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.io.meshes import Mesh
from harmonicface.surfaces.raster import Raster, rasterize
from harmonicface.surfaces.texture import look_up, shrink_to_density
from harmonicface.surfaces.view import View

Doubles = NDArray[np.float64]
Integers = NDArray[np.integer[Any]]


@dataclass(frozen=True, eq=False)
class Samples:
    """What the pixel centres of a view see of a mesh.

    Parameters
    ----------
    raster
        The triangle, weights and depth of each pixel.
    normals
        (h, w, 3) unit shading normals toward the camera; 0 where nothing is seen.
    albedo
        (h, w) or (h, w, 3); 0 where nothing is seen.
    """

    raster: Raster
    normals: Floats
    albedo: Floats

    @property
    def mask(self) -> NDArray[np.bool_]:
        """True where a triangle is seen, (h, w)."""
        return self.raster.mask


def sample(mesh: Mesh, view: View) -> Samples:
    """Return what the pixel centres of a view see of a mesh.

    Triangles are seen from both sides, and a normal always faces the camera: seen from behind it is turned round; where
    smooth shading bends it out of sight on a triangle that is seen, it is laid down sideways (z = 0); where a mesh has
    none, the triangle's own takes its place. A texture is averaged to the density of the pixels first.

    Parameters
    ----------
    mesh
        A mesh with at least one face.
    view
        Where the camera stands.
    """
    points = view.project(mesh.vertices)
    raster = rasterize(points, mesh.faces, view.shape)
    return Samples(raster, _facing_normals(mesh, view, points, raster), _albedo(mesh, points, raster))


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
