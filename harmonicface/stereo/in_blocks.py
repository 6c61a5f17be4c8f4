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

BLOCK = 1 << 23  # observations at a time: 32 MB in float32, and some copies in float64

Mask = NDArray[np.bool_]
Stack = NDArray[np.floating[Any]]


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


def blocks(images: Stack, mask: Mask, size: int = BLOCK) -> Iterator[tuple[slice, Floats]]:
    """Yield the observations of masked pixels block by block: where they stand among the pixels, and (n, p) of them.

    Parameters
    ----------
    images
        (n, h, w), or (n, h, w, 3) of which the grey is the mean of the colours. May be mapped from a file: of a
        mapped array only the rows of a block are looked at, through a mapping of their own that ends with it.
    mask
        (h, w) booleans.
    size
        Observations at a time.

    Yields
    ------
    slice
        The pixels' numbers in row-major order of the mask.
    array
        (n, p) of the images' type, contiguous.

    Raises
    ------
    HarmonicFaceError
        NaN or infinity in the mask.

    Examples
    --------
    >>> stack = np.arange(12.0).reshape(2, 3, 2)
    >>> [(part.start, part.stop, rows.tolist()) for part, rows in blocks(stack, np.ones((3, 2), bool), 8)]
    [(0, 4, [[0.0, 1.0, 2.0, 3.0], [6.0, 7.0, 8.0, 9.0]]), (4, 6, [[4.0, 5.0], [10.0, 11.0]])]
    """
    count, height, width = images.shape[:3]
    step = max(size // (count * width), 1)
    first = 0
    for top in range(0, height, step):
        inside = mask[top : top + step]
        if not inside.any():
            continue
        rows = _rows(images, top, min(top + step, height))
        found = np.ascontiguousarray(rows.reshape(count, -1) if inside.all() else rows[:, inside])
        if not np.isfinite(found).all():
            index = int(np.flatnonzero(~np.isfinite(found).all(axis=1))[0])
            raise HarmonicFaceError(f"images: expected finite intensities in the mask, got others in image {index}")
        yield slice(first, first + found.shape[1]), found
        first += found.shape[1]


def solved(
    images: Stack, mask: Mask, solve: Callable[[Floats], Pixels], tell: Callable[[int, int], None] = lambda *_: None
) -> Pixels:
    """Return what a solver of (n, p) observations finds of all masked pixels.

    Parameters
    ----------
    images, mask
        See `blocks`.
    solve
        From observations to what they say; each pixel by itself.
    tell
        Is told how many pixels are done, and of how many.
    """
    total = int(mask.sum())
    parts = []
    for part, observations in blocks(images, mask):
        found = solve(observations)
        parts.append(
            (
                found.scaled.astype(np.float32),
                found.residual.astype(np.float32),
                found.confidence.astype(np.float32),
                found.used.astype(np.int32),
            )
        )
        tell(part.stop, total)
    scaled, residual, confidence, used = (np.concatenate(column) for column in zip(*parts, strict=True))
    return Pixels(scaled, residual, confidence, used)


def gram(images: Stack, mask: Mask) -> NDArray[np.float64]:
    """Return the products of the photographs with one another over the mask, (n, n) in float64."""
    total = np.zeros((len(images), len(images)))
    for _, observations in blocks(images, mask):
        exact = observations.astype(np.float64, copy=False)
        total += exact @ exact.T
    return total


def spread(values: NDArray[Any], mask: Mask) -> NDArray[Any]:
    """Put the values of masked pixels back on the grid, zeros elsewhere."""
    grid = np.zeros(mask.shape + values.shape[1:], values.dtype)
    grid[mask] = values
    return grid


def _rows(images: Stack, top: int, bottom: int) -> Floats:
    """Return some rows of all images as (n, rows, w), colours averaged; of a file, by a mapping that ends with it."""
    source: Any = images
    if isinstance(images, np.memmap) and isinstance(images.base, mmap.mmap):  # whole, not a part of a mapped array
        source = np.memmap(images.filename, images.dtype, "r", images.offset, images.shape)
    rows = np.array(source[:, top:bottom])
    return rows if rows.ndim == 3 else np.asarray(rows.mean(axis=3, dtype=rows.dtype))
