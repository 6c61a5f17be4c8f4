from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.motion import STILL, checked_motion, displacement, resample, then, undone

PHOTO = np.random.default_rng(0).uniform(0, 1, (5, 7)).astype(np.float32)
TURN = np.array([[0.8, -0.6, 1.0], [0.6, 0.8, -2.0]])


def test_no_motion_changes_nothing() -> None:
    seen, known = resample(PHOTO, STILL)
    assert_array_equal(seen, PHOTO)
    assert known.all()


@pytest.mark.parametrize(("right", "down"), [(2, 0), (-1, 3), (0, -4)])
def test_whole_shifts_are_copies_and_the_border_is_repeated(right: int, down: int) -> None:
    seen, known = resample(PHOTO, [[1, 0, right], [0, 1, down]])
    rows, columns = np.arange(5) + down, np.arange(7) + right
    inside = ((rows >= 0) & (rows < 5))[:, None] & ((columns >= 0) & (columns < 7))
    assert_array_equal(known, inside)
    assert_allclose(seen, PHOTO[np.clip(rows, 0, 4)][:, np.clip(columns, 0, 6)], atol=1e-6)


@pytest.mark.parametrize(("shift", "pixels"), [(0.5, 1e-5), (0.25, 0.05), (0.1, 0.05), (0.83, 0.05)])
def test_a_ramp_is_resampled_to_a_twentieth_of_a_pixel_inside(shift: float, pixels: float) -> None:
    x = np.tile(np.arange(50.0), (40, 1))
    seen, _ = resample(x, [[1, 0, shift], [0, 1, -0.5]])
    assert np.abs(seen - (x + shift))[3:-3, 3:-3].max() < pixels


def test_cubics_do_not_leave_the_range() -> None:
    step = np.zeros((9, 9))
    step[:, 5:] = 1
    seen, _ = resample(step, [[1, 0, 0.5], [0, 1, 0]])
    assert (seen.min(), seen.max()) == (0, 1)


def test_motions_compose_and_undo() -> None:
    shift = np.array([[1.0, 0, 3], [0, 1, 4]])
    point = np.array([2.0, -1.0, 1.0])
    assert_allclose(then(TURN, shift) @ point, TURN @ point + [3, 4])
    assert_allclose(then(TURN, undone(TURN)), STILL, atol=1e-12)


def test_displacement_is_that_of_the_corners() -> None:
    assert displacement(np.array([[1.0, 0, 3], [0, 1, 4]]), (10, 20)) == 5
    half_turn = np.array([[-1.0, 0, 2], [0, -1, 4]])  # about (1, 2), the centre of 5 x 3 pixels
    assert_allclose(displacement(half_turn, (5, 3)), 2 * np.hypot(1, 2))


@pytest.mark.parametrize(
    ("image", "motion", "message"),
    [
        (np.zeros(4), STILL, r"image: expected shape \(h, w\), got an array of shape \(4,\)"),
        (np.full((3, 3), np.nan), STILL, "image: expected finite numbers"),
        (PHOTO, np.eye(3), r"motion: expected a matrix of shape \(2, 3\), got an array of shape \(3, 3\)"),
        (PHOTO, [[1, 0, np.inf], [0, 1, 0]], "motion: expected finite numbers"),
        (PHOTO, [[1, 1, 0], [1, 1, 0]], "motion: expected one that can be undone, got"),
    ],
)
def test_bad_input(image: np.ndarray, motion: object, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        resample(image, motion)


def test_a_motion_comes_back_in_double_precision() -> None:
    assert checked_motion(TURN.astype(np.float32)).dtype == np.float64
