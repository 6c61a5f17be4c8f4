"""Blocks of a picture, correlated with those of many others at all small shifts."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

BLOCK = 12  # pixels a side
REACH = 4  # largest common shift
FREEDOM = 1  # of a block about the common shift
TINY = 1e-6  # of the length of a block: one that is constant

Picture = NDArray[np.float32]


def block_grid(shape: tuple[int, ...]) -> tuple[int, int]:
    """Return how many blocks a picture has down and across.

    Examples
    --------
    >>> block_grid((96, 84))
    (8, 7)
    """
    return shape[0] // BLOCK, shape[1] // BLOCK


def unit_blocks(picture: Picture) -> Picture:
    """Return the blocks of a picture at mean 0 and length 1, (b, 144) row by row; 0 where less than half is known.

    Examples
    --------
    >>> unit_blocks(np.eye(24, 36, dtype=np.float32)).shape
    (6, 144)
    """
    blocks = _cut(picture)
    centred = blocks - blocks.mean(axis=1, keepdims=True)
    length = np.linalg.norm(centred, axis=1, keepdims=True)
    return np.asarray(centred / (length + np.float32(TINY)) * _known(blocks)[:, None], np.float32)


def known_blocks(picture: Picture) -> NDArray[np.bool_]:
    """Return which blocks of a picture are known: more than half of their pixels are not 0, (b,)."""
    return _known(_cut(picture))


def correlations(picture: Picture, blocks: Sequence[Picture], reach: int = REACH) -> tuple[Picture, Picture]:
    """Return the mean correlation of a picture's blocks with those of n others at all common shifts.

    Parameters
    ----------
    picture
        (h, w).
    blocks
        The `unit_blocks` of n pictures of that size, each (b, 144).
    reach
        Largest common shift; each block is free by one pixel about it.

    Returns
    -------
    free, still
        Both (n, 2 reach + 1, 2 reach + 1), by shifts down and to the right: with each block free by a pixel, and
        without. Means go over the blocks that are known of both pictures; 0 where there are none.

    Examples
    --------
    >>> picture = np.random.default_rng(0).normal(size=(24, 24)).astype(np.float32)
    >>> free, still = correlations(np.roll(picture, 1, axis=1), [unit_blocks(picture)], reach=3)
    >>> [int(index) for index in np.unravel_index(still[0].argmax(), still[0].shape)]
    [3, 4]
    """
    down, across = block_grid(picture.shape)
    side = 2 * (reach + FREEDOM) + 1
    known = known_blocks(picture).reshape(down, across)
    strips, lengths = _strips(picture, reach + FREEDOM)
    weights = known[:, :, None, None] / lengths
    # a row of blocks at a time stays in the cache, and in memory that has been used before
    patches = np.empty((across, side * side, BLOCK**2), np.float32)
    products = np.empty((across, len(blocks), side * side), np.float32)
    free = np.zeros((len(blocks), side - 2 * FREEDOM, side - 2 * FREEDOM), np.float32)
    still, shared = np.zeros((len(blocks), side, side), np.float32), np.zeros(len(blocks), np.float32)
    for row in range(down):
        theirs = np.stack([one[row * across : (row + 1) * across] for one in blocks], axis=1)
        patches.reshape(across, side, side, -1)[:] = strips[row]
        np.matmul(theirs, patches.swapaxes(1, 2), out=products)
        np.multiply(products, weights[row].reshape(across, 1, -1), out=products)
        square = products.reshape(across, -1, side, side)
        free += _largest_around(square).sum(axis=0)
        still += square.sum(axis=0)
        shared += (theirs.any(axis=2) & known[row][:, None]).sum(axis=0)
    shared = np.maximum(shared, 1)[:, None, None]
    return free / shared, still[:, FREEDOM:-FREEDOM, FREEDOM:-FREEDOM] / shared


def _strips(picture: Picture, reach: int) -> tuple[Picture, Picture]:
    """Return views of the blocks of a picture at all shifts, 0 outside it, and their lengths.

    (down, across, side, side, 144) and (down, across, side, side), side of 2 reach + 1. Behind the first are strips as
    wide as a block, one for each shift to the right, in which the block at any shift down is one run of memory.
    """
    down, across = block_grid(picture.shape)
    top, left = _margins(picture.shape)
    side = 2 * reach + 1
    padded = cv2.copyMakeBorder(picture, reach, reach, reach, reach, cv2.BORDER_CONSTANT, value=0)
    rows, columns = padded.strides
    shape = (side, across, len(padded) - top, BLOCK)
    strips = np.ascontiguousarray(as_strided(padded[top:, left:], shape, (columns, BLOCK * columns, rows, columns)))
    right, strip, line, _ = strips.strides
    view = as_strided(strips, (down, across, side, side, BLOCK**2), (BLOCK * line, strip, line, right, columns))
    lengths = _lengths(padded)
    rows, columns = lengths.strides
    shape = (down, across, side, side)
    return view, as_strided(lengths[top:, left:], shape, (BLOCK * rows, BLOCK * columns, rows, columns))


def _lengths(padded: Picture) -> Picture:
    """Return the length about the mean of the block that begins at each pixel."""
    box, corner, outside = (BLOCK, BLOCK), (0, 0), cv2.BORDER_CONSTANT
    total = cv2.boxFilter(padded, cv2.CV_32F, box, anchor=corner, normalize=False, borderType=outside)
    squares = cv2.sqrBoxFilter(padded, cv2.CV_32F, box, anchor=corner, normalize=False, borderType=outside)
    spread = np.maximum(squares - np.square(total) / BLOCK**2, 0)
    return np.asarray(np.sqrt(spread) + np.float32(TINY))


def _largest_around(products: Picture) -> Picture:
    """Return the maximum over the 3 x 3 neighbourhood, (..., side - 2, side - 2), by maxima of pairs."""
    across = np.maximum(products[..., :-1], products[..., 1:])
    across = np.maximum(across[..., :-1], products[..., 2:])
    down = np.maximum(across[..., :-1, :], across[..., 1:, :])
    return np.asarray(np.maximum(down[..., :-1, :], across[..., 2:, :]))


def _cut(picture: Picture) -> Picture:
    """Return the blocks of a picture, (b, 144); what is left over at the borders is left out."""
    down, across = block_grid(picture.shape)
    top, left = _margins(picture.shape)
    inside = picture[top : top + down * BLOCK, left : left + across * BLOCK]
    return inside.reshape(down, BLOCK, across, BLOCK).swapaxes(1, 2).reshape(down * across, BLOCK * BLOCK)


def _margins(shape: tuple[int, ...]) -> tuple[int, int]:
    """Return the first row and column of the first block: half of what is left over."""
    return shape[0] % BLOCK // 2, shape[1] % BLOCK // 2


def _known(blocks: Picture) -> NDArray[np.bool_]:
    """Return which blocks are more than half known."""
    return np.asarray(np.count_nonzero(blocks, axis=1) > BLOCK * BLOCK / 2)
