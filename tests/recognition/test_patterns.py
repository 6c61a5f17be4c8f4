"""Local patterns: against the formula by scipy, under changed light, moved, masked, and where there is nothing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.ndimage import gaussian_filter
from scipy.special import logsumexp

import harmonicface as hf
from harmonicface.datasets.yale_b import load_yale_b
from harmonicface.recognition.blocks import correlations
from harmonicface.recognition.patterns import SCALES, Template, patterns, similarity

FACES = np.random.default_rng(0).uniform(0.1, 1, (3, 48, 60))


def test_the_formula() -> None:
    photo = FACES[0]
    log = np.log(photo / np.partition(photo, 48 * 60 * 99 // 100, axis=None)[(48 * 60 - 1) * 99 // 100] + 0.008)
    for found, scale in zip(patterns(photo), SCALES, strict=True):
        detail = gaussian_filter(log, scale) - gaussian_filter(log, 1.5 * scale)
        energy = np.sqrt(gaussian_filter(detail**2, 3))
        squashed = np.tanh(detail / (energy + 0.1 * energy.mean() + 1e-4))
        assert_allclose(found, np.clip(squashed - gaussian_filter(squashed, 2), -1, 1), atol=2e-4)


@pytest.mark.parametrize("scale", [1e-20, 1e20])
def test_brightness_does_not_matter(scale: float) -> None:
    assert_allclose(patterns(scale * FACES[0]), patterns(FACES[0]), atol=1e-4)


def test_smooth_light_hardly_matters() -> None:
    ramp = np.linspace(0.1, 1, 60) * np.linspace(1, 0.3, 48)[:, None]
    people = [Template.of([patterns(face)]) for face in FACES]
    scores = similarity(patterns(FACES[1] * ramp), people).scores
    assert scores.argmax() == 1
    assert scores[1] > 0.9
    assert np.delete(scores, 1).max() < 0.4


@pytest.mark.parametrize(("right", "down"), [(0, 0), (3, -2), (-4, 4)])
def test_a_shift_is_found(right: int, down: int) -> None:
    people = [Template.of([patterns(face)]) for face in FACES]
    found = similarity(patterns(np.roll(FACES[2], (down, right), axis=(0, 1))), people)
    assert found.scores.argmax() == 2
    assert found.shifts[2].tolist() == [right, down]
    assert found.blocks == 20


def test_a_mask_hides_what_is_bad() -> None:
    mask = np.ones((48, 60), np.bool_)
    mask[20:, 30:] = False
    spoiled = np.where(mask, FACES[0], 40.0)
    found = patterns(spoiled, mask)
    assert not found[:, ~mask].any()
    assert_allclose(found[:, :12, :20], patterns(FACES[0])[:, :12, :20], atol=0.15)  # energies reach 12 pixels
    seen = similarity(found, [Template.of([patterns(face)]) for face in FACES])
    assert seen.blocks < 20
    assert seen.scores.argmax() == 0 and seen.scores[0] > 0.9


@pytest.mark.parametrize("photo", [np.zeros((48, 60)), np.ones((48, 60)), np.full((48, 60), 0.3), -np.ones((48, 60))])
def test_where_there_is_nothing_there_is_no_pattern(photo: np.ndarray) -> None:
    found = similarity(patterns(photo), [Template.of([patterns(FACES[0])])])
    assert (found.blocks, found.scores.tolist()) == (0, [0.0])


def test_the_score_takes_all_shifts_together() -> None:
    templates = [Template.of([patterns(face)]) for face in FACES[1:]]
    query = patterns(FACES[0])
    parts = correlations(query.sum(axis=0), [template.blocks for template in templates], 2)
    free, still = (0.01 * logsumexp(part.reshape(2, -1).astype(float) / 0.01, axis=1) for part in parts)
    found = similarity(query, templates, reach=2).scores
    assert_allclose(found, 0.75 * free + 0.25 * still, atol=1e-5)
    assert (found < 0.75 * (parts[0].max(axis=(1, 2)) + 0.05) + 0.25 * (parts[1].max(axis=(1, 2)) + 0.05)).all()


def test_a_template_is_the_mean_of_photographs_in_register() -> None:
    moved = [np.roll(FACES[0], shift, axis=(0, 1)) for shift in ((0, 0), (1, -2), (-3, 0))]
    template = Template.of([patterns(photo) for photo in moved])
    alone = patterns(FACES[0]).sum(axis=0)
    inner = np.s_[6:-6, 6:-6]
    assert_allclose(template.values[inner], alone[inner], atol=0.02)
    assert template.values.dtype == np.float16
    assert template.nbytes == 2 * 48 * 60 + 4 * 20 * 144


def test_small_photographs_have_a_small_grid() -> None:
    assert patterns(np.ones((24, 30))).shape == (3, 24, 30)
    assert patterns(np.ones((300, 250))).shape == (3, 96, 80)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: patterns(np.ones((20, 30))), "photo: expected at least 24 pixels a side"),
        (lambda: Template.of([]), "patterns: expected those of at least one photograph, got none"),
        (lambda: Template.of([np.ones((3, 24, 24)), np.ones((3, 24, 25))]), "patterns: expected one shape, got"),
        (lambda: similarity(patterns(FACES[0]), []), "templates: expected at least one, got none"),
        (
            lambda: similarity(patterns(FACES[0]), [Template.of([patterns(np.ones((24, 24)))])]),
            r"templates: expected the query's shape \(48, 60\), got \(24, 24\)",
        ),
        (lambda: similarity(patterns(FACES[0]), [], reach=-1), "reach: expected an integer of at least 0"),
    ],
)
def test_bad_input(call, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        call()


@pytest.mark.data
def test_one_frontal_photograph_of_yale_b_is_enough(data_dir: Path) -> None:
    faces = load_yale_b(data_dir / "yaleb")
    people = [Template.of([patterns(face.photographs[face.angles.argmin()])]) for face in faces]
    wrong = [
        (face.number, subset)
        for index, face in enumerate(faces)
        for photo, subset in zip(face.photographs[::2], face.subsets[::2], strict=True)
        if similarity(patterns(photo), people).scores.argmax() != index
    ]
    assert_array_equal(wrong, [])
