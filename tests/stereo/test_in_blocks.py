from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.in_blocks import Pixels, Stack, solved, spread

RANDOM = np.random.default_rng(0)
IMAGES = RANDOM.uniform(0, 1, (5, 9, 7)).astype(np.float32)
COLOURS = RANDOM.uniform(0, 1, (5, 9, 7, 3)).astype(np.float32)
MASK = RANDOM.uniform(size=(9, 7)) > 0.3
MASK[4:6] = False  # rows of nothing


@pytest.mark.parametrize("size", [1, 80, 1 << 20])
def test_blocks_are_the_masked_pixels_in_order(size: int) -> None:
    blocks = list(Stack(IMAGES, MASK).blocks(size))
    assert_array_equal(np.concatenate(blocks, axis=1), IMAGES[:, MASK])
    assert all(block.flags.c_contiguous and block.dtype == np.float32 for block in blocks)


def test_grey_is_the_mean_of_balanced_colours() -> None:
    assert_allclose(next(Stack(COLOURS, MASK).blocks()), COLOURS[:, MASK].mean(axis=2), rtol=1e-6)
    balance = np.array([[2.0, 0.5, 0.5]] * 5)
    found = next(Stack(COLOURS, MASK, balance).blocks())
    assert_allclose(found, (COLOURS[:, MASK] * balance[0]).mean(axis=2), rtol=1e-6)


def test_one_saturated_colour_saturates() -> None:
    found = next(Stack(COLOURS, MASK, saturation=0.9).blocks())
    full = (COLOURS[:, MASK] >= 0.9).any(axis=2)
    assert full.any() and not full.all()
    assert (found[full] == np.float32(0.9)).all() and (found[~full] < 0.9).all()


def test_a_mapped_file_is_read_through_mappings_of_its_own(tmp_path: Path) -> None:
    np.save(tmp_path / "images.npy", IMAGES)
    mapped = np.lib.format.open_memmap(tmp_path / "images.npy", mode="r")
    assert_array_equal(np.concatenate(list(Stack(mapped, MASK).blocks(80)), axis=1), IMAGES[:, MASK])
    part = mapped[1:4]  # a part of it has an offset of its own
    assert_array_equal(np.concatenate(list(Stack(part, MASK).blocks(80)), axis=1), IMAGES[1:4, MASK])


def test_nan_in_the_mask_is_refused() -> None:
    images = IMAGES.copy()
    images[3, ~MASK] = np.nan
    list(Stack(images, MASK).blocks())
    images[3, np.flatnonzero(MASK.any(axis=1))[0], np.flatnonzero(MASK[0])[0]] = np.inf
    with pytest.raises(HarmonicFaceError, match="expected finite intensities in the mask, got others in image 3"):
        list(Stack(images, MASK).blocks())


def test_reduced_pixels_are_means_over_squares() -> None:
    images = RANDOM.uniform(0, 1, (3, 20, 26)).astype(np.float32)
    mask = np.ones((20, 26), bool)
    mask[:, :5] = False
    small, side = Stack(images, mask).reduced(120)
    assert side == 2 and small.images.shape == (3, 10, 13)
    assert not small.mask[:, :2].any() and small.mask[:, 2:].all()  # half of the third column's squares are inside
    expected = images.reshape(3, 10, 2, 13, 2).mean(axis=(2, 4))
    assert_allclose(small.images[:, :, 3:], expected[:, :, 3:], rtol=1e-5)
    assert_allclose(small.images[:, :, 2], images[:, :, 5].reshape(3, 10, 2).mean(axis=2), rtol=1e-5)


def test_reduced_squares_with_a_saturated_pixel_are_saturated() -> None:
    images = np.full((3, 4, 4), 0.5, np.float32)
    images[1, 0, 0] = 1.0
    small, side = Stack(images, np.ones((4, 4), bool), saturation=1.0).reduced(4)
    assert side == 2
    assert_allclose(small.images[1], [[1, 0.5], [0.5, 0.5]])


def test_few_pixels_stay_as_they_are_and_colours_become_grey() -> None:
    stack = Stack(IMAGES, MASK)
    assert stack.reduced(1000) == (stack, 1)
    grey, side = Stack(COLOURS, MASK).reduced(1000)
    assert side == 1
    assert_allclose(next(grey.blocks()), COLOURS[:, MASK].mean(axis=2), rtol=1e-6)


def test_solved_pixels_are_put_together() -> None:
    def solve(observations: np.ndarray) -> Pixels:
        count = observations.shape[1]
        ones = np.ones(count)
        return Pixels(observations[:3].T, ones, 2 * ones, np.full(count, len(observations)))

    told: list[tuple[int, int]] = []
    found = solved(Stack(IMAGES, MASK), solve, lambda *each: told.append(each))
    assert_array_equal(found.scaled, IMAGES[:3, MASK].T)
    assert (found.used == 5).all() and found.used.dtype == np.int32
    assert told[-1] == (MASK.sum(), MASK.sum())
    assert_array_equal(spread(found.scaled, MASK)[MASK], found.scaled)
