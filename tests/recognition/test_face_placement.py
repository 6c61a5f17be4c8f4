"""A face is found where it was put, whatever the light, size and crop."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from harmonicface.appearance.render import render
from harmonicface.datasets.yale_b import load_yale_b
from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.lights import directional
from harmonicface.lighting.natural import natural
from harmonicface.people.prior import FacePrior, synthetic_prior
from harmonicface.people.synthetic import synthetic_person
from harmonicface.recognition.face_placement import filled, place_face

SHAPE = (96, 84)
MIDDLE = np.array([41.5, 47.5, 1.0])


@pytest.fixture(scope="module")
def prior() -> FacePrior:
    return synthetic_prior((48, 42), 20)


def photograph(seed: int, size: tuple[int, int] = SHAPE) -> np.ndarray:
    return render(synthetic_person(seed, size), natural(seed))


def in_pixels_of(prior: FacePrior, motion: np.ndarray) -> np.ndarray:
    """A motion from the prior's pixels as one from pixels of SHAPE."""
    shrink = prior.shape[0] / SHAPE[0]
    linear = motion[:, :2] * shrink
    return np.column_stack([linear, motion[:, 2] + motion[:, :2] @ np.full(2, (shrink - 1) / 2)])


def test_the_prior_s_own_crop(prior: FacePrior) -> None:
    motions = [in_pixels_of(prior, place_face(photograph(seed), prior).motion) for seed in range(8)]
    misses = np.array([motion @ MIDDLE - MIDDLE[:2] for motion in motions])
    scales = np.array([motion[0, 0] for motion in motions])
    assert np.sqrt((misses**2).mean()) < 1.5 and np.abs(misses).max() < 4
    assert np.abs(np.log(scales)).max() < 0.08


@pytest.mark.parametrize(("scale", "right", "down"), [(1.15, 0, 0), (0.88, 3, -2), (1.0, -6, 6)])
def test_a_crop_of_another_kind(prior: FacePrior, scale: float, right: float, down: float) -> None:
    centre = MIDDLE[:2]
    moved = np.column_stack([scale * np.eye(2), centre * (1 - scale) + [right, down]])
    misses = []
    for seed in range(6):
        photo = cv2.warpAffine(photograph(seed), moved, SHAPE[::-1], borderMode=cv2.BORDER_REPLICATE)
        found = in_pixels_of(prior, place_face(photo, prior).motion)
        misses.append((found - moved) @ MIDDLE)
    assert np.median(np.abs(misses)) < 2


def test_finer_photographs_are_found_at_the_same_place(prior: FacePrior) -> None:
    coarse, fine = (place_face(photograph(3, size), prior).motion for size in (SHAPE, (192, 168)))
    np.testing.assert_allclose(fine @ [20.5, 23.5, 1], 2 * (coarse @ [20.5, 23.5, 1]) + 0.5, atol=2.1)


def test_brightness_changes_nothing(prior: FacePrior) -> None:
    photo = photograph(1)
    once, again = place_face(photo, prior), place_face(1000 * photo, prior)
    np.testing.assert_allclose(again.motion, once.motion)
    assert again.correlation == pytest.approx(once.correlation, abs=1e-4)


def test_faces_fit_better_than_noise(prior: FacePrior) -> None:
    rng = np.random.default_rng(0)
    faces = [place_face(photograph(seed), prior).correlation for seed in range(5)]
    noise = [place_face(cv2.GaussianBlur(rng.uniform(0, 1, SHAPE), (0, 0), 2), prior).correlation for _ in range(5)]
    assert min(faces) > 1.2 * max(noise)


def test_light_from_the_side_moves_nothing(prior: FacePrior) -> None:
    person = synthetic_person(4, SHAPE)
    motions = [place_face(render(person, directional([x, 0.2, 1.0])), prior).motion for x in (-1, 0, 1)]
    places = np.array([in_pixels_of(prior, motion) @ MIDDLE for motion in motions])
    assert np.ptp(places, axis=0).max() < 4.5


@pytest.mark.data
def test_photographs_of_one_person_agree(prior: FacePrior, data_dir) -> None:
    for person in load_yale_b(data_dir / "yaleb", people=[1, 2]):
        photos = person.photographs[person.subsets <= 3][::4]
        motions = np.array([place_face(photo, prior).motion for photo in photos])
        places = motions @ [20.5, 23.5, 1]
        assert np.median(np.abs(places - np.median(places, axis=0))) <= 4  # pixels of 192 rows


def test_holes_are_filled_from_the_nearest_pixel() -> None:
    mask = np.array([[True, False, False], [True, True, False]])
    picture = np.array([[1, 9, 9], [2, 3, 9]], np.float32)
    np.testing.assert_array_equal(filled(picture, mask)[1], [2, 3, 3])
    assert filled(picture, mask)[0, 1] in (1, 3)
    np.testing.assert_array_equal(filled(picture, np.ones((2, 3), bool)), picture)
    np.testing.assert_array_equal(filled(np.stack([picture, -picture], 2), mask)[1, :, 1], [-2, -3, -3])


@pytest.mark.parametrize(
    ("photo", "message"),
    [
        (np.ones((15, 40)), "at least 16 x 16"),
        (np.ones((40, 40, 3)), "at least 16 x 16"),
        (np.full((40, 40), 0.3), "expected contrast, got 0.3 everywhere"),
        (np.full((40, 40), np.nan), "finite"),
    ],
)
def test_what_is_no_photograph(prior: FacePrior, photo: np.ndarray, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        place_face(photo, prior)


def test_a_prior_without_an_inside() -> None:
    mask = np.zeros((48, 42), bool)
    mask[10] = True
    line = FacePrior(np.ones((9, 42), np.float32), np.ones((1, 9, 42), np.float32), np.zeros(9), mask, 1.0, "a line")
    with pytest.raises(HarmonicFaceError, match="a face with an inside"):
        place_face(photograph(0), line)
