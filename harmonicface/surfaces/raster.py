"""Raster: which triangle each pixel sees, by a z-buffer without a loop over triangles or pixels."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces.view import checked_shape

Integers = NDArray[np.integer[Any]]

LARGEST_TILE = 64  # pixels a side; larger triangles are cut into tiles so that memory stays bounded
CANDIDATES = 1 << 19  # pixels that are tested at once: 4 MB an edge, which stays near the processor's cache
TILES = 1 << 18  # tiles that are listed at once
SLIVER = 1e-12  # of the longest side squared: below this the area is rounding error
NOTHING = np.iinfo(np.int64).max


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
    triangles = _Triangles.of(vertices, corners, shape)
    nearest = np.full(shape[0] * shape[1], -np.inf)
    seen = np.full(nearest.shape, NOTHING)
    for tiles in triangles.tiles():
        for pixel, job, depth in _covered(triangles, tiles, shape[1]):
            _resolve(nearest, seen, pixel, job, depth)
    return triangles.raster(seen, shape)


def checked_faces(faces: ArrayLike, vertices: int) -> Integers:
    """Return (m, 3) integer indices of that many vertices."""
    array = np.asarray(faces)
    if array.ndim != 2 or array.shape[1] != 3 or array.dtype.kind not in "iu":
        raise HarmonicFaceError(f"faces: expected integers of shape (m, 3), got {_validate.describe(array)}")
    if array.size and (array.min() < 0 or array.max() >= vertices):
        raise HarmonicFaceError(f"faces: expected indices from 0 to {vertices - 1}, got {array.min()} to {array.max()}")
    return array


@dataclass(frozen=True, eq=False)
class _Triangles:
    """The triangles that may be seen: number in the list, edges, depth of corners, box of pixels."""

    number: NDArray[np.int64]
    edges: NDArray[
        np.float64
    ]  # (t, 4, 3): x, y where edge k (facing corner k) starts; dx, dy along it, inside positive
    area: NDArray[np.float64]  # (t,): twice the area
    z: NDArray[np.float64]  # (t, 3)
    box: NDArray[np.int64]  # (t, 4): first column and row, last column and row, within the picture

    @classmethod
    def of(cls, points: NDArray[np.float64], faces: Integers, shape: tuple[int, int]) -> _Triangles:
        low, high = points[faces[:, 0], :2], points[faces[:, 0], :2]
        for corner in (1, 2):
            low = np.minimum(low, points[faces[:, corner], :2])
            high = np.maximum(high, points[faces[:, corner], :2])
        limits = np.array([shape[1], shape[0]], dtype=np.float64)
        first = np.clip(np.ceil(low - 0.5), 0, limits)
        last = np.clip(np.floor(high - 0.5), -1, limits - 1)
        number = np.flatnonzero((first[:, 0] <= last[:, 0]) & (first[:, 1] <= last[:, 1]))
        corners = points[faces[number]]
        edges, area = _edges(corners[..., 0], corners[..., 1])
        longest = (edges[:, 2] ** 2 + edges[:, 3] ** 2).max(axis=1, initial=0.0)
        keep = np.abs(area) > SLIVER * longest
        edges[:, 2:] *= np.sign(area)[:, None, None]
        box = np.concatenate([first[number], last[number]], axis=1).astype(np.int64)
        return cls(number[keep], edges[keep], np.abs(area[keep]), corners[keep, :, 2], box[keep])

    def tiles(self) -> Iterator[NDArray[np.int64]]:
        """Yield lists of tiles (job, column, row, width, height), at most about TILES at once."""
        counts = -(-(self.box[:, 2:] - self.box[:, :2] + 1) // LARGEST_TILE)
        total = np.cumsum(counts[:, 0] * counts[:, 1])
        begin = 0
        while begin < len(total):
            done = total[begin - 1] if begin else 0
            end = max(begin + 1, int(np.searchsorted(total, done + TILES, side="right")))
            yield self._cut(np.arange(begin, end), counts[begin:end])
            begin = end

    def _cut(self, jobs: NDArray[np.int64], counts: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the tiles of some triangles, row by row; one tile for most of them."""
        many = counts[:, 0] * counts[:, 1]
        job = np.repeat(jobs, many)
        place = np.arange(len(job)) - np.repeat(np.cumsum(many) - many, many)
        across = np.repeat(counts[:, 0], many)
        corner = self.box[job, :2] + LARGEST_TILE * np.stack([place % across, place // across], axis=1)
        side = np.minimum(self.box[job, 2:] - corner + 1, LARGEST_TILE)
        return np.concatenate([job[:, None], corner, side], axis=1)

    def raster(self, seen: NDArray[np.int64], shape: tuple[int, int]) -> Raster:
        """Return the picture of the nearest triangles."""
        pixel = np.flatnonzero(seen < NOTHING)
        job = seen[pixel]
        row, column = np.divmod(pixel, shape[1])
        weights = np.empty((len(pixel), 3))
        for corner in range(3):
            x, y, dx, dy = (self.edges[:, part, corner].take(job) for part in range(4))
            weights[:, corner] = dx * (row + 0.5 - y) - dy * (column + 0.5 - x)
        weights /= (weights[:, 0] + weights[:, 1] + weights[:, 2])[:, None]
        result = Raster(np.full(shape, -1, dtype=np.int32), np.zeros((*shape, 3)), np.full(shape, np.nan))
        result.triangle.reshape(-1)[pixel] = self.number[job]
        result.weights.reshape(-1, 3)[pixel] = weights
        result.depth.reshape(-1)[pixel] = np.einsum("pk,pk->p", weights, self.z[job])
        return result


def _edges(x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return start and direction of the edge that faces each corner, (t, 4, 3), and twice the signed area, (t,).

    The start is the end that comes first in x, then y, whichever triangle asks.
    """
    tail, head = [1, 2, 0], [2, 0, 1]
    swap = (x[:, tail] > x[:, head]) | ((x[:, tail] == x[:, head]) & (y[:, tail] > y[:, head]))
    dx, dy = x[:, head] - x[:, tail], y[:, head] - y[:, tail]
    start_x, start_y = np.where(swap, x[:, head], x[:, tail]), np.where(swap, y[:, head], y[:, tail])
    area = dx[:, 2] * dy[:, 0] - dy[:, 2] * dx[:, 0]
    return np.stack([start_x, start_y, dx, dy], axis=1), area


def _covered(
    triangles: _Triangles, tiles: NDArray[np.int64], width: int
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]]:
    """Yield the pixels inside triangles, whose they are and how deep, for tiles of about the same size at a time."""
    padded = np.ceil(np.log2(tiles[:, 3:])).astype(np.int64)
    kind = padded[:, 0] * 8 + padded[:, 1]
    order = np.argsort(kind, kind="stable")
    for group in np.split(order, np.flatnonzero(np.diff(kind[order])) + 1):
        columns, rows = (int(2**power) for power in padded[group[0]])
        step = max(1, CANDIDATES // (columns * rows))
        for begin in range(0, len(group), step):
            yield _inside(triangles, tiles[group[begin : begin + step]], columns, rows, width)


def _inside(
    triangles: _Triangles, tiles: NDArray[np.int64], columns: int, rows: int, width: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Return the pixels of tiles whose three edge functions are at least 0, and the triangle and depth of each.

    An edge function is what depends on the row minus what depends on the column, and so is the depth.
    """
    job, x0, y0, tile_width, tile_height = tiles.T
    across, down = np.arange(columns), np.arange(rows)
    x, y, dx, dy = triangles.edges[job].transpose(1, 2, 0)[..., None]
    vertical = dx * ((y0[:, None] + down + 0.5) - y)
    horizontal = dy * ((x0[:, None] + across + 0.5) - x)
    within = (down < tile_height[:, None])[:, :, None] & (across < tile_width[:, None])[:, None, :]
    for edge in range(3):
        # v >= h and v - h >= 0 are the same in floating point, and the former needs no array of differences
        within &= vertical[edge][:, :, None] >= horizontal[edge][:, None, :]
    found = np.flatnonzero(within)
    tile, place = np.divmod(found, rows * columns)
    row, column = np.divmod(place, columns)
    z = triangles.z[job]
    slope = ((z - z[:, :1]) / triangles.area[job, None]).T[1:, :, None]
    depth = (slope * vertical[1:]).sum(axis=0)[tile, row] - (slope * horizontal[1:]).sum(axis=0)[tile, column]
    depth = np.clip(depth + z[tile, 0], z.min(axis=1)[tile], z.max(axis=1)[tile])
    return (y0[tile] + row) * width + x0[tile] + column, job[tile], depth


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
