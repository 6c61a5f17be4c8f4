"""Votes of blocks for where they are."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose

from harmonicface.recognition.block_votes import CHARGE, SIDE, displaced, maps_of, middles_of, trials_of, votes_of
from harmonicface.recognition.blocks import BLOCK, block_grid, unit_blocks

SHAPE = (38, 50)  # three by four blocks, and a margin of one row and one column


def picture(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=SHAPE).astype(np.float32)


def test_maps_are_correlations() -> None:
    photo, template = picture(0), picture(1)
    maps = maps_of(photo, unit_blocks(template)[:, None], reach=3)
    assert maps.shape == (1, 12, 7, 7)
    for row, column, down, right in ((1, 1, 0, 0), (1, 2, -2, 3), (2, 1, -3, -1)):
        top, left = 1 + BLOCK * row, 1 + BLOCK * column
        mine = template[top : top + BLOCK, left : left + BLOCK].ravel()
        theirs = photo[top + down : top + down + BLOCK, left + right : left + right + BLOCK].ravel()
        assert_allclose(maps[0, 4 * row + column, down + 3, right + 3], np.corrcoef(mine, theirs)[0, 1], atol=1e-5)


def test_the_middles_of_blocks_are_about_the_middle_of_the_picture() -> None:
    x, y = middles_of(SHAPE)
    assert len(x) == np.prod(block_grid(SHAPE))
    assert_allclose([x.mean(), y.mean()], 0, atol=1e-12)
    assert_allclose(np.unique(x), [-18, -6, 6, 18])


def test_motions_displace_as_similarities_do() -> None:
    right, down = displaced(np.array([0.1, 0.2, 3.0, -1.0]), (np.array([10.0]), np.array([5.0])))
    assert_allclose([right[0], down[0]], [0.2 * 10 - 0.1 * 5 + 3, 0.2 * 5 + 0.1 * 10 - 1])


def test_the_motion_that_is_there_has_the_most_votes() -> None:
    trials = trials_of(SHAPE, fine=True)
    truth = int(np.flatnonzero((trials.motions == [0, 0, 4, -6]).all(axis=1))[0])
    maps = np.zeros((1, 12, SIDE * SIDE + 1), np.float32)
    maps.reshape(-1)[trials.places[truth]] = 1
    votes = votes_of(maps[..., :-1].reshape(1, 12, SIDE, SIDE), np.array([12]), trials)[0]
    assert votes.argmax() == truth
    assert_allclose(votes[truth], 1 - CHARGE * np.hypot(4, -6), rtol=1e-5)
    assert not trials.usual[truth] and trials.usual.sum() == 25  # shifts of up to 4, every second
