"""Reduction: pixels of a mask as means over squares, for what needs few of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]


def reduced_mask(mask: Mask, side: int) -> Mask:
    """Return which squares of `side` pixels lie in the mask whole."""
    height, width = (size // side for size in mask.shape)
    return np.asarray(
        mask[: height * side, : width * side].reshape(height, side, width, side).all(axis=(1, 3)), np.bool_
    )


def reduced(rows: Floats, mask: Mask, side: int, small: Mask) -> Doubles:
    """Return the means of rows (k, p) over the squares of a reduced mask."""
    height, width = small.shape
    grid = np.zeros(mask.shape)
    found = np.empty((len(rows), int(small.sum())))
    for row, target in zip(rows, found, strict=True):
        grid[mask] = row
        blocks = grid[: height * side, : width * side].reshape(height, side, width, side)
        target[:] = blocks.mean(axis=(1, 3))[small]
    return found
