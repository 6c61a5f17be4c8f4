from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.frame import Frame

MASK = np.array([[True, False, True], [False, True, True]])
FRAME = Frame.of(MASK)
PICTURE = np.arange(6.0).reshape(2, 3)


def test_pixels_are_taken_row_by_row() -> None:
    assert (FRAME.shape, FRAME.pixels) == ((2, 3), 4)
    assert FRAME.take(PICTURE, "photo").tolist() == [0, 2, 4, 5]


def test_what_is_taken_goes_back_to_its_place() -> None:
    assert_array_equal(FRAME.picture(FRAME.take(PICTURE, "photo")), PICTURE * MASK)


def test_colour_becomes_luminance() -> None:
    colour = np.random.default_rng(0).uniform(size=(2, 3, 3))
    assert_allclose(FRAME.take(colour, "photo"), (colour @ [0.2126, 0.7152, 0.0722])[MASK], rtol=1e-13)


def test_images_of_another_mask_are_placed_where_both_are() -> None:
    mask = np.array([[True, True, True], [True, False, True]])
    images = np.array([PICTURE[mask], -PICTURE[mask]])
    assert FRAME.place(images, mask).tolist() == [[0, 2, 0, 5], [0, -2, 0, -5]]
    assert FRAME.place(images.astype(np.float32), mask).dtype == np.float32


def test_a_frame_keeps_its_own_mask() -> None:
    mask = MASK.copy()
    frame = Frame.of(mask)
    mask[:] = False
    assert frame.pixels == 4


@pytest.mark.parametrize(
    ("mask", "message"),
    [
        (np.ones(3, np.bool_), r"mask: expected shape \(h, w\), got an array of shape \(3,\)"),
        (np.ones((2, 2, 1), np.bool_), r"mask: expected shape \(h, w\), got an array of shape \(2, 2, 1\)"),
        (np.ones((2, 2), np.uint8), "mask: expected a boolean mask"),
        (np.zeros((2, 2), np.bool_), "mask: expected at least one pixel"),
    ],
)
def test_masks_that_are_none(mask: np.ndarray, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        Frame.of(mask)


def test_pictures_that_do_not_fit() -> None:
    with pytest.raises(HarmonicFaceError, match=r"photo: expected the gallery's shape \(2, 3\), got \(3, 2\)"):
        FRAME.take(PICTURE.T, "photo")
    with pytest.raises(HarmonicFaceError, match="photo: expected finite numbers"):
        FRAME.take(PICTURE * np.nan, "photo")
    with pytest.raises(HarmonicFaceError, match=r"surface: expected the gallery's shape \(2, 3\), got \(3, 2\)"):
        FRAME.place(np.ones((1, 6)), np.ones((3, 2), np.bool_))
    with pytest.raises(HarmonicFaceError, match="surface: expected some of its pixels inside the gallery's mask, got"):
        FRAME.place(np.ones((1, 2)), ~MASK)


@pytest.mark.parametrize("shift", [(0, 0), (2, 1), (-1, 3), (0, -2)])
def test_pixels_are_moved_within_the_frame(shift: tuple[int, int]) -> None:
    mask = np.ones((6, 7), np.bool_)
    mask[0, :3] = False
    frame = Frame(mask)
    picture = np.arange(1.0, 43.0).reshape(6, 7)
    good = np.ones(frame.pixels, np.bool_)
    good[4] = False
    moved, known = frame.moved(picture[mask], good, shift)
    for place, (y, x) in enumerate(np.argwhere(mask)):
        from_y, from_x = y - shift[1], x - shift[0]
        inside = 0 <= from_y < 6 and 0 <= from_x < 7 and bool(mask[from_y, from_x])
        there = inside and bool(frame.picture(good.astype(float))[from_y, from_x])
        assert known[place] == there
        if there:
            assert moved[place] == picture[from_y, from_x]
