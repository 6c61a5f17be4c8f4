"""Blocks: every pixel of many photographs, a few rows at a time, so that memory does not grow with their number."""

from __future__ import annotations

import mmap
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.squares import square_sums

BLOCK = 1 << 23  # observations at a time: 32 MB in float32, and some copies in float64

Mask = NDArray[np.bool_]
Images = NDArray[np.floating[Any]]


@dataclass(frozen=True, eq=False)
class Pixels:
    """What was found of masked pixels, in row-major order.

    Parameters
    ----------
    scaled
        (p, 3) albedo times normal.
    residual
        (p,) root mean square of photograph minus model over the photographs that were used.
    confidence
        (p,) standard error of the normal in degrees; infinity where the photographs do not determine it.
    used
        (p,) how many photographs each pixel was solved from.
    """

    scaled: Floats
    residual: Floats
    confidence: Floats
    used: NDArray[np.integer[Any]]


@dataclass(frozen=True, eq=False)
class Stack:
    """Photographs of one thing, and what of them is looked at.

    Parameters
    ----------
    images
        (n, h, w) or (n, h, w, 3) linear intensities. May be mapped from a file: then only the rows of a block are
        looked at, through a mapping of their own that ends with it.
    mask
        (h, w) booleans.
    balance
        (n, 3) by what the colours of each photograph are multiplied before their mean is taken; 1 by default. A mean
        of 1 keeps what is below the saturation there.
    saturation
        An observation of which any colour reaches it is given as it: infinity for none.
    """

    images: Images
    mask: Mask
    balance: Floats | None = None
    saturation: float = np.inf

    def __len__(self) -> int:
        return len(self.images)

    @property
    def pixels(self) -> int:
        """How many pixels are looked at."""
        return int(self.mask.sum())

    def blocks(self, size: int = BLOCK) -> Iterator[Floats]:
        """Yield the grey observations of masked pixels, block by block in row-major order, (n, p) and contiguous.

        Parameters
        ----------
        size
            Observations at a time.

        Raises
        ------
        HarmonicFaceError
            NaN or infinity in the mask.

        Examples
        --------
        >>> stack = Stack(np.arange(12.0).reshape(2, 3, 2), np.ones((3, 2), bool))
        >>> [block.tolist() for block in stack.blocks(8)]
        [[[0.0, 1.0, 2.0, 3.0], [6.0, 7.0, 8.0, 9.0]], [[4.0, 5.0], [10.0, 11.0]]]
        """
        count, height, width = self.images.shape[:3]
        step = max(size // (count * width), 1)
        for top in range(0, height, step):
            inside = self.mask[top : top + step]
            if not inside.any():
                continue
            rows = self._rows(top, min(top + step, height))
            found = np.ascontiguousarray(rows.reshape(count, -1) if inside.all() else rows[:, inside])
            if not np.isfinite(found).all():
                index = int(np.flatnonzero(~np.isfinite(found).all(axis=1))[0])
                raise HarmonicFaceError(f"images: expected finite intensities in the mask, got others in image {index}")
            yield found

    def reduced(self, most: int) -> tuple[Stack, int]:
        """Return photographs of at most so many pixels, each the mean over a square, and the square's side.

        A square of which less than half is in the mask is left outside; one with a saturated pixel is saturated.
        """
        side = max(int(np.ceil(np.sqrt(self.pixels / most))), 1)
        if side == 1 and self.images.ndim == 3:
            return self, 1
        height, width = self.mask.shape[0] // side, self.mask.shape[1] // side
        count = len(self)
        inside = square_sums(self.mask, side)
        images = np.empty((count, height, width), np.float32)
        step = max(BLOCK // (count * width * side**2), 1)
        for top in range(0, height, step):
            bottom = min(top + step, height)
            rows = self._rows(top * side, bottom * side)
            part = self.mask[top * side : bottom * side]
            means = square_sums(np.where(part, rows, 0.0), side) / np.maximum(inside[top:bottom], 1)
            full = square_sums(part & (rows >= self.saturation), side) > 0
            images[:, top:bottom] = np.where(full, self.saturation, means)
        return Stack(images, 2 * inside >= side**2, saturation=self.saturation), side

    def _rows(self, top: int, bottom: int) -> Floats:
        """Return some rows of all images in grey, (n, rows, w); of a file, by a mapping that ends with it."""
        source: Any = self.images
        if isinstance(source, np.memmap) and isinstance(source.base, mmap.mmap):  # whole, not a part of a mapped array
            source = np.memmap(source.filename, source.dtype, "r", source.offset, source.shape)
        rows = np.array(source[:, top:bottom])
        if rows.ndim == 3:
            return rows
        full = (rows >= self.saturation).any(axis=3)
        if self.balance is None:
            grey = rows.mean(axis=3, dtype=rows.dtype)
        else:
            grey = np.einsum("nhwc,nc->nhw", rows, self.balance.astype(rows.dtype) / 3)
        grey[full] = self.saturation
        return np.asarray(grey)


def solved(
    stack: Stack, solve: Callable[[Floats], Pixels], tell: Callable[[int, int], None] = lambda *_: None
) -> Pixels:
    """Return what a solver of (n, p) observations finds of all masked pixels, each of them by itself.

    Parameters
    ----------
    stack
        The photographs.
    solve
        From observations to what they say.
    tell
        Is told how many pixels are done, and of how many.
    """
    total, done = stack.pixels, 0
    parts = []
    for observations in stack.blocks():
        found = solve(observations)
        columns = found.scaled, found.residual, found.confidence
        parts.append((*(column.astype(np.float32) for column in columns), found.used.astype(np.int32)))
        done += observations.shape[1]
        tell(done, total)
    scaled, residual, confidence, used = (np.concatenate(column) for column in zip(*parts, strict=True))
    return Pixels(scaled, residual, confidence, used)


def spread(values: NDArray[Any], mask: Mask) -> NDArray[Any]:
    """Put the values of masked pixels back on the grid, zeros elsewhere."""
    grid = np.zeros(mask.shape + values.shape[1:], values.dtype)
    grid[mask] = values
    return grid
