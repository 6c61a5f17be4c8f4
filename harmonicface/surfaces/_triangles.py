"""Triangles in a picture: their edge functions, and which pixels lie inside, a tile at a time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Integers = NDArray[np.integer[Any]]

LARGEST_TILE = 64  # pixels a side; larger triangles are cut into tiles so that memory stays bounded
CANDIDATES = 1 << 19  # pixels that are tested at once: 4 MB an edge, which stays near the processor's cache
TILES = 1 << 18  # tiles that are listed at once
FEW = 1 << 15  # tiles; for fewer, sorting into many sizes costs more than testing pixels in vain
SLIVER = 1e-12  # of the longest side squared: below this the area is rounding error
NOTHING = np.iinfo(np.int64).max


@dataclass(frozen=True, eq=False)
class Triangles:
    """The triangles that may be seen: number in the list, edges, depth of corners, box of pixels.

    The triangles run along the last axis of the edges and depths, so that each quantity lies in one piece of memory.
    """

    number: NDArray[np.int64]
    edges: NDArray[
        np.float64
    ]  # (4, 3, t): x, y where edge k (facing corner k) starts; dx, dy along it, inside positive
    area: NDArray[np.float64]  # (t,): twice the area
    z: NDArray[np.float64]  # (3, t)
    box: NDArray[np.int64]  # (t, 4): first column and row, last column and row, within the picture

    @classmethod
    def of(cls, points: NDArray[np.float64], faces: Integers, shape: tuple[int, int]) -> Triangles:
        columns = np.ascontiguousarray(points.T)
        corners = [column.take(faces.T) for column in columns[:2]]  # x and y of the corners, (3, m) each
        first, last = [], []
        for place, limit in zip(corners, shape[::-1], strict=True):
            low = np.minimum(np.minimum(place[0], place[1]), place[2])
            high = np.maximum(np.maximum(place[0], place[1]), place[2])
            first.append(np.clip(np.ceil(low - 0.5), 0, limit))
            last.append(np.clip(np.floor(high - 0.5), -1, limit - 1))
        number = np.flatnonzero((first[0] <= last[0]) & (first[1] <= last[1]))
        edges, area = _edges(*(place.take(number, axis=1) for place in corners))
        longest = (edges[2] ** 2 + edges[3] ** 2).max(axis=0, initial=0.0)
        keep = np.abs(area) > SLIVER * longest
        edges[2:] *= np.sign(area)
        number = number[keep]
        box = np.stack([side[number] for side in first + last], axis=1).astype(np.int64)
        return cls(number, edges[..., keep], np.abs(area[keep]), columns[2].take(faces[number].T), box)

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


def _edges(x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return start and direction of the edge that faces each corner, (4, 3, t), and twice the signed area, (t,).

    The start is the end that comes first in x, then y, whichever triangle asks.
    """
    tail, head = [1, 2, 0], [2, 0, 1]
    swap = (x[tail] > x[head]) | ((x[tail] == x[head]) & (y[tail] > y[head]))
    dx, dy = x[head] - x[tail], y[head] - y[tail]
    start_x, start_y = np.where(swap, x[head], x[tail]), np.where(swap, y[head], y[tail])
    area = dx[2] * dy[0] - dy[2] * dx[0]
    return np.stack([start_x, start_y, dx, dy]), area


def covered(
    triangles: Triangles, tiles: NDArray[np.int64], width: int
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]]:
    """Yield the pixels inside triangles, whose they are and how deep, for tiles of about the same size at a time."""
    padded = np.maximum(np.ceil(np.log2(tiles[:, 3:])).astype(np.int64), 2 if len(tiles) < FEW else 0)
    kind = padded[:, 0] * 8 + padded[:, 1]
    order = np.argsort(kind, kind="stable")
    for group in np.split(order, np.flatnonzero(np.diff(kind[order])) + 1):
        powers = int(padded[group[0], 0]), int(padded[group[0], 1])
        step = max(1, CANDIDATES >> sum(powers))
        for begin in range(0, len(group), step):
            yield _inside(triangles, tiles[group[begin : begin + step]], powers, width)


def _inside(
    triangles: Triangles, tiles: NDArray[np.int64], powers: tuple[int, int], width: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Return the pixels of tiles whose three edge functions are at least 0, and the triangle and depth of each.

    The tiles are 2^powers pixels wide and high at most. An edge function is what depends on the row minus what depends
    on the column, and so is the depth.
    """
    job, x0, y0, tile_width, tile_height = np.ascontiguousarray(tiles.T)
    count = len(job)
    across, down = np.arange(1 << powers[0])[:, None], np.arange(1 << powers[1])[:, None]
    x, y, dx, dy = triangles.edges.take(job, axis=2)[:, :, None]
    vertical = dx * ((y0 + down + 0.5) - y)  # (3, rows, tiles): the longest axis is the innermost
    horizontal = dy * ((x0 + across + 0.5) - x)
    within = (down < tile_height)[:, None] & (across < tile_width)
    for edge in range(3):
        # v >= h and v - h >= 0 are the same in floating point, and the former needs no array of differences
        within &= vertical[edge][:, None] >= horizontal[edge]
    found = np.flatnonzero(within)
    place = found // count
    tile, row, column = found - place * count, place >> powers[0], place & (len(across) - 1)
    z = triangles.z.take(job, axis=1)
    slope = (z[1:] - z[0]) / triangles.area[job]
    rise = (slope[0] * vertical[1] + slope[1] * vertical[2]).ravel()
    fall = (slope[0] * horizontal[1] + slope[1] * horizontal[2]).ravel()
    depth = rise.take(row * count + tile) - fall.take(column * count + tile) + z[0].take(tile)
    depth = np.clip(depth, z.min(axis=0).take(tile), z.max(axis=0).take(tile))
    pixel = (y0 * width + x0).take(tile) + row * width + column
    return pixel, job.take(tile), depth
