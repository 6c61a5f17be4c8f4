"""Vertex normals: what a file without normals leaves to the reader."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface.io.winding import against_neighbours, positions


def vertex_normals(vertices: NDArray[np.float64], faces: NDArray[np.integer[Any]]) -> NDArray[np.float64]:
    """Return smooth unit normals of the vertices of a triangle mesh.

    The mean of the normals of all triangles that meet at a position, weighted by the angle of their corner there
    (Thuermer & Wuethrich 1998, Computing vertex normals from polygonal facets). Vertices at the same position share
    their normal, so texture seams leave no crease. A triangle that runs against its neighbours counts as if turned.

    Parameters
    ----------
    vertices
        (n, 3) finite positions.
    faces
        (m, 3) vertex indices, counterclockwise seen from outside (or all of a part clockwise: its normals then point
        inward).

    Returns
    -------
    (n, 3) unit vectors; the zero vector where no triangle has area or opposite ones cancel.

    Examples
    --------
    >>> vertex_normals(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))[0]
    array([0., 0., 1.])
    """
    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double_area = np.linalg.norm(normal, axis=1)
    unit = np.divide(normal, double_area[:, None], out=np.zeros_like(normal), where=double_area[:, None] > 0)
    position = positions(vertices)
    unit[against_neighbours(position[faces], double_area)] *= -1
    total = np.zeros((len(vertices), 3))
    for corner in range(3):
        a = corners[:, (corner + 1) % 3] - corners[:, corner]
        b = corners[:, (corner + 2) % 3] - corners[:, corner]
        angle = np.arctan2(double_area, np.einsum("ij,ij->i", a, b))
        place = position[faces[:, corner]]
        for axis in range(3):
            total[:, axis] += np.bincount(place, angle * unit[:, axis], minlength=len(vertices))
    length = np.linalg.norm(total, axis=1, keepdims=True)
    # what is left of opposite normals that cancel is rounding error, not a direction
    shared = np.divide(total, length, out=np.zeros_like(total), where=length > 1e-9)
    return np.asarray(shared[position])
