"""Photographs of synthetic people, moved by known amounts, under light that no picture of them showed."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.alignment import align, pyramid_of, reduced
from harmonicface.recognition.subspace import Subspace
from harmonicface.stereo.motion import STILL, resample, undone

SIZE = 96
FACES = list(hf.synthetic_people(3, SIZE, seed=5))
IMAGES = [np.zeros((9, SIZE, SIZE), np.float32) for _ in FACES]
for pictures, face in zip(IMAGES, FACES, strict=True):
    pictures[:, face.mask] = hf.harmonic_images(face)
CENTRE = np.full(2, (SIZE - 1) / 2)


def motion_of(right: float, down: float, degrees: float = 0.0, growth: float = 0.0) -> np.ndarray:
    turn = np.radians(degrees)
    linear = (1 + growth) * np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    return np.column_stack([linear, CENTRE - linear @ CENTRE + [right, down]])


def photo_of(person: int, motion: np.ndarray, seed: int = 0) -> np.ndarray:
    """Return a photograph in which the person was moved so, with a little noise."""
    random = np.random.default_rng([person, seed])
    light = hf.lights.directional(random.normal(size=3) * [1, 1, 0] + [0, 0, 1.2]) + hf.lights.ambient(0.05)
    still = hf.render(FACES[person], light)
    return resample(still, undone(motion))[0] + random.normal(0, 0.002, still.shape)


def corner_error(found: np.ndarray, true: np.ndarray) -> float:
    corners = np.array([[x, y, 1.0] for x in (0, SIZE - 1) for y in (0, SIZE - 1)])
    return float(np.linalg.norm(corners @ (found - true).T, axis=1).max())


@pytest.mark.parametrize(
    ("kind", "motion", "bound"),
    [
        ("shift", motion_of(3.3, -2.6), 0.3),
        ("rigid", motion_of(-2, 2.5, degrees=3), 0.4),
        ("similarity", motion_of(2, -1.5, degrees=-3, growth=0.03), 0.5),
    ],
)
@pytest.mark.parametrize("person", [0, 1, 2])
def test_known_motions_are_found_whatever_the_light(person: int, kind: str, motion: np.ndarray, bound: float) -> None:
    photo = photo_of(person, motion)
    found = align(photo, pyramid_of(IMAGES[person], (4, 2, 1)), motion=kind)
    assert corner_error(found.motion, motion) < bound
    flat = Subspace.of(IMAGES[person].reshape(9, -1))
    assert found.distance < 0.6 * flat.distance(photo.ravel())


def test_what_is_in_place_stays_there() -> None:
    found = align(photo_of(0, STILL), pyramid_of(IMAGES[0]))
    assert corner_error(found.motion, STILL) < 0.3


def test_the_distance_is_that_of_the_photograph_seen_through_the_motion() -> None:
    photo = photo_of(1, motion_of(1.5, 1))
    found = align(photo, pyramid_of(IMAGES[1]))
    seen = resample(photo.astype(np.float32), found.motion)[0]
    assert_allclose(found.distance, Subspace.of(IMAGES[1].reshape(9, -1)).distance(seen.ravel()), rtol=1e-3)


@pytest.mark.parametrize("seed", range(4))
def test_it_is_never_farther_than_the_start(seed: int) -> None:
    photo = photo_of(2, motion_of(*np.random.default_rng(seed).uniform(-9, 9, 2)), seed)
    (rows,) = pyramid_of(IMAGES[0], (1,))
    start = motion_of(*np.random.default_rng(seed).uniform(-3, 3, 2))
    seen = resample(photo.astype(np.float32), start)[0]
    assert align(photo, [rows], start).distance <= Subspace.of(rows.reshape(9, -1)).distance(seen.ravel()) + 1e-5


def test_brightness_changes_nothing() -> None:
    photo, rows = photo_of(0, motion_of(2, 1)), pyramid_of(IMAGES[0])
    assert_allclose(align(1e-4 * photo, rows).motion, align(300 * photo, rows).motion, atol=1e-3)


def test_a_photograph_without_edges_moves_nowhere() -> None:
    flat = np.ones((8, 8))
    assert_allclose(align(flat, pyramid_of(np.ones((1, 8, 8)), (1,))).motion, STILL)


def test_pyramids_span_the_reduced_pictures() -> None:
    coarse, fine = pyramid_of(IMAGES[0], (4, 1))
    assert (coarse.shape, fine.shape) == ((9, 24, 24), (9, SIZE, SIZE))
    assert_allclose(np.tensordot(coarse, coarse, ((1, 2), (1, 2))), np.eye(9), atol=1e-5)
    small = IMAGES[0].reshape(9, 24, 4, 24, 4).mean(axis=(2, 4)).reshape(9, -1)
    inside = coarse.reshape(9, -1)
    assert_allclose(small @ inside.T @ inside, small, atol=1e-5)


ROWS = pyramid_of(np.random.default_rng(0).uniform(0, 1, (2, 8, 8)), (1,))
PHOTO = np.random.default_rng(1).uniform(0, 1, (8, 8))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"motion": "free"}, "motion: expected one of shift, rigid, similarity, got 'free'"),
        ({"photo": PHOTO[0]}, r"photo: expected shape \(h, w\), at least 2 x 2, got an array of shape \(8,\)"),
        ({"photo": 0 * PHOTO}, "photo: expected some light in it, got one that is all 0"),
        ({"photo": np.nan * PHOTO}, "photo: expected finite numbers"),
        ({"photo": PHOTO[:4]}, r"pyramid: expected pictures up to the photo's size \(4, 8\), got \[\(8, 8\)\]"),
        ({"pyramid": []}, r"pyramid: expected pictures up to the photo's size \(8, 8\), got \[\]"),
        ({"pyramid": [PHOTO]}, r"pictures: expected shape \(k, h, w\), got an array of shape \(8, 8\)"),
        ({"start": np.zeros((2, 3))}, "motion: expected one that can be undone"),
    ],
)
def test_bad_input(arguments: dict, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        align(**{"photo": PHOTO, "pyramid": ROWS, **arguments})


@pytest.mark.parametrize(
    ("factor", "message"),
    [(3, "factor: expected a divisor of 8 and 8, got 3"), (0, "factor: expected an integer of at least 1, got int 0")],
)
def test_a_factor_that_does_not_fit(factor: int, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        reduced(PHOTO[None], factor)
