"""Terrain: heights in pixels on a grid, and how steeply one must look up along a direction to see past them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError

Doubles = NDArray[np.float64]
Rectangle = tuple[slice, slice]

BAND = 1 << 14  # pixels whose horizons are raised together: a few arrays of 128 KB, which stay in the cache
SPACING = 1 / 32  # of the distance: how far apart a line of sight is looked at, and no closer than row by row
DIAGONALS = 4  # how many of either kind a line of sight is compared with
CHASM = -1e30  # relative to the relief: what a line between a pixel and a hole falls to
FREE = 1e15  # relative to the relief: slopes below minus this come from holes alone
TALLEST = 1e150  # pixels: chasms below it are still numbers
ON_THE_GRID = 1e-9  # pixels: lines that pass a pixel's centre this closely pass through it


@dataclass(frozen=True, eq=False)
class Terrain:
    """Heights above the lowest in units of the pixel size, and a chasm where there is no surface."""

    heights: Doubles
    rises: Doubles  # to the right neighbour, (h, w - 1)
    relief: float  # the largest height, at least 1
    upward: Doubles  # rises along the diagonal up and to the right of each square, (h - 1, w - 1)
    downward: Doubles  # and along that down and to the right; chasms where the other one divides the square

    @classmethod
    def of(cls, depth: Floats, mask: NDArray[np.bool_], pixel_size: float) -> Terrain:
        """Return the terrain of a depth map that is finite inside the mask."""
        inside = depth[mask]
        lowest = float(inside.min())
        relief = max(float(inside.max()) / pixel_size - lowest / pixel_size, 1.0)
        if not relief < TALLEST:
            raise HarmonicFaceError(
                f"depth: expected less than {TALLEST:g} pixels from back to front, got {relief:.4g}"
            )
        heights = np.subtract(depth, lowest, dtype=np.float64, order="C")
        heights /= pixel_size
        heights[~mask] = CHASM * relief
        upward, downward = heights[:-1, 1:] - heights[1:, :-1], heights[1:, 1:] - heights[:-1, :-1]
        lesser, chasm = np.abs(upward) <= np.abs(downward), CHASM * relief
        no_triangle = heights[:-1, :-1] + heights[1:, 1:] < 1.5 * chasm  # both of the other corners are missing
        upward[~lesser | no_triangle] = downward[lesser] = chasm
        return cls(heights, np.diff(heights, axis=1), relief, upward, downward)

    def raise_near(self, slopes: Doubles, down: float, right: float) -> None:
        """Raise slopes (h, w) to what is seen past the nearest diagonals, which divide squares into two triangles.

        Of the two diagonals of a square it is the one with the lesser step. Farther off, rows and columns tell enough.
        """
        for number in range(1, DIAGONALS + 1):
            if abs(down + right) > ON_THE_GRID:  # diagonals on which rows plus columns are the same
                distance = number / abs(down + right)
                row = math.ceil(distance * down - ON_THE_GRID)
                node = (row, round(distance * (down + right)) - row)
                square = (row - 1, node[1])
                self._raise_past(slopes, node, square, self.upward, row - distance * down, distance)
            if abs(down - right) > ON_THE_GRID:  # and rows minus columns
                distance = number / abs(down - right)
                row = math.floor(distance * down + ON_THE_GRID)
                node = (row, row - round(distance * (down - right)))
                self._raise_past(slopes, node, node, self.downward, distance * down - row, distance)

    def _raise_past(
        self,
        slopes: Doubles,
        node: tuple[int, int],
        square: tuple[int, int],
        rises: Doubles,
        part: float,
        distance: float,
    ) -> None:
        """Raise slopes by what stands on the diagonals of squares at an offset, part of the way from a node."""
        spans = [
            slice(max(0, -offset), min(size, size - 1 - offset))
            for size, offset in zip(slopes.shape, square, strict=True)
        ]
        if part < ON_THE_GRID or any(span.start >= span.stop for span in spans):
            return
        here = (spans[0], spans[1])
        from_node, along = (
            tuple(slice(span.start + offset, span.stop + offset) for span, offset in zip(spans, offsets, strict=True))
            for offsets in (node, square)
        )
        rise = cv2.scaleAdd(rises[along], part, self.heights[from_node])
        cv2.addWeighted(rise, 1 / distance, self.heights[here], -1 / distance, 0.0, rise)
        cv2.max(slopes[here], rise, slopes[here])

    def raise_slopes(self, slopes: Doubles, down: float, right: float) -> None:
        """Raise slopes (h, w) to what is seen past the rows along a direction that is not parallel to them.

        The surface between two neighbouring pixels of a row is the straight line, and the line of sight is compared
        with it where it crosses a row: every row near by, fewer in the distance. Minus infinity is the slope where
        everything is seen, and infinity asks for none.
        """
        height, width = self.heights.shape
        sign, shift, length = (1 if down > 0 else -1), right / abs(down), math.hypot(down, right) / abs(down)
        last = height - 1 if abs(shift) * (height - 1) < width else math.floor((width - 1) / abs(shift))
        ahead = self._highest_ahead(sign)
        size = max(1, BAND // width)
        scratch = np.empty((size, width))
        for first in range(0, height, size):
            box = (slice(first, min(first + size, height)), slice(0, width))
            for octave in octaves(last):
                box = self._still_blocked(slopes, box, ahead, sign * octave[0], octave[0] * length, last * length)
                if box[0].start >= box[0].stop:
                    break
                for step in octave:
                    self._raise(slopes, box, sign * step, step * shift, 1 / (step * length), scratch)

    def _highest_ahead(self, sign: int) -> Doubles:
        """Return the greatest height in each row or beyond it."""
        rows = self.heights.max(axis=1)[::-sign]
        return np.asarray(np.maximum.accumulate(rows)[::-sign])

    def _still_blocked(
        self, slopes: Doubles, box: Rectangle, ahead: Doubles, down: int, near: float, far: float
    ) -> Rectangle:
        """Return the part of a box whose slopes may be raised by rows so far down or beyond, from near to far."""
        rows, columns = box
        rows = slice(max(rows.start, -down), max(min(rows.stop, len(ahead) - down), 0))
        if rows.start >= rows.stop:
            return slice(0, 0), columns
        here = (rows, columns)
        highest = ahead[rows.start + down : rows.stop + down, None]
        needed = np.minimum(slopes[here] * near, slopes[here] * far)  # downward a line is lowest at its far end
        blocked = np.asarray(highest - self.heights[here] > needed)
        return _shrunk(rows, blocked, 1), _shrunk(columns, blocked, 0)

    def _raise(
        self, slopes: Doubles, box: Rectangle, down: int, right: float, per_pixel: float, scratch: Doubles
    ) -> None:
        """Raise the slopes of a box by what stands so many rows and columns away."""
        whole = math.floor(right + ON_THE_GRID)
        part = right - whole if right - whole > ON_THE_GRID else 0.0
        height, width = slopes.shape
        rows = slice(max(box[0].start, -down), min(box[0].stop, height - down))
        columns = slice(max(box[1].start, -whole), min(box[1].stop, width - whole - (part > 0)))
        if rows.start >= rows.stop or columns.start >= columns.stop:
            return
        here = (rows, columns)
        there = (slice(rows.start + down, rows.stop + down), slice(columns.start + whole, columns.stop + whole))
        own, rise = self.heights[here], scratch[: rows.stop - rows.start, : columns.stop - columns.start]
        other = cv2.scaleAdd(self.rises[there], part, self.heights[there], rise) if part else self.heights[there]
        cv2.addWeighted(other, per_pixel, own, -per_pixel, 0.0, rise)
        cv2.max(slopes[here], rise, slopes[here])  # three passes over each block, where arrays would take five


def octaves(last: int) -> Iterator[range]:
    """Yield the steps 1 to `last` at which lines of sight are looked at, an octave of distances after the other."""
    first = 1
    while first <= last:
        spacing = max(1, int(first * SPACING))
        yield range(first, min(2 * first - 1, last) + 1, spacing)
        first *= 2


def _shrunk(span: slice, wanted: NDArray[np.bool_], across: int) -> slice:
    """Return the part of a span from the first to the last that is wanted anywhere across it."""
    found = np.flatnonzero(wanted.any(axis=across))
    return slice(span.start + int(found[0]), span.start + int(found[-1]) + 1) if found.size else slice(0, 0)
