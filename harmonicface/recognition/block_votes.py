"""Votes of blocks: for which shift, turn and growth the blocks of a template find themselves in a photograph."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from harmonicface.recognition.blocks import BLOCK, block_grid
from harmonicface.recognition.blocks import REACH as SEARCHED
from harmonicface.recognition.patterns import Pattern

REACH = 10  # pixels of the grid by which a block may be displaced
SIDE = 2 * REACH + 1
TURNS = np.radians(np.arange(-8, 9, 2))  # of the trials; what is between them is found by the blocks' own places
GROWTHS = np.arange(-8, 9, 2) / 100
COARSE = np.array([-8, -4, 0, 4, 8])  # degrees and percent: tell who may be in the photograph
SHIFTS = np.arange(-10, 11, 2)  # each block is free by a pixel around a trial
CHARGE = 0.002  # of correlation, for a pixel by which blocks are displaced in the mean
TINY = 1e-6

Doubles = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Trials:
    """Motions to be voted for: (m, 4) turn, growth, right, down; (m, b) where in a block's map they lead."""

    motions: Doubles
    places: NDArray[np.intp]
    displacements: Doubles
    usual: NDArray[np.bool_]


@cache
def trials_of(shape: tuple[int, int], fine: bool) -> Trials:
    """Return all trials on a grid, or a few."""
    turns, growths = (TURNS, GROWTHS) if fine else (np.radians(COARSE), COARSE / 100)
    motions = np.stack(np.meshgrid(turns, growths, SHIFTS, SHIFTS, indexing="ij"), axis=-1).reshape(-1, 4).astype(float)
    moved = displaced(motions[:, None], middles_of(shape))
    right, down = (np.rint(one).astype(np.intp) + REACH for one in moved)
    inside = (right >= 0) & (right < SIDE) & (down >= 0) & (down < SIDE)
    places = np.where(inside, down * SIDE + right, SIDE * SIDE)  # the last place of a map is 0
    places += np.arange(places.shape[1]) * (SIDE * SIDE + 1)
    usual = (motions[:, :2] == 0).all(axis=1) & (np.abs(motions[:, 2:]) <= SEARCHED).all(axis=1)
    return Trials(motions, places, np.hypot(*moved).mean(axis=1), usual)


def middles_of(shape: tuple[int, ...]) -> tuple[Doubles, Doubles]:
    """Return x and y of the blocks' middles, from the middle of the picture."""
    down, across = block_grid(shape)
    y, x = (
        np.arange(count) * BLOCK + side % BLOCK // 2 + (BLOCK - 1) / 2 - (side - 1) / 2
        for count, side in ((down, shape[0]), (across, shape[1]))
    )
    return np.tile(x, down), np.repeat(y, across)


def displaced(motion: Doubles, middles: tuple[Doubles, Doubles]) -> tuple[Doubles, Doubles]:
    """Return how far to the right and down motions (..., 4) move the middles of blocks."""
    x, y = middles
    turn, growth, right, down = np.moveaxis(motion, -1, 0)
    return growth * x - turn * y + right, growth * y + turn * x + down


def maps_of(flat: Pattern, blocks: Pattern, reach: int) -> Pattern:
    """Return the correlations of blocks (b, n, 144) with a picture at all displacements, (n, b, side, side)."""
    across, side = block_grid(flat.shape)[1], 2 * reach + 1
    top, left = (length % BLOCK // 2 for length in flat.shape)
    padded = cv2.copyMakeBorder(flat, reach, reach, reach, reach, cv2.BORDER_CONSTANT, value=0)
    box, corner, outside = (BLOCK, BLOCK), (0, 0), cv2.BORDER_CONSTANT
    total = cv2.boxFilter(padded, cv2.CV_32F, box, anchor=corner, normalize=False, borderType=outside)
    squares = cv2.sqrBoxFilter(padded, cv2.CV_32F, box, anchor=corner, normalize=False, borderType=outside)
    lengths = np.sqrt(np.maximum(squares - np.square(total) / BLOCK**2, 0)) + np.float32(TINY)
    windows = sliding_window_view(padded, box)
    patches = np.empty((side, side, BLOCK, BLOCK), np.float32)
    maps = np.empty((blocks.shape[1], len(blocks), side, side), np.float32)
    for index, theirs in enumerate(blocks):
        row, column = divmod(index, across)
        here = np.s_[top + row * BLOCK :, left + column * BLOCK :]
        patches[:] = windows[here][:side, :side]
        products = theirs @ patches.reshape(side * side, -1).T
        np.divide(products.reshape(-1, side, side), lengths[here][:side, :side], out=maps[:, index])
    return maps


def votes_of(maps: Pattern, shared: NDArray[np.intp], trials: Trials) -> Pattern:
    """Return the mean correlation of blocks for each trial, each block free by a pixel, less the charge, (n, m)."""
    people, blocks = maps.shape[:2]
    free = _largest_around(_largest_around(maps).swapaxes(2, 3)).swapaxes(2, 3)
    votes = np.empty((people, len(trials.motions)), np.float32)
    padded = np.zeros((blocks, SIDE * SIDE + 1), np.float32)
    for person, own in enumerate(free):
        padded[:, :-1] = own.reshape(blocks, -1)
        np.sum(np.take(padded, trials.places), axis=1, out=votes[person])
    return np.asarray(votes / shared[:, None].astype(np.float32) - CHARGE * trials.displacements.astype(np.float32))


def _largest_around(maps: Pattern) -> Pattern:
    """Return the maximum of each value and its neighbours along the last axis."""
    largest = maps.copy()
    np.maximum(largest[..., 1:], maps[..., :-1], out=largest[..., 1:])
    np.maximum(largest[..., :-1], maps[..., 1:], out=largest[..., :-1])
    return largest
