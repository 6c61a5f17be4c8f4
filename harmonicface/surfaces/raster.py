"""Raster: which triangle each pixel sees, by a z-buffer without a loop over triangles or pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces._triangles import NOTHING, Integers, Triangles, covered
from harmonicface.surfaces.view import checked_shape


@dataclass(frozen=True, eq=False)
class Raster:
    """What the pixels of a grid see of a triangle mesh.

    Parameters
    ----------
    triangle
        (h, w) int32, the index of the nearest triangle that covers the pixel's centre; -1 where there is none.
    weights
        (h, w, 3) float64, the barycentric weights of that triangle's corners at the pixel's centre; at least 0, sum 1,
        and all 0 where there is none.
    depth
        (h, w) float64, the interpolated z; NaN where there is none.
    """

    triangle: NDArray[np.int32]
    weights: NDArray[np.float64]
    depth: NDArray[np.float64]

    @property
    def mask(self) -> NDArray[np.bool_]:
        """True where a triangle is seen, (h, w)."""
        return self.triangle >= 0

    def interpolate(self, attribute: ArrayLike, faces: ArrayLike) -> Floats:
        """Return a quantity of the vertices at every pixel, linear over each triangle.

        Parameters
        ----------
        attribute
            (n, c) or (n,) finite numbers, one row a vertex.
        faces
            (m, 3) vertex indices, the ones that were rasterized (or others of the same triangles, for instance
            indices of texture coordinates).

        Returns
        -------
        (h, w, c) or (h, w), of the attribute's type; 0 where no triangle is seen.

        Raises
        ------
        HarmonicFaceError
            NaN, another shape, or faces that are not of these triangles or vertices.
        """
        values = _validate.finite(attribute, "attribute")
        if values.ndim not in (1, 2):
            raise HarmonicFaceError(f"attribute: expected shape (n, c) or (n,), got {_validate.describe(values)}")
        corners = checked_faces(faces, len(values))
        mask = self.mask
        seen = self.triangle[mask]
        if seen.size and seen.max() >= len(corners):
            raise HarmonicFaceError(f"faces: expected at least {seen.max() + 1} triangles, got {len(corners)}")
        result = np.zeros((*mask.shape, *values.shape[1:]), dtype=values.dtype)
        weights = self.weights[mask].T
        columns = values.reshape(len(values), -1).T
        result.reshape(*mask.shape, -1)[mask] = np.stack(
            [sum(weights[k] * column[corners[:, k]].take(seen) for k in range(3)) for column in columns], axis=1
        )
        return result


def rasterize(points: ArrayLike, faces: ArrayLike, shape: tuple[int, int]) -> Raster:
    """Return the nearest triangle at every pixel centre, seen from either side.

    A pixel belongs to a triangle if its centre lies inside or on the border: each edge function
    E_ab(p) = (b - a) x (p - a) has the sign of the area (Pineda 1988, A parallel algorithm for polygon rasterization).
    Each edge is evaluated from the same of its two ends in both triangles that share it, so the two results are exact
    opposites and no pixel falls through the crack between them. Of triangles at the same depth the first one is seen.
    Triangles without area in the picture are not seen.

    Parameters
    ----------
    points
        (n, 3) pixel coordinates and depth: x right, y down, the first pixel's centre at (0.5, 0.5); larger z is nearer
        the camera. They may lie outside the picture.
    faces
        (m, 3) integers, the corners of each triangle; m may be 0.
    shape
        Height and width in pixels.

    Raises
    ------
    HarmonicFaceError
        NaN, another shape, indices out of range.

    Examples
    --------
    >>> corner = rasterize([[0, 0, 1], [3, 0, 1], [0, 3, 1]], [[0, 1, 2]], (3, 3))
    >>> corner.triangle
    array([[ 0,  0,  0],
           [ 0,  0, -1],
           [ 0, -1, -1]], dtype=int32)
    """
    vertices = _validate.vectors(points, "points").astype(np.float64, copy=False)
    if vertices.ndim != 2:
        raise HarmonicFaceError(f"points: expected shape (n, 3), got {_validate.describe(vertices)}")
    corners = checked_faces(faces, len(vertices))
    shape = checked_shape(shape)
    triangles = Triangles.of(vertices, corners, shape)
    nearest = np.full(shape[0] * shape[1], -np.inf)
    seen = np.full(nearest.shape, NOTHING)
    for tiles in triangles.tiles():
        for pixel, job, depth in covered(triangles, tiles, shape[1]):
            _resolve(nearest, seen, pixel, job, depth)
    return _picture(triangles, seen, shape)


def checked_faces(faces: ArrayLike, vertices: int) -> Integers:
    """Return (m, 3) integer indices of that many vertices."""
    array = np.asarray(faces)
    if array.ndim != 2 or array.shape[1] != 3 or array.dtype.kind not in "iu":
        raise HarmonicFaceError(f"faces: expected integers of shape (m, 3), got {_validate.describe(array)}")
    if array.size and (array.min() < 0 or array.max() >= vertices):
        raise HarmonicFaceError(f"faces: expected indices from 0 to {vertices - 1}, got {array.min()} to {array.max()}")
    return array


def _resolve(
    nearest: NDArray[np.float64],
    seen: NDArray[np.int64],
    pixel: NDArray[np.int64],
    job: NDArray[np.int64],
    depth: NDArray[np.float64],
) -> None:
    """Enter candidates into the z-buffer; at the same depth the lower number stays."""
    candidate = np.flatnonzero(depth >= nearest[pixel])
    pixel, job, depth = pixel[candidate], job[candidate], depth[candidate]
    before = nearest[pixel]
    np.maximum.at(nearest, pixel, depth)
    winner = depth == nearest[pixel]
    seen[pixel[winner & (depth > before)]] = NOTHING
    np.minimum.at(seen, pixel[winner], job[winner])


def _picture(triangles: Triangles, seen: NDArray[np.int64], shape: tuple[int, int]) -> Raster:
    """Return the picture of the nearest triangles."""
    pixel = np.flatnonzero(seen < NOTHING)
    job = seen.take(pixel)
    row, column = np.divmod(pixel, shape[1])
    across, down = column + 0.5, row + 0.5
    weights = np.empty((3, len(pixel)))
    for weight, (x, y, dx, dy) in zip(weights, triangles.edges.transpose(1, 0, 2), strict=True):
        np.subtract(dx.take(job) * (down - y.take(job)), dy.take(job) * (across - x.take(job)), out=weight)
    weights /= weights[0] + weights[1] + weights[2]
    depth = sum(weight * z.take(job) for weight, z in zip(weights, triangles.z, strict=True))
    result = Raster(np.full(shape, -1, dtype=np.int32), np.zeros((*shape, 3)), np.full(shape, np.nan))
    result.triangle.reshape(-1)[pixel] = triangles.number.take(job)
    result.weights.reshape(-1, 3)[pixel] = weights.T
    result.depth.reshape(-1)[pixel] = depth
    return result
