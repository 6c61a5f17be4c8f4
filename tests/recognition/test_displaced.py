from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import harmonicface as hf
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.displaced import ShiftSearch
from harmonicface.recognition.subspace import Subspace

SIZE = 48
FACES = list(hf.synthetic_people(4, SIZE, seed=2))
IMAGES = [np.zeros((9, SIZE, SIZE), np.float32) for _ in FACES]
for pictures, face in zip(IMAGES, FACES, strict=True):
    pictures[:, face.mask] = hf.harmonic_images(face)
LIGHT = hf.lights.directional([0.6, 0.3, 1])


def enrolled(**settings: float) -> ShiftSearch:
    search = ShiftSearch(**settings)
    for images in IMAGES:
        search.enroll(images)
    return search


def photo_of(person: int, right: int, down: int) -> np.ndarray:
    """Return a photograph in which the person stands further right and down, her border repeated."""
    padded = np.pad(hf.render(FACES[person], LIGHT), 20, mode="edge")
    return padded[20 - down : 20 - down + SIZE, 20 - right : 20 - right + SIZE]


@pytest.mark.parametrize("shift", [(0, 0), (2, -4), (-6, 6), (4, 2)])
def test_shifts_are_found(shift: tuple[int, int]) -> None:
    for person in range(4):
        found = enrolled().match(photo_of(person, *shift))
        assert found.scores.argmin() == person
        assert_array_equal(found.shifts[person], shift)


def test_without_reach_it_is_plain_projection() -> None:
    photo = photo_of(1, 1, 0)
    found = enrolled(factor=1, reach=0).match(photo)
    expected = [Subspace.of(images.reshape(9, -1)).distance(photo.ravel()) for images in IMAGES]
    assert_allclose(found.distances, expected, atol=2e-4)
    assert_array_equal(found.scores, found.distances)
    assert_array_equal(found.shifts, 0)


def test_the_same_as_a_loop_over_shifts() -> None:
    photo = photo_of(0, 2, 1)
    found = enrolled(factor=1, reach=3, reluctance=0.05).match(photo)
    subspace = Subspace.of(IMAGES[2].reshape(9, -1))
    padded = np.pad(photo, 3, mode="edge")
    scores = {}
    for right in range(-3, 4):
        for down in range(-3, 4):
            seen = padded[3 + down : 3 + down + SIZE, 3 + right : 3 + right + SIZE]
            scores[right, down] = subspace.distance(seen.ravel()) * np.exp(0.05 * np.hypot(right, down))
    best = min(scores, key=scores.__getitem__)
    assert_allclose(found.scores[2], scores[best], atol=2e-4)
    assert_array_equal(found.shifts[2], best)


def test_reluctance_keeps_people_where_they_are() -> None:
    photo = photo_of(0, 2, 0)
    assert np.abs(enrolled(reluctance=0).match(photo).shifts).max() > 0
    assert_array_equal(enrolled(reluctance=5.0).match(photo).shifts, 0)


def test_brightness_changes_nothing() -> None:
    search, photo = enrolled(), photo_of(3, 2, 2)
    assert_allclose(search.match(1e-20 * photo).scores, search.match(1e20 * photo).scores, atol=1e-5)


def test_people_come_one_by_one_and_cost_their_rows() -> None:
    search = ShiftSearch()
    assert (len(search), search.bytes_per_person) == (0, 0)
    for number, images in enumerate(IMAGES, start=1):
        search.enroll(images)
        assert len(search) == number
        assert len(search.match(photo_of(0, 0, 0)).scores) == number
    assert search.bytes_per_person == 9 * 24 * 24 * 4


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"factor": 0}, "factor: expected an integer of at least 1, got int 0"),
        ({"reach": -1}, "reach: expected an integer of at least 0, got int -1"),
        ({"reluctance": -0.1}, "reluctance: expected a finite number above 0, got -0.1"),
    ],
)
def test_bad_settings(settings: dict, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        ShiftSearch(**settings)


@pytest.mark.parametrize(
    ("photo", "message"),
    [
        (np.ones((SIZE, 10)), r"photo: expected shape \(48, 48\), got an array of shape \(48, 10\)"),
        (np.zeros((SIZE, SIZE)), "photo: expected some light in it, got 2304 pixels that are all 0"),
        (np.full((SIZE, SIZE), np.nan), "photo: expected finite numbers"),
    ],
)
def test_bad_photographs(photo: np.ndarray, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        enrolled().match(photo)


def test_bad_people() -> None:
    search = ShiftSearch()
    with pytest.raises(HarmonicFaceError, match="match: expected somebody to be enrolled, got nobody"):
        search.match(np.ones((4, 4)))
    with pytest.raises(HarmonicFaceError, match="factor: expected a divisor of 47 and 48, got 2"):
        search.enroll(IMAGES[0][:, :-1])
    search.enroll(IMAGES[0])
    with pytest.raises(
        HarmonicFaceError, match=r"images: expected the size of those before, \(24, 24\), got \(24, 22\)"
    ):
        search.enroll(IMAGES[1][:, :, :44])
