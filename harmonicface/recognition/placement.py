"""Placement: by which shift, turn and growth a photograph shows people, found by the votes of their blocks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import cv2
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.blocks import BLOCK, block_grid, known_blocks
from harmonicface.recognition.blocks import REACH as SEARCHED
from harmonicface.recognition.patterns import Pattern, Template
from harmonicface.stereo.motion import Matrix

REACH = 10  # pixels of the grid by which a block may be displaced
SIDE = 2 * REACH + 1
NEARBY = 4
TURNS = np.radians(np.arange(-6, 7, 2))  # of the trials; what is between them is found by the blocks' own places
GROWTHS = np.arange(-6, 7, 2) / 100
COARSE = np.array([-4, 0, 4])  # degrees and percent: tell who may be in the photograph
LEADERS = 6  # of whom all trials are made
SHIFTS = np.arange(-10, 11, 2)  # each block is free by a pixel around a trial
CHARGE = 0.002  # of correlation, for a pixel by which blocks are displaced in the mean
PRIOR = (0.1, 0.1, 8.0, 8.0)  # usual turn, growth and shifts: what they are where blocks tell little
ROUNDS = 3
FLOOR = 0.1  # of correlation: blocks with less tell nothing of their place
AGREEING = 1.0  # pixel: blocks that are farther from where the others put them count less
TINY = 1e-6

Doubles = NDArray[np.float64]


@dataclass(frozen=True)
class Placement:
    """How a photograph shows a person displaced, turned and grown about the middle of the picture.

    Parameters
    ----------
    right, down
        Pixels.
    turn
        Degrees clockwise.
    growth
        0.05 for five percent larger.
    """

    right: float = 0.0
    down: float = 0.0
    turn: float = 0.0
    growth: float = 0.0

    def motion(self, shape: tuple[int, ...]) -> Matrix:
        """Return the (2, 3) motion from pixels of the person's frame, of this shape, to those of the photograph.

        Examples
        --------
        >>> Placement(right=3).motion((96, 84)).tolist()
        [[1.0, 0.0, 3.0], [0.0, 1.0, 0.0]]
        """
        angle = np.radians(self.turn)
        linear = (1 + self.growth) * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        centre = (np.array(shape[:-3:-1]) - 1) / 2
        return np.column_stack([linear, centre - linear @ centre + [self.right, self.down]]) + 0.0

    @classmethod
    def of(cls, motion: Matrix, shape: tuple[int, ...]) -> Placement:
        """Return the placement whose `motion` this is.

        Examples
        --------
        >>> Placement.of(Placement(1, 2, 3, 0.25).motion((96, 84)), (96, 84))
        Placement(right=1.0, down=2.0, turn=3.0, growth=0.25)
        """
        centre = (np.array(shape[:-3:-1]) - 1) / 2
        right, down = (motion @ [*centre, 1.0] - centre).round(9)
        turn, size = np.degrees(np.arctan2(motion[1, 0], motion[0, 0])), np.hypot(motion[0, 0], motion[1, 0])
        return cls(float(right), float(down), float(turn.round(9)), float(size.round(9) - 1))

    def scaled(self, factor: float) -> Placement:
        """Return the same placement in pixels that are smaller by a factor."""
        return Placement(factor * self.right, factor * self.down, self.turn, self.growth)


@dataclass(frozen=True, eq=False)
class Placed:
    """Who of some people is found, and where.

    Parameters
    ----------
    index
        Of the person for whom there are most votes.
    placement
        In pixels of the grid.
    votes
        The mean correlation of blocks there, each free by a pixel, less what the displacement is charged.
    gain
        By how much this is more than shifts alone reach that `similarity` tries too; 0 if one of those is the best.
    """

    index: int
    placement: Placement
    votes: float
    gain: float


def placed(query: Pattern, templates: Sequence[Template]) -> Placed:
    r"""Find whom of some people a photograph shows and where, whatever its light.

    Each 12 x 12 block of a template is correlated with the photograph's patterns at all displacements up to 10 pixels,
    and votes for all motions that put it there. With c_b the correlation of block b at the middle x_b, free by a pixel,
    and u its displacement by a motion, the motion with the most votes is

    .. math:: \max_{m} \frac{1}{n} \sum_b c_b(u_m(x_b)) - \kappa |u_m|

    over turns and growths of up to 6 degrees and percent and shifts of up to 10 pixels; the charge is the logarithm of
    a prior by which people move little. Of many people, a few of these trials tell who is looked at closely. Then each
    block's own best place about it, to a fraction of a pixel, gives the similarity that fits them best, by least
    squares in which blocks that correlate more count more and those that disagree with the others less.

    Parameters
    ----------
    query
        (3, h, w) `patterns` of the photograph.
    templates
        Of at least one person, on the same (h, w).

    Raises
    ------
    HarmonicFaceError
        Nobody, or another shape.

    Examples
    --------
    >>> from harmonicface.recognition.patterns import patterns
    >>> face = np.random.default_rng(0).uniform(0.1, 1, (48, 48))
    >>> found = placed(patterns(np.roll(face, 7, axis=1)), [Template.of([patterns(face)])])
    >>> found.index, round(found.placement.right), round(found.placement.down), found.gain > 0
    (0, 7, 0, True)
    """
    for template in templates:
        _check(query, template)
    if not templates:
        raise HarmonicFaceError("templates: expected at least one, got none")
    flat = query.sum(axis=0)
    blocks = _blocks(flat, templates)
    maps = _maps(flat, blocks, REACH)
    shared = np.maximum(blocks.any(axis=2).sum(axis=0), 1)
    leaders = np.arange(len(templates))
    if len(templates) > LEADERS:
        votes = _votes(maps, shared, _trials(flat.shape, fine=False)).max(axis=1)
        leaders = np.argsort(-votes, kind="stable")[:LEADERS]
    trials = _trials(flat.shape, fine=True)
    votes = _votes(maps[leaders], shared[leaders], trials)
    place, best = (int(index) for index in np.unravel_index(votes.argmax(), votes.shape))
    most, person = float(votes[place, best]), int(leaders[place])
    start = trials.motions[best] if most > 0 else np.zeros(4)
    placement = _as_placement(_refined(maps[person], _middles(flat.shape), start))
    return Placed(person, placement, most, float(most - votes[place, trials.usual].max()))


def placed_nearby(query: Pattern, template: Template, shift: tuple[int, int] = (0, 0)) -> Placement:
    """Find where a photograph shows a person who is nearly where a shift puts her: the last step of `placed`.

    Parameters
    ----------
    query
        (3, h, w) `patterns` of the photograph.
    template
        Hers, on the same (h, w).
    shift
        Pixels to the right and down; she is found if her blocks are no more than two or three pixels from there.

    Raises
    ------
    HarmonicFaceError
        Another shape.

    Examples
    --------
    >>> from harmonicface.recognition.patterns import patterns
    >>> face = np.random.default_rng(0).uniform(0.1, 1, (48, 48))
    >>> found = placed_nearby(patterns(np.roll(face, 3, axis=0)), Template.of([patterns(face)]), (0, 2))
    >>> round(found.right, 1) + 0.0, round(found.down, 1)
    (0.0, 3.0)
    """
    _check(query, template)
    right, down = shift
    height, width = template.shape
    edge = max(abs(right), abs(down))
    larger = cv2.copyMakeBorder(query.sum(axis=0), edge, edge, edge, edge, cv2.BORDER_CONSTANT, value=0)
    flat = np.ascontiguousarray(larger[edge + down : edge + down + height, edge + right : edge + right + width])
    maps = _maps(flat, _blocks(flat, [template]), NEARBY)
    found = _as_placement(_refined(maps[0], _middles(flat.shape), np.zeros(4)))
    return replace(found, right=found.right + right, down=found.down + down)


def _check(query: Pattern, template: Template) -> None:
    if template.shape != query.shape[1:]:
        raise HarmonicFaceError(f"templates: expected the query's shape {query.shape[1:]}, got {template.shape}")


def _blocks(flat: Pattern, templates: Sequence[Template]) -> Pattern:
    """Return the blocks of templates, 0 where the photograph has none, (b, n, 144)."""
    return np.stack([template.blocks for template in templates], axis=1) * known_blocks(flat)[:, None, None]


@dataclass(frozen=True, eq=False)
class _Trials:
    """Motions to be voted for: (m, 4) turn, growth, right, down; (m, b) where in a block's map they lead."""

    motions: Doubles
    places: NDArray[np.intp]
    displacements: Doubles
    usual: NDArray[np.bool_]


