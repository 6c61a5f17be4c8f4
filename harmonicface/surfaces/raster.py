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

Integers = NDArray[np.integer[Any]]

LARGEST_TILE = 64  # pixels a side; larger triangles are cut into tiles so that memory stays bounded
CANDIDATES = 1 << 19  # pixels that are tested at once: 4 MB an edge, which stays near the processor's cache
TILES = 1 << 18  # tiles that are listed at once


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
        result[mask] = np.einsum("pk,pk...->p...", self.weights[mask], values[corners[seen]])
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
    triangles = _Triangles.of(vertices, corners, shape)
    pixels = shape[0] * shape[1]
    nearest = np.full(pixels, -np.inf)
    seen = np.full(pixels, len(corners), dtype=np.int64)
    for tiles in triangles.tiles():
        for pixel, job in _covered(triangles, tiles, shape[1]):
            _resolve(nearest, seen, pixel, triangles.number[job], triangles.depth(job, pixel, shape[1]))
    return triangles.raster(seen, shape, len(corners))


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
    start: NDArray[np.float64]  # (3, t, 2): edge k faces corner k; the end of it that comes first in x, then y
    along: NDArray[np.float64]  # (3, t, 2): from there to the other end, times the sign that makes inside positive
    z: NDArray[np.float64]  # (t, 3)
    box: NDArray[np.int64]  # (t, 4): first column and row, last column and row, within the picture

    @classmethod
    def of(cls, points: NDArray[np.float64], faces: Integers, shape: tuple[int, int]) -> _Triangles:
        xy = points[:, :2]
        low = np.minimum(np.minimum(xy[faces[:, 0]], xy[faces[:, 1]]), xy[faces[:, 2]])
        high = np.maximum(np.maximum(xy[faces[:, 0]], xy[faces[:, 1]]), xy[faces[:, 2]])
        limits = np.array([shape[1], shape[0]], dtype=np.float64)
        first = np.clip(np.ceil(low - 0.5), 0, limits)
        last = np.clip(np.floor(high - 0.5), -1, limits - 1)
        number = np.flatnonzero((first <= last).all(axis=1))
        corners = faces[number]
        start, along, area = _edges(xy, corners)
        keep = area != 0
        box = np.concatenate([first[number], last[number]], axis=1).astype(np.int64)
        along *= np.sign(area)[:, None]
        z = points[:, 2][corners]
        return cls(number[keep], start[:, keep], along[:, keep], z[keep], box[keep])

    def tiles(self) -> Iterator[NDArray[np.int64]]:
        """Yield lists of tiles (job, column, row, width, height), at most about TILES at once."""
        sides = self.box[:, 2:] - self.box[:, :2] + 1
        counts = -(-sides // LARGEST_TILE)
        total = np.cumsum(counts.prod(axis=1))
        begin = 0
        while begin < len(total):
            done = total[begin - 1] if begin else 0
            end = max(begin + 1, int(np.searchsorted(total, done + TILES, side="right")))
            yield self._cut(np.arange(begin, end), counts[begin:end])
            begin = end

    def _cut(self, jobs: NDArray[np.int64], counts: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the tiles of some triangles, row by row; one tile for most of them."""
        many = counts.prod(axis=1)
        job = np.repeat(jobs, many)
        place = np.arange(len(job)) - np.repeat(np.cumsum(many) - many, many)
        across = np.repeat(counts[:, 0], many)
        corner = self.box[job, :2] + LARGEST_TILE * np.stack([place % across, place // across], axis=1)
        side = np.minimum(self.box[job, 2:] - corner + 1, LARGEST_TILE)
        return np.concatenate([job[:, None], corner, side], axis=1)

    def edge_values(self, job: Integers, pixel: Integers, width: int) -> NDArray[np.float64]:
        """Return the three edge functions at pixel centres, (3, p)."""
        x, y = pixel % width + 0.5, pixel // width + 0.5
        start, along = self.start[:, job], self.along[:, job]
        values: NDArray[np.float64] = along[..., 0] * (y - start[..., 1]) - along[..., 1] * (x - start[..., 0])
        return values

    def depth(self, job: Integers, pixel: Integers, width: int) -> NDArray[np.float64]:
        """Return the depth of triangles at pixel centres inside them, (p,)."""
        values = self.edge_values(job, pixel, width)
        total = values.sum(axis=0)
        with np.errstate(invalid="ignore"):  # a sliver may vanish in rounding: NaN is never nearest
            return np.asarray((values.T * self.z[job]).sum(axis=1) / total)

    def raster(self, seen: NDArray[np.int64], shape: tuple[int, int], nothing: int) -> Raster:
        """Return the picture of the nearest triangles."""
        pixel = np.flatnonzero(seen < nothing)
        job = np.searchsorted(self.number, seen[pixel])
        values = self.edge_values(job, pixel, shape[1])
        values /= values.sum(axis=0)
        triangle = np.full(shape, -1, dtype=np.int32)
        weights = np.zeros((*shape, 3))
        depth = np.full(shape, np.nan)
        triangle.flat[pixel] = seen[pixel]
        weights.reshape(-1, 3)[pixel] = values.T
        depth.flat[pixel] = (values.T * self.z[job]).sum(axis=1)
        return Raster(triangle, weights, depth)


def _edges(
    xy: NDArray[np.float64], corners: Integers
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return start and direction of the edge that faces each corner, (3, t, 2), and twice the signed area, (t,)."""
    p = xy[corners].transpose(1, 0, 2)
    tail, head = p[[1, 2, 0]], p[[2, 0, 1]]
    swap = (tail[..., 0] > head[..., 0]) | ((tail[..., 0] == head[..., 0]) & (tail[..., 1] > head[..., 1]))
    start = np.where(swap[..., None], head, tail)
    a, b = p[1] - p[0], p[2] - p[0]
    return start, head - tail, a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _covered(
    triangles: _Triangles, tiles: NDArray[np.int64], width: int
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Yield the pixels inside triangles and whose they are, for tiles of about the same size at a time."""
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
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the pixels of tiles whose three edge functions are at least 0, and the triangle of each."""
    job, x0, y0, tile_width, tile_height = tiles.T
    x, y = np.arange(columns), np.arange(rows)
    start, along = triangles.start[:, job], triangles.along[:, job]
    vertical = along[..., :1] * ((y0[:, None] + y + 0.5) - start[..., 1:])
    horizontal = along[..., 1:] * ((x0[:, None] + x + 0.5) - start[..., :1])
    within = (y < tile_height[:, None])[:, :, None] & (x < tile_width[:, None])[:, None, :]
    for edge in range(3):
        # v >= h and v - h >= 0 are the same in floating point, and the former needs no array of differences
        within &= vertical[edge][:, :, None] >= horizontal[edge][:, None, :]
    tile, row, column = np.nonzero(within)
    return (y0[tile] + row) * width + x0[tile] + column, job[tile]


def _resolve(
    nearest: NDArray[np.float64],
    seen: NDArray[np.int64],
    pixel: NDArray[np.int64],
    number: NDArray[np.int64],
    depth: NDArray[np.float64],
) -> None:
    """Enter candidates into the z-buffer; at the same depth the lower number stays."""
    candidate = depth >= nearest[pixel]
    pixel, number, depth = pixel[candidate], number[candidate], depth[candidate]
    before = nearest[pixel]
    np.maximum.at(nearest, pixel, depth)
    winner = depth == nearest[pixel]
    seen[pixel[winner & (depth > before)]] = np.iinfo(np.int64).max
    np.minimum.at(seen, pixel[winner], number[winner])
