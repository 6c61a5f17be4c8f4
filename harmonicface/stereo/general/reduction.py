"""Reduction: pixels of a mask as means over squares, for what needs few of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.stereo.squares import square_sums

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]


def reduced_mask(mask: Mask, side: int) -> Mask:
    """Return which squares of `side` pixels lie in the mask whole."""
    return np.asarray(square_sums(mask, side) == side**2)


def reduced(rows: Floats, mask: Mask, side: int, small: Mask) -> Doubles:
    """Return the means of rows (k, p) over the squares of a reduced mask."""
    grid = np.zeros(mask.shape)
    found = np.empty((len(rows), int(small.sum())))
    for row, target in zip(rows, found, strict=True):
        grid[mask] = row
        target[:] = square_sums(grid, side)[small] / side**2
    return found