@cache
def _trials(shape: tuple[int, int], fine: bool) -> _Trials:
    """Return all trials on a grid, or a few."""
    turns, growths = (TURNS, GROWTHS) if fine else (np.radians(COARSE), COARSE / 100)
    motions = np.stack(np.meshgrid(turns, growths, SHIFTS, SHIFTS, indexing="ij"), axis=-1).reshape(-1, 4).astype(float)
    displaced = _displaced(motions[:, None], _middles(shape))
    right, down = (np.rint(one).astype(np.intp) + REACH for one in displaced)
    inside = (right >= 0) & (right < SIDE) & (down >= 0) & (down < SIDE)
    places = np.where(inside, down * SIDE + right, SIDE * SIDE)  # the last place of a map is 0
    places += np.arange(places.shape[1]) * (SIDE * SIDE + 1)
    usual = (motions[:, :2] == 0).all(axis=1) & (np.abs(motions[:, 2:]) <= SEARCHED).all(axis=1)
    return _Trials(motions, places, np.hypot(*displaced).mean(axis=1), usual)


def _middles(shape: tuple[int, ...]) -> tuple[Doubles, Doubles]:
    """Return x and y of the blocks' middles, from the middle of the picture."""
    down, across = block_grid(shape)
    y, x = (
        np.arange(count) * BLOCK + side % BLOCK // 2 + (BLOCK - 1) / 2 - (side - 1) / 2
        for count, side in ((down, shape[0]), (across, shape[1]))
    )
    return np.tile(x, down), np.repeat(y, across)


