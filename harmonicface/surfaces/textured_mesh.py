"""Textured mesh: a Surface with depth as triangles that wear its albedo, as fine as a viewer can turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.meshes import Mesh
from harmonicface.surfaces.depth import surface_from_depth
from harmonicface.surfaces.depth_mesh import mesh_from_depth
from harmonicface.surfaces.operations import resize
from harmonicface.surfaces.surface import Surface

MOST_VERTICES = 250_000
MOST_TEXTURE = 2048  # pixels a side


def textured_mesh(
    surface: Surface,
    *,
    intrinsics: Sequence[float] | None = None,
    most_vertices: int = MOST_VERTICES,
    white: float | None = None,
) -> Mesh:
    """Return the triangles between the pixels of a Surface, with its albedo as their texture.

    More than `most_vertices` pixels are averaged to larger ones first; the texture keeps the albedo's own, up to 2048
    a side, and shows outside the mask what is nearest inside, so that no rim shines through.

    Parameters
    ----------
    surface
        A Surface with depth.
    intrinsics
        (fx, fy, cx, cy) of the pinhole camera that its pixels and depth belong to; parallel rays by default.
    most_vertices
        At least 4.
    white
        The albedo that becomes 1, above 0; by default 1, or the largest that there is if that is more.

    Returns
    -------
    Mesh
        In the camera's axes and world units (see `mesh_from_depth`), with one texture.

    Raises
    ------
    HarmonicFaceError
        No depth, a number out of range, no three neighbouring pixels without a step between them.

    Examples
    --------
    >>> square = Surface(np.tile([0.0, 0.0, 1.0], (2, 2, 1)), np.full((2, 2), 0.5), depth=np.zeros((2, 2)))
    >>> mesh = textured_mesh(square)
    >>> mesh.uv.tolist(), mesh.textures[0].shape
    ([[0.25, 0.75], [0.75, 0.75], [0.25, 0.25], [0.75, 0.25]], (2, 2))
    """
    most = _validate.at_least(most_vertices, 4, "most_vertices")
    if surface.depth is None:
        raise HarmonicFaceError("surface: expected one with depth, got none")
    texture = _texture(surface, white)
    pixels = int(surface.mask.sum())
    coarse = surface
    if pixels > most:
        factor = np.sqrt(most / pixels)
        coarse = resize(surface, (max(int(surface.shape[0] * factor), 2), max(int(surface.shape[1] * factor), 2)))
    step = coarse.pixel_size / surface.pixel_size  # larger pixels around the same middle
    down, across = ((new - old / step) / 2 for new, old in zip(coarse.shape, surface.shape, strict=True))
    if intrinsics is None:
        mesh, inside = mesh_from_depth(coarse), coarse.mask
    else:
        fx, fy, cx, cy = (float(number) / step for number in intrinsics)
        camera = fx, fy, cx + across, cy + down
        seen = surface_from_depth(np.asarray(coarse.depth), mask=coarse.mask, intrinsics=camera)
        assert seen.scene is not None
        mesh, inside = seen.scene.mesh, seen.mask
    rows, columns = np.nonzero(inside)
    u = (columns + 0.5 - across) * step / surface.shape[1]
    v = 1 - (rows + 0.5 - down) * step / surface.shape[0]
    return replace(
        mesh,
        uv=np.stack([u, v], axis=1),
        textures=(texture,),
        face_texture=np.zeros(len(mesh.faces), np.int64),
        vertex_albedo=np.ones_like(mesh.vertices),
    )


def _texture(surface: Surface, white: float | None) -> NDArray[np.float32]:
    """Return the albedo over white, filled outside the mask from the nearest pixel inside."""
    full = max(1.0, float(surface.albedo.max())) if white is None else _validate.positive(white, "white")
    albedo: Floats = np.asarray(surface.albedo / full, np.float32)
    if not surface.mask.all():
        nearest = distance_transform_edt(~surface.mask, return_distances=False, return_indices=True)
        albedo = albedo[tuple(nearest)]
    largest = max(albedo.shape[:2])
    if largest > MOST_TEXTURE:
        height, width = (max(round(side * MOST_TEXTURE / largest), 1) for side in albedo.shape[:2])
        albedo = cv2.resize(albedo, (width, height), interpolation=cv2.INTER_AREA)
    return np.ascontiguousarray(np.clip(albedo, 0, 1))
