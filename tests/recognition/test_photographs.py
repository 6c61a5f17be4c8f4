from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.photographs import one_photo, stacked

FACES = np.random.default_rng(0).uniform(0, 1, (5, 4, 3))


def test_people_follow_each_other() -> None:
    given = stacked([FACES[:2], FACES[2:3], FACES[3:].tolist()])
    assert_array_equal(given.people, [0, 0, 1, 2, 2])
    assert_array_equal(given.images, FACES.astype(np.float32))
    assert given.count == 3
    assert given.people.dtype == np.int32


@pytest.mark.parametrize(
    ("photographs", "message"),
    [
        ([], "expected those of at least one person, got none"),
        ([FACES[0]], r"photographs of person 0: expected shape \(n, h, w\), got an array of shape \(4, 3\)"),
        ([FACES, FACES[:0]], r"photographs of person 1: expected shape \(n, h, w\), got an array of shape \(0, 4, 3\)"),
        ([FACES, FACES[:, 1:]], r"photographs of person 1: expected images of shape \(4, 3\) .*, got \(3, 3\)"),
        ([FACES, FACES * np.nan], "photographs of person 1: expected finite numbers"),
        (["ada"], "photographs of person 0: expected an array of real numbers"),
    ],
)
def test_what_cannot_be_stacked(photographs: list[np.ndarray], message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        stacked(photographs)


@pytest.mark.parametrize(
    ("photo", "shape", "message"),
    [
        (FACES[0], None, "expected people to be enrolled before a photo is matched"),
        (FACES[0], (3, 4), r"photo: expected shape \(3, 4\), got an array of shape \(4, 3\)"),
        (FACES[0] * np.inf, (4, 3), "photo: expected finite numbers"),
    ],
)
def test_what_cannot_be_matched(photo: np.ndarray, shape: tuple[int, int] | None, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        one_photo(photo, shape)
