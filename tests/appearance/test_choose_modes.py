"""Modes that a photograph determines: the F-test against its own definition, and against what noise does."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.stats import f as f_distribution

import harmonicface as hf
from harmonicface.appearance.choose_modes import determined_modes

RNG = np.random.default_rng(0)
IMAGES = RNG.normal(size=(4, 60)) * np.array([[100.0], [10.0], [1.0], [0.1]])
LIGHT = np.array([0.3, -0.5, 0.2, 0.4])


def test_without_noise_it_is_least_squares() -> None:
    found = determined_modes(LIGHT @ IMAGES, IMAGES)
    assert found.kept.all()
    assert_allclose(found.coefficients, LIGHT, rtol=0, atol=1e-10)
    assert_allclose(found.fit, LIGHT @ IMAGES, rtol=0, atol=1e-10)


def test_statistics_are_those_of_nested_models() -> None:
    photo = LIGHT @ IMAGES + 2 * RNG.normal(size=60)
    found = determined_modes(photo, IMAGES)
    rows = np.linalg.svd(IMAGES, full_matrices=False)[2]
    everything = ((photo - rows.T @ (rows @ photo)) ** 2).sum()
    for mode in range(4):
        fewer = np.delete(rows, mode, axis=0)
        without = ((photo - fewer.T @ (fewer @ photo)) ** 2).sum()
        assert found.statistics[mode] == pytest.approx((without - everything) / (everything / 56))
    assert (found.kept == (found.statistics > f_distribution.isf(0.05, 1, 56))).all()


def test_noise_alone_passes_as_often_as_the_level_says() -> None:
    kept = [determined_modes(RNG.normal(size=60), IMAGES, level=0.2).kept for _ in range(500)]
    assert np.mean(kept) == pytest.approx(0.2, abs=0.03)


def test_a_mode_that_noise_drowns_is_dropped_and_the_light_gains() -> None:
    worse = 0
    for _ in range(50):
        photo = LIGHT @ IMAGES + 5 * RNG.normal(size=60)
        found = determined_modes(photo, IMAGES)
        full = np.linalg.lstsq(IMAGES.T, photo, rcond=None)[0]
        worse += np.linalg.norm(found.coefficients - LIGHT) >= np.linalg.norm(full - LIGHT)
        assert not found.kept.all()
    assert worse < 10


def test_few_pixels_determine_fewer_modes_of_a_face() -> None:
    face = hf.synthetic_person(0, 48)
    images, photo = hf.harmonic_images(face), hf.render(face, hf.lights.natural(0))[face.mask]
    noisy = photo + 0.1 * photo.mean() * RNG.normal(size=len(photo))
    few = RNG.choice(len(photo), 30, replace=False)
    kept = [int(determined_modes(noisy[part], images[:, part]).kept.sum()) for part in (slice(None), few)]
    assert kept[1] < kept[0] <= 9


def test_standard_deviations_are_those_of_repeated_photographs() -> None:
    photos = [LIGHT @ IMAGES + 0.001 * RNG.normal(size=60) for _ in range(400)]
    found = [determined_modes(photo, IMAGES, noise=0.001) for photo in photos]
    assert_allclose(np.std([each.coefficients for each in found], axis=0), found[0].std, rtol=0.15)
    assert found[0].noise == 0.001


def test_dependent_images_are_counted_once() -> None:
    twice = np.concatenate([IMAGES, IMAGES[:1]]).astype(np.float32)
    found = determined_modes(LIGHT @ IMAGES, twice)
    assert found.modes.shape == (4, 5)
    assert_allclose(found.coefficients @ twice, LIGHT @ IMAGES, rtol=0, atol=1e-3)


@pytest.mark.parametrize(
    ("photo", "images", "options", "message"),
    [
        (np.ones(60), np.ones(60), {}, "images: expected shape"),
        (np.ones(60), np.full((1, 60), np.nan), {}, "images: expected finite"),
        (np.ones(60), np.zeros((2, 60)), {}, "images: expected one with something in it"),
        (np.ones(9), IMAGES, {}, "photo: expected 60 pixels"),
        (np.full(60, np.inf), IMAGES, {}, "photo: expected finite"),
        (np.ones(60), IMAGES, {"noise": 0}, "noise: expected"),
        (np.ones(60), IMAGES, {"level": 1.0}, "level: expected a number above 0 and below 1"),
        (np.ones(60), IMAGES, {"level": 2.0}, "level: expected a number from 0 to 1"),
        (np.ones(4), IMAGES[:, :4], {}, "noise: expected a number, for 4 pixels tell nothing beside 4 modes"),
    ],
)
def test_bad_input(photo: np.ndarray, images: np.ndarray, options: dict[str, float], message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        determined_modes(photo, images, **options)
