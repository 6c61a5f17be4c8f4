"""Render and compare: against weighted least squares, chance, and photographs that are combinations."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.ndimage import gaussian_filter

import harmonicface as hf
from harmonicface.recognition.render_compare import Photograph, Pictures

RNG = np.random.default_rng(0)
IMAGES = RNG.uniform(0.1, 1, (4, 48, 36))


def detail(picture: np.ndarray) -> np.ndarray:
    return gaussian_filter(picture, 0.7) - gaussian_filter(picture, 1.4)


def test_a_combination_is_explained() -> None:
    photo = np.tensordot([0.4, 0.1, 0.3, 0.2], IMAGES, 1)
    found = Photograph(photo).explained(Pictures.of(IMAGES))
    assert_allclose(found.share, 1, atol=1e-5)
    assert found.distance < 1e-3
    assert_allclose(found.picture / found.picture.max(), photo / photo.max(), atol=1e-4)
    assert_allclose(Photograph(photo).likeness([found.picture, photo.astype(np.float32)]), 1, atol=1e-3)


def test_the_share_is_that_of_weighted_least_squares() -> None:
    photo = RNG.uniform(0.1, 1, (48, 36))
    scaled = photo / photo.max()
    target = detail(scaled)
    energy = gaussian_filter(target**2, 3)
    root = np.sqrt(1 / (energy + 0.1 * energy.mean())).ravel()
    columns = np.array([detail(image).ravel() * root for image in IMAGES]).T
    rest = target.ravel() * root
    expected = 1 - np.sum((rest - columns @ np.linalg.lstsq(columns, rest)[0]) ** 2) / np.sum(rest**2)
    found = Photograph(photo).explained(Pictures.of(IMAGES))
    assert_allclose(found.share, expected, rtol=1e-3)
    flat = IMAGES.reshape(4, -1)
    left = photo.ravel() - np.linalg.lstsq(flat.T, photo.ravel())[0] @ flat
    assert_allclose(found.distance, np.linalg.norm(left) / np.linalg.norm(photo), rtol=1e-4)


@pytest.mark.parametrize("count", [1, 3, 9])
def test_strangers_surprise_by_one_deviation(count: int) -> None:
    rng = np.random.default_rng(count)
    photo = Photograph(rng.uniform(0.1, 1, (48, 48)))
    surprises = [photo.explained(Pictures.of(rng.uniform(0.1, 1, (count, 48, 48)))).surprise for _ in range(150)]
    assert_allclose(np.std(surprises), 1, atol=0.2)


def test_people_are_lit_where_they_are() -> None:
    photo = np.roll(np.tensordot([0.4, 0.1, 0.3, 0.2], IMAGES, 1), (2, -3), axis=(0, 1))
    asked = Photograph(photo)
    at_rest, found = asked.explained(Pictures.of(IMAGES)), asked.explained(Pictures.of(IMAGES), ((0, 0), (-3, 2)))
    assert (at_rest.shift, found.shift) == ((0, 0), (-3, 2))
    assert at_rest.share < 0.1 < 0.95 < found.share
    inner = np.s_[6:-6, 6:-6]
    assert_allclose((found.picture / photo)[inner], (found.picture / photo)[20, 20], rtol=0.05)
    assert asked.likeness([found.picture])[0] > 0.8  # rolled borders are not hers


def test_a_mask_hides_what_is_bad() -> None:
    photo = np.tensordot([0.4, 0.1, 0.3, 0.2], IMAGES, 1)
    mask = np.ones(photo.shape, np.bool_)
    mask[30:, 10:] = False
    asked = Photograph(np.where(mask, photo, 40.0), mask)
    found = asked.explained(Pictures.of(IMAGES))
    assert found.share > 0.98
    assert found.distance < 0.01
    assert asked.likeness([found.picture])[0] > 0.95


def test_a_gallerys_mask_is_everybodys() -> None:
    mask = np.ones((48, 36), np.bool_)
    mask[:, 20:] = False
    photo = np.where(mask, np.tensordot([0.4, 0.1, 0.3, 0.2], IMAGES, 1), 9.0)
    assert Photograph(photo, mask).explained(Pictures.of(IMAGES, mask)).share > 0.9999


@pytest.mark.parametrize("photo", [np.zeros((48, 36)), np.ones((48, 36))])
def test_where_there_is_nothing_nobody_explains_it(photo: np.ndarray) -> None:
    asked = Photograph(photo)
    found = asked.explained(Pictures.of(IMAGES))
    assert np.isfinite(found.surprise) and np.isfinite(found.picture).all()
    assert (found.share < 1e-3) and not asked.patterns.any()
    assert asked.likeness([found.picture]).tolist() == [0.0]


def test_dependent_pictures_explain_no_more() -> None:
    photo = Photograph(RNG.uniform(0.1, 1, (48, 36)))
    doubled = Pictures.of(np.concatenate([IMAGES, IMAGES]))
    assert len(doubled.light) == 4
    assert_allclose(photo.explained(doubled).share, photo.explained(Pictures.of(IMAGES)).share, rtol=1e-3)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Pictures.of(np.ones((48, 36))), r"images: expected shape \(k, h, w\), got an array"),
        (lambda: Pictures.of(np.zeros((2, 48, 36))), "images: expected a picture with something in it"),
        (lambda: Pictures.of(np.ones((2, 10, 36))), "photo: expected at least 24 pixels a side"),
        (
            lambda: Photograph(np.ones((48, 36))).explained(Pictures.of(np.ones((1, 48, 48)))),
            r"pictures: expected the photo's grid \(48, 36\), got \(48, 48\)",
        ),
    ],
)
def test_bad_input(call, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        call()
