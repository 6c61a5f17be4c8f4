"""Samples: normals, albedo and depth of a mesh at the pixel centres of a view."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.io.meshes import Mesh
from harmonicface.surfaces._perspective_raster import perspective_raster
from harmonicface.surfaces.perspective import Camera, PerspectiveView
from harmonicface.surfaces.raster import Raster, rasterize
from harmonicface.surfaces.texture import look_up, shrink_to_density

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


def sample(mesh: Mesh, view: Camera) -> Samples:
    """Return what the pixel centres of a view see of a mesh.

    Triangles are seen from both sides, whichever way they wind, and a normal always faces the camera: seen from behind
    it is turned round; where smooth shading bends it out of sight on a triangle that is seen, it is laid down sideways
    (at a right angle to the line of sight); where a mesh has none, the triangle's own takes its place. Which side of a
    triangle is the outer one is what its corners' normals say, and where they say nothing, its winding. A texture is
    averaged to the density of the pixels first.

    Parameters
    ----------
    mesh
        A mesh with at least one face.
    view
        Where the camera stands: a `View` or a `PerspectiveView`.
    """
    placed = view.place(mesh.vertices)
    if isinstance(view, PerspectiveView):
        raster = perspective_raster(placed, mesh.faces, view)
    else:
        raster = rasterize(view.project(mesh.vertices), mesh.faces, view.shape)
    triangle, number = _seen_triangles(raster, len(mesh.faces))
    flat = np.cross(*_sides(placed, mesh.faces[triangle]))
    area = np.linalg.norm(flat, axis=1)
    own = np.divide(flat, area[:, None], out=np.zeros_like(flat), where=area[:, None] > 0)
    normals = _facing_normals(mesh, view, raster, own[number], triangle[number])
    density = area[number] * np.abs(np.einsum("pi,pi->p", own[number], view.toward()[raster.mask]))
    density /= view.pixel_size_at(raster.depth[raster.mask]) ** 2
    return Samples(raster, normals, _albedo(mesh, raster, density))


def _seen_triangles(raster: Raster, count: int) -> tuple[Integers, Integers]:
    """Return which of so many triangles are seen, and the place of each seen pixel's triangle in that list."""
    pixels = raster.triangle[raster.mask]
    used = np.zeros(count, dtype=bool)
    used[pixels] = True
    return np.flatnonzero(used), (np.cumsum(used) - 1)[pixels]


def _facing_normals(mesh: Mesh, view: Camera, raster: Raster, own: Floats, triangle: Integers) -> Floats:
    """Return unit normals toward the camera at every pixel that sees the mesh, 0 elsewhere."""
    seen = raster.mask
    corner_normals = view.turn(mesh.normals)
    outward = sum(corner_normals[mesh.faces[triangle, corner]] for corner in range(3))
    own = np.where(np.einsum("pi,pi->p", own, outward)[:, None] < 0, -own, own)
    normals = raster.interpolate(corner_normals, mesh.faces)[seen]
    lost = np.linalg.norm(normals, axis=1) < 1e-6
    normals[lost] = own[lost]
    toward = view.toward()[seen]
    cosine = np.einsum("pi,pi->p", normals, toward)
    away = cosine < 0
    behind = np.einsum("pi,pi->p", own, toward) < 0
    normals[away & behind] *= -1
    sideways = away & ~behind
    square = np.einsum("pi,pi->p", toward[sideways], toward[sideways])
    normals[sideways] -= (cosine[sideways] / square)[:, None] * toward[sideways]
    length = np.linalg.norm(normals, axis=1)
    flat = length < 1e-6  # the shading normal pointed straight away from a triangle that faces the camera
    normals[flat] = own[flat]
    length[flat] = 1
    result = np.zeros((*seen.shape, 3))
    result[seen] = normals / length[:, None]
    return result


def _albedo(mesh: Mesh, raster: Raster, pixels: Floats) -> Floats:
    """Return the albedo at every pixel that sees the mesh: the vertices', times the texture's.

    `pixels` is, for each of them, how many pixels twice its triangle would cover at that magnification.
    """
    seen = raster.mask
    tint = raster.interpolate(mesh.vertex_albedo, mesh.faces)[seen]
    triangle = raster.triangle[seen]
    wears = mesh.face_texture[triangle]
    if mesh.uv is not None and mesh.textures:
        uv = raster.interpolate(mesh.uv, mesh.faces)[seen]
        for number, texture in enumerate(mesh.textures):
            here = wears == number
            if not here.any():
                continue
            a, b = _sides(mesh.uv * np.array([texture.shape[1], texture.shape[0]]), mesh.faces[triangle[here]])
            texels = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
            reduced = shrink_to_density(texture, float(np.sqrt(np.median(texels / pixels[here]))))
            values = look_up(reduced, uv[here])
            tint[here] *= values.reshape(len(values), -1)
    result = np.zeros((*seen.shape, 3))
    result[seen] = tint
    return np.ascontiguousarray(result[..., 0]) if mesh.is_grey else result


def _sides(points: Floats, faces: Integers) -> tuple[Floats, Floats]:
    """Return two sides of each triangle from its first corner."""
    start = points[faces[:, 0]]
    return points[faces[:, 1]] - start, points[faces[:, 2]] - start
