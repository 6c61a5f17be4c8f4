"""Blocks against correlations computed one block and one shift at a time."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from harmonicface.recognition.blocks import BLOCK, block_grid, correlations, known_blocks, unit_blocks


def brute(picture: np.ndarray, other: np.ndarray, reach: int) -> tuple[np.ndarray, np.ndarray]:
    """Return mean correlations with and without a block's freedom of a pixel, by loops."""
    down, across = block_grid(picture.shape)
    top, left = (size % BLOCK // 2 for size in picture.shape)
    padded = np.pad(picture.astype(np.float64), reach + 1)
    sums = np.zeros((2, 2 * reach + 1, 2 * reach + 1))
    for row in range(down):
        for column in range(across):
            y, x = top + row * BLOCK, left + column * BLOCK
            template = other[y : y + BLOCK, x : x + BLOCK].astype(np.float64)
            wide = np.zeros((2 * reach + 3, 2 * reach + 3))
            for i in range(2 * reach + 3):
                for j in range(2 * reach + 3):
                    wide[i, j] = np.corrcoef(
                        padded[y + i : y + i + BLOCK, x + j : x + j + BLOCK].ravel(), template.ravel()
                    )[0, 1]
            for i in range(2 * reach + 1):
                for j in range(2 * reach + 1):
                    sums[:, i, j] += wide[i : i + 3, j : j + 3].max(), wide[i + 1, j + 1]
    return sums[0] / (down * across), sums[1] / (down * across)


@pytest.mark.parametrize("shape", [(24, 24), (31, 40)])
def test_like_blocks_one_by_one(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(0)
    picture, *others = rng.normal(size=(4, *shape)).astype(np.float32)
    free, still = correlations(picture, [unit_blocks(other) for other in others], reach=2)
    for place, other in enumerate(others):
        expected_free, expected_still = brute(picture, other, 2)
        assert_allclose(free[place], expected_free, atol=1e-4)
        assert_allclose(still[place], expected_still, atol=1e-4)


def test_a_picture_is_itself() -> None:
    picture = np.random.default_rng(1).normal(size=(36, 24)).astype(np.float32)
    free, still = correlations(picture, [unit_blocks(picture), unit_blocks(-picture)], reach=1)
    assert_allclose(still[:, 1, 1], [1, -1], atol=1e-5)
    assert_allclose(free[0], 1, atol=1e-5)


def test_what_is_not_known_is_left_out() -> None:
    rng = np.random.default_rng(2)
    picture = rng.normal(size=(24, 24)).astype(np.float32)
    half = picture.copy()
    half[:, :11] = 0  # a column of each left block stays
    assert_array_equal(known_blocks(half), [False, True, False, True])
    assert not unit_blocks(half)[[0, 2]].any()
    for one, other in ((half, picture), (picture, half)):
        _, still = correlations(one, [unit_blocks(other)], reach=0)
        assert_allclose(still, 1, atol=1e-5)
    free, still = correlations(np.zeros_like(picture), [unit_blocks(picture)], reach=1)
    assert not free.any() and not still.any()
