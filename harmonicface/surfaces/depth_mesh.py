"""Depth mesh: the triangles between the pixels of a depth map, cut where one thing stands before another."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.meshes import Mesh
from harmonicface.surfaces.surface import Surface

STEEPEST = 80.0  # degrees
BEYOND_NORMALS = 1.5  # times as steep as the normals say: a step


def mesh_from_depth(surface: Surface, steepest: float = STEEPEST) -> Mesh:
    """Return the mesh whose vertices are the pixels of a Surface at their depth.

    Two triangles fill each square of four neighbouring pixels, divided along the diagonal with the lesser step; where
    one of the four is missing, one triangle fills half of it. An edge that rises at more than `steepest` degrees, and
    1.5 times as much as the normals at either end say, spans two things, one before the other, and no triangle has it.

    Parameters
    ----------
    surface
        A Surface with depth.
    steepest
        Degrees between an edge and the plane of the picture, above 0 and at most 90; 90 cuts nothing.

    Returns
    -------
    Mesh
        In the camera's axes and world units, the middle of the picture at x = y = 0. Vertex i is the i-th masked pixel
        in row-major order, with its normal and albedo; pixels that have no triangle are there too. Triangles run
        counterclockwise seen by the camera.

    Raises
    ------
    HarmonicFaceError
        No depth, an angle out of range, or no three neighbouring pixels without a step between them.

    Examples
    --------
    >>> square = Surface(np.tile([0.0, 0.0, 1.0], (2, 2, 1)), np.full((2, 2), 0.5), depth=np.zeros((2, 2)))
    >>> mesh_from_depth(square).vertices.tolist()
    [[-0.5, 0.5, 0.0], [0.5, 0.5, 0.0], [-0.5, -0.5, 0.0], [0.5, -0.5, 0.0]]
    >>> mesh_from_depth(square).faces
    array([[0, 2, 1], [1, 2, 3]])
    """
    if surface.depth is None:
        raise HarmonicFaceError("surface: expected one with depth, got none (surface_from_depth and meshes have it)")
    limit = _validate.positive(steepest, "steepest")
    if limit > 90:
        raise HarmonicFaceError(f"steepest: expected at most 90 degrees, got {limit}")
    vertices = pixel_positions(surface)
    rise = np.inf if limit == 90 else np.tan(np.deg2rad(limit))
    normals = surface.pixel_normals.astype(np.float64)
    faces = grid_faces(surface.mask, vertices, rise, normals)
    if len(faces) == 0:
        raise HarmonicFaceError("depth: expected three neighbouring pixels without a step between them, got none")
    albedo = surface.pixel_albedo.astype(np.float64).reshape(len(vertices), -1)
    return Mesh(
        vertices,
        faces,
        normals,
        None,
        (),
        np.full(len(faces), -1),
        np.ascontiguousarray(np.broadcast_to(albedo, vertices.shape)),
    )


def pixel_positions(surface: Surface) -> NDArray[np.float64]:
    """Return where the masked pixels of a Surface with depth lie in the camera's axes and world units, (p, 3)."""
    assert surface.depth is not None
    rows, columns = np.nonzero(surface.mask)
    height, width = surface.shape
    x = (columns + 0.5 - width / 2) * surface.pixel_size
    y = (height / 2 - rows - 0.5) * surface.pixel_size
    return np.stack([x, y, surface.depth[surface.mask].astype(np.float64)], axis=1)


def grid_faces(
    inside: NDArray[np.bool_], vertices: Floats, rise: float, normals: Floats | None = None
) -> NDArray[np.int64]:
    """Return the triangles between neighbouring pixels, (m, 3), without those that have a step for an edge.

    Parameters
    ----------
    inside
        (h, w) booleans; vertex i is the i-th pixel inside in row-major order.
    vertices
        (p, 3) positions on the grid and depth.
    rise
        The largest difference in depth over the distance on the grid that an edge may have.
    normals
        (p, 3) unit normals, whose slopes an edge may follow beyond that; without them none may.
    """
    number = np.full(inside.shape, -1, dtype=np.int64)
    number[inside] = np.arange(len(vertices))
    squares = (number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:])  # a b above c d
    some = np.sum([corner >= 0 for corner in squares], axis=0) >= 3
    a, b, c, d = (corner[some] for corner in squares)
    rising = _step(vertices, b, c) <= _step(vertices, a, d)  # the diagonal from c up to b, rather than from a down to d
    first = a, c, np.where(rising, b, d)
    second = np.where(rising, b, a), np.where(rising, c, d), np.where(rising, d, b)
    faces = np.stack([np.stack(first, axis=1), np.stack(second, axis=1)], axis=1).reshape(-1, 3)
    faces = faces[(faces >= 0).all(axis=1)]
    whole = np.ones(len(faces), dtype=bool)
    for corner in range(3):
        one, other = faces[:, corner], faces[:, corner - 1]
        edge = vertices[one] - vertices[other]
        steep = np.flatnonzero(np.abs(edge[:, 2]) > rise * np.hypot(edge[:, 0], edge[:, 1]))
        if normals is not None:
            along = _follows(edge[steep], normals[one[steep]]) | _follows(edge[steep], normals[other[steep]])
            steep = steep[~along]
        whole[steep] = False
    return np.ascontiguousarray(faces[whole])


def _follows(edges: Floats, normals: Floats) -> NDArray[np.bool_]:
    """Return whether edges rise to the side to which surfaces of these normals do, and not much more steeply."""
    slope = -np.einsum("ei,ei->e", edges[:, :2], normals[:, :2]) * np.sign(edges[:, 2])  # times the normal's z
    return np.asarray(np.abs(edges[:, 2]) * normals[:, 2] <= BEYOND_NORMALS * slope)


def _step(vertices: Floats, one: NDArray[np.int64], other: NDArray[np.int64]) -> Floats:
    """Return the difference in depth of pairs of vertices; infinite where one is missing."""
    return np.where((one >= 0) & (other >= 0), np.abs(vertices[one, 2] - vertices[other, 2]), np.inf)
