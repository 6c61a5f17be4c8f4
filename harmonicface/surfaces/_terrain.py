"""Terrain: heights in pixels on a grid, and how steeply one must look up along an azimuth to see past them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats

Doubles = NDArray[np.float64]

BAND = 1 << 14  # pixels whose horizons are raised together: a few arrays of 128 KB, which stay in the cache
CHASM = -1e30  # relative to the relief: what a line between a pixel and a hole falls to
FREE = 1e15  # relative to the relief: slopes below minus this come from holes alone
ON_THE_GRID = 1e-9  # pixels: lines that pass a pixel's centre this closely pass through it


@dataclass(frozen=True, eq=False)
class Terrain:
    """Heights in units of the pixel size, of order one above the lowest, and far below it where there is no surface."""

    heights: Doubles
    rises: Doubles  # to the right neighbour, (h, w - 1)
    relief: float

    @classmethod
    def of(cls, depth: Floats, mask: NDArray[np.bool_], pixel_size: float) -> Terrain:
        """Return the terrain of a depth map that is finite inside the mask."""
        lowest, highest = float(depth[mask].min()), float(depth[mask].max())
        relief = max((highest - lowest) / pixel_size, 1.0)
        heights = np.full(mask.shape, CHASM * relief)
        heights[mask] = (depth[mask].astype(np.float64) - lowest) / pixel_size
        return cls(heights, np.diff(heights, axis=1), relief)

    @property
    def transposed(self) -> Terrain:
        """The terrain with rows and columns exchanged."""
        heights = np.ascontiguousarray(self.heights.T)
        return Terrain(heights, np.diff(heights, axis=1), self.relief)

    def raise_slopes(self, slopes: Doubles, down: float, right: float) -> None:
        """Raise the slopes (h, w) to what is seen past along a direction that advances more in rows than in columns.

        The surface between two neighbouring pixels of a row is the straight line, and the line of sight is compared
        with it wherever it crosses a row.
        """
        height, width = self.heights.shape
        sign, shift, length = (1 if down > 0 else -1), right / abs(down), 1 / abs(down)
        last = min(height - 1, math.floor((width - 1) / abs(shift)) if shift * (height - 1) else height - 1)
        size = max(1, BAND // width)
        scratch = np.empty((size, width))
        for first in range(0, height, size):
            band = slice(first, min(first + size, height))
            for step in range(1, last + 1):
                low, high = max(band.start, -sign * step), min(band.stop, height - sign * step)
                if low >= high:
                    break
                self._raise(slopes, slice(low, high), sign * step, step * shift, 1 / (step * length), scratch)

    def _raise(self, slopes: Doubles, rows: slice, down: int, right: float, per_pixel: float, scratch: Doubles) -> None:
        """Raise the slopes of some rows by what stands so many rows and columns away."""
        whole = math.floor(right + ON_THE_GRID)
        part = max(right - whole, 0.0)
        part = 0.0 if part < ON_THE_GRID else part
        width = slopes.shape[1]
        first, last = max(0, -whole), min(width, width - whole - (part > 0))
        if first >= last:
            return
        here = (rows, slice(first, last))
        there = (slice(rows.start + down, rows.stop + down), slice(first + whole, last + whole))
        rise = scratch[: rows.stop - rows.start, : last - first]
        if part:
            np.multiply(self.rises[there], part, out=rise)
            np.add(rise, self.heights[there], out=rise)
            np.subtract(rise, self.heights[here], out=rise)
        else:
            np.subtract(self.heights[there], self.heights[here], out=rise)
        np.multiply(rise, per_pixel, out=rise)
        np.maximum(slopes[here], rise, out=slopes[here])