def _displaced(motion: Doubles, middles: tuple[Doubles, Doubles]) -> tuple[Doubles, Doubles]:
    """Return how far to the right and down motions (..., 4) move the middles of blocks."""
    x, y = middles
    turn, growth, right, down = np.moveaxis(motion, -1, 0)
    return growth * x - turn * y + right, growth * y + turn * x + down


def _maps(flat: Pattern, blocks: Pattern, reach: int) -> Pattern:
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


def _votes(maps: Pattern, shared: NDArray[np.intp], trials: _Trials) -> Pattern:
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


def _refined(maps: Pattern, middles: tuple[Doubles, Doubles], motion: Doubles) -> Doubles:
    """Return the motion (4,) that fits the blocks' own best places about a motion."""
    x, y = middles
    each, reach = np.arange(len(maps)), maps.shape[-1] // 2
    zero, one = np.zeros_like(x), np.ones_like(x)
    rows = np.concatenate([np.column_stack([-y, x, one, zero]), np.column_stack([x, y, zero, one])])
    for _ in range(ROUNDS):
        expected = _displaced(motion, middles)
        column, row = (np.clip(np.rint(displaced).astype(int) + reach, 2, 2 * reach - 2) for displaced in expected)
        around = np.stack([maps[each, row + i, column + j] for i in (-1, 0, 1) for j in (-1, 0, 1)], axis=1)
        down, right = np.divmod(around.argmax(axis=1), 3)
        row, column = row + down - 1, column + right - 1
        height = maps[each, row, column]
        found_x = column - reach + _vertex(maps[each, row, column - 1], height, maps[each, row, column + 1])
        found_y = row - reach + _vertex(maps[each, row - 1, column], height, maps[each, row + 1, column])
        far = np.hypot(found_x - expected[0], found_y - expected[1])
        weights = np.square(np.maximum(height - FLOOR, 0)) / (1 + np.square(far / AGREEING))
        weighted = rows * np.tile(weights, 2)[:, None]
        normal = weighted.T @ rows + np.diag(np.square(np.reciprocal(PRIOR)))
        motion = np.linalg.solve(normal, weighted.T @ np.concatenate([found_x, found_y]))
    return motion


def _vertex(before: Pattern, here: Pattern, after: Pattern) -> Doubles:
    """Return where the parabola through three values has its top, from the middle one."""
    bend = np.maximum(2.0 * here - before - after, TINY)
    return np.asarray(np.clip((after - before) / (2 * bend), -0.5, 0.5), np.float64)


def _as_placement(motion: Doubles) -> Placement:
    """Return the placement of turn, growth, right, down, of which the first two are a linear similarity."""
    turn, growth, right, down = (float(one) for one in motion)
    return Placement(
        right, down, float(np.degrees(np.arctan2(turn, 1 + growth))), float(np.hypot(turn, 1 + growth) - 1)
    )
