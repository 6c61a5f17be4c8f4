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
SLIVER = 1e-12  # of the longest side squared: below this the area is rounding error
NOTHING = np.iinfo(np.int64).max


@dataclass(frozen=True, eq=False)
class Triangles:
    """The triangles that may be seen: number in the list, edges, depth of corners, box of pixels."""

    number: NDArray[np.int64]
    edges: NDArray[
        np.float64
    ]  # (t, 4, 3): x, y where edge k (facing corner k) starts; dx, dy along it, inside positive
    area: NDArray[np.float64]  # (t,): twice the area
    z: NDArray[np.float64]  # (t, 3)
    box: NDArray[np.int64]  # (t, 4): first column and row, last column and row, within the picture

    @classmethod
    def of(cls, points: NDArray[np.float64], faces: Integers, shape: tuple[int, int]) -> Triangles:
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


def covered(
    triangles: Triangles, tiles: NDArray[np.int64], width: int
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
    triangles: Triangles, tiles: NDArray[np.int64], columns: int, rows: int, width: int
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
