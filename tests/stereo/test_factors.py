"""Leading factors of photographs: against numpy's SVD, in blocks, in float32, and of what has no such rank."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.factors import BLOCK, leading_factors


def photographs(count=20, pixels=5000, rank=9, weakest=1e-2, noise=1e-4, seed=0):
    """Return non-negative factors of falling strength with some noise."""
    rng = np.random.default_rng(seed)
    strengths = np.geomspace(1, weakest, rank)
    return rng.uniform(0, 1, (count, rank)) * strengths @ rng.normal(size=(rank, pixels)) + noise * rng.normal(
        size=(count, pixels)
    )


def test_equal_to_numpy():
    matrix = photographs()
    u, s, v = np.linalg.svd(matrix, full_matrices=False)
    found = leading_factors(matrix, 9)
    assert np.allclose(found.singular_values, s, rtol=1e-9)
    assert np.allclose(found.left @ found.right, u[:, :9] * s[:9] @ v[:9], atol=1e-9)
    assert np.allclose(found.right @ found.right.T, np.eye(9), atol=1e-9)
    assert found.rank == 9 and found.pixels == 5000
    assert np.isclose(found.gap, s[8] / s[9]) and np.isclose(found.condition, s[0] / s[8])
    assert np.isclose(found.residual(9), np.sqrt(np.mean((matrix - u[:, :9] * s[:9] @ v[:9]) ** 2)))
    assert (found.left.sum(axis=0) > 0).all()


@pytest.mark.parametrize("weakest", [1e-1, 1e-3, 1e-4])
def test_float32_keeps_small_singular_values(weakest):
    matrix = photographs(96, 30_000, weakest=weakest, noise=weakest / 20).astype(np.float32)
    exact = np.linalg.svd(matrix.astype(np.float64), compute_uv=False)
    found = leading_factors(matrix, 9)
    assert np.abs(found.singular_values[:9] - exact[:9]).max() < 1e-5 * exact[0]
    assert found.right.dtype == np.float32


def test_blocks_are_the_same_as_the_whole():
    matrix = photographs()
    whole = leading_factors(matrix, 4)
    listed = leading_factors([matrix[:, :1000], matrix[:, 1000:1003], matrix[:, 1003:]], 4)
    streamed = leading_factors(iter(np.array_split(matrix, 7, axis=1)), 4)
    assert np.allclose(listed.left, whole.left) and np.allclose(listed.right, whole.right)
    assert np.allclose(streamed.left, whole.left) and streamed.right is None
    assert np.allclose(streamed.project(matrix[:, 10:20]), whole.right[:, 10:20])
    assert streamed.pixels == 5000


def test_nested_lists_are_a_matrix():
    assert leading_factors([[3.0, 0.0], [0.0, 4.0]], 1).singular_values.tolist() == [4.0, 3.0]


def test_rank_above_noise():
    noise = 1e-3
    found = leading_factors(photographs(rank=4, weakest=0.3, noise=noise), 4)
    assert found.above_noise(noise) == 4
    assert found.above_noise(1e3) == 0


def test_one_factor_alone():
    found = leading_factors(np.outer([1.0, 2.0, 3.0], np.ones(50)), 1)
    assert found.gap > 1e6
    assert found.condition == pytest.approx(1)
    black = leading_factors(np.zeros((3, 5)), 2)
    assert black.condition == np.inf and black.gap == np.inf
    assert leading_factors(np.eye(2), 2).gap == np.inf
    assert np.isfinite(black.right).all() and np.isfinite(black.project(np.ones((3, 1)))).all()


@pytest.mark.parametrize(
    ("matrix", "rank", "message"),
    [
        (np.zeros((2, 3, 4)), 1, r"photographs: expected shape \(n, p\)"),
        (np.zeros((0, 4)), 1, r"photographs: expected shape \(n, p\)"),
        ([], 1, "photographs: expected at least one block"),
        (iter(()), 1, "photographs: expected at least one block"),
        ([np.ones((3, 4)), np.ones((2, 4))], 1, r"photographs: expected shape \(3, b\) as the first block"),
        (iter([np.ones((3, 4)), np.ones((2, 4))]), 1, r"photographs: expected shape \(3, b\) as the first block"),
        (np.array([[1.0, 2.0], [np.nan, 1.0]]), 1, "photographs: expected finite intensities, .* photograph 1"),
        (iter([np.array([[np.inf, 2.0], [0.0, 1.0]])]), 1, "photographs: expected finite intensities, .* photograph 0"),
        (np.ones((3, 4)), 4, "rank: expected at most the 3 photographs there are, got 4"),
        (np.ones((3, 4)), 0, "rank: expected an integer of at least 1"),
    ],
)
@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")
def test_refusals(matrix, rank, message):
    with pytest.raises(HarmonicFaceError, match=message):
        leading_factors(matrix, rank)


@pytest.mark.parametrize("third", [1e-6, 1e-10, 1e-14])
def test_faint_factors_are_found_without_squares(third: float) -> None:
    random = np.random.default_rng(5)
    left, right = (np.linalg.qr(random.normal(size=(size, 3)))[0] for size in (7, 3 * BLOCK + 5))
    photographs = (left * [1.0, 0.5, third]) @ right.T
    found = leading_factors(photographs, 3)
    assert_allclose(found.singular_values[:3], np.linalg.svd(photographs, compute_uv=False)[:3], atol=1e-15)
    assert found.condition == pytest.approx(1 / third, rel=0.1)
    assert_allclose(found.left @ found.right, photographs, atol=1e-15)


def test_what_squares_cannot_tell_from_nothing_is_nothing_where_blocks_come_once() -> None:
    random = np.random.default_rng(6)
    left, right = (np.linalg.qr(random.normal(size=(size, 3)))[0] for size in (7, 200))
    found = leading_factors(iter([(left * [1.0, 0.5, 1e-10]) @ right.T]), 3)
    assert found.condition == np.inf and not found.singular_values[2:].any()


@pytest.mark.parametrize("factor", [1e-200, 1e200])
def test_blocks_of_very_unlike_brightness_that_come_once(factor: float) -> None:
    random = np.random.default_rng(7)
    blocks = [random.normal(size=(4, 20)), factor * random.normal(size=(4, 20)), np.zeros((4, 3))]
    for order in ((0, 1, 2), (1, 0, 2), (2, 1, 0)):
        found = leading_factors(iter([blocks[index] for index in order]), 2)
        assert_allclose(found.singular_values, np.linalg.svd(np.hstack(blocks), compute_uv=False), rtol=1e-12)
        assert found.residual(2) == pytest.approx(
            max(1, factor) * leading_factors(np.hstack(blocks) / max(1, factor), 2).residual(2)
        )
