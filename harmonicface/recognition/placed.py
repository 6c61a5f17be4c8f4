"""Placed: whom of some people a photograph shows displaced, turned and grown, and where."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.block_votes import (
    REACH,
    TINY,
    Doubles,
    displaced,
    maps_of,
    middles_of,
    trials_of,
    votes_of,
)
from harmonicface.recognition.blocks import known_blocks
from harmonicface.recognition.patterns import Pattern, Template
from harmonicface.recognition.placement import Placement

NEARBY = 4
LEADERS = 6  # of whom all trials are made
PRIOR = (0.1, 0.1, 8.0, 8.0)  # usual turn, growth and shifts: what they are where blocks tell little
ROUNDS = 3
FLOOR = 0.1  # of correlation: blocks with less tell nothing of their place
AGREEING = 1.0  # pixel: blocks that are farther from where the others put them count less


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

    over turns and growths of up to 8 degrees and percent and shifts of up to 10 pixels; the charge is the logarithm of
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
    maps = maps_of(flat, blocks, REACH)
    shared = np.maximum(blocks.any(axis=2).sum(axis=0), 1)
    leaders = np.arange(len(templates))
    if len(templates) > LEADERS:
        votes = votes_of(maps, shared, trials_of(flat.shape, fine=False)).max(axis=1)
        leaders = np.argsort(-votes, kind="stable")[:LEADERS]
    trials = trials_of(flat.shape, fine=True)
    votes = votes_of(maps[leaders], shared[leaders], trials)
    place, best = (int(index) for index in np.unravel_index(votes.argmax(), votes.shape))
    most, person = float(votes[place, best]), int(leaders[place])
    start = trials.motions[best] if most > 0 else np.zeros(4)
    placement = _as_placement(_refined(maps[person], middles_of(flat.shape), start))
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
    maps = maps_of(flat, _blocks(flat, [template]), NEARBY)
    found = _as_placement(_refined(maps[0], middles_of(flat.shape), np.zeros(4)))
    return replace(found, right=found.right + right, down=found.down + down)


def _check(query: Pattern, template: Template) -> None:
    if template.shape != query.shape[1:]:
        raise HarmonicFaceError(f"templates: expected the query's shape {query.shape[1:]}, got {template.shape}")


def _blocks(flat: Pattern, templates: Sequence[Template]) -> Pattern:
    """Return the blocks of templates, 0 where the photograph has none, (b, n, 144)."""
    return np.stack([template.blocks for template in templates], axis=1) * known_blocks(flat)[:, None, None]


def _refined(maps: Pattern, middles: tuple[Doubles, Doubles], motion: Doubles) -> Doubles:
    """Return the motion (4,) that fits the blocks' own best places about a motion."""
    x, y = middles
    each, reach = np.arange(len(maps)), maps.shape[-1] // 2
    zero, one = np.zeros_like(x), np.ones_like(x)
    rows = np.concatenate([np.column_stack([-y, x, one, zero]), np.column_stack([x, y, zero, one])])
    for _ in range(ROUNDS):
        expected = displaced(motion, middles)
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
