"""Components as a transformation of pictures: to numbers, back, and to their light."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

import harmonicface as hf
from harmonicface.appearance.principal import analytic_pca
from harmonicface.errors import HarmonicFaceError

FACE = hf.synthetic_person(0, size=24)
FOUND = analytic_pca(FACE, 6)
SEEN = np.stack([hf.render(FACE, hf.lights.natural(seed, size=8)) for seed in range(3)])


def test_pictures_are_the_components_where_the_surface_is() -> None:
    pictures = FOUND.pictures()
    assert pictures.shape == (6, 24, 24)
    assert_allclose(pictures[:, FACE.mask], FOUND.components)
    assert not pictures[:, ~FACE.mask].any()


def test_explained_is_the_share_of_the_total() -> None:
    assert_allclose(FOUND.explained * FOUND.total, FOUND.variances)
    assert (np.diff(FOUND.explained) <= 0).all() and FOUND.explained.sum() < 1


def test_numbers_of_pictures_and_back() -> None:
    scores = FOUND.transform(SEEN)
    assert scores.shape == (3, 6)
    expected = (SEEN[:, FACE.mask] - FOUND.mean) @ FOUND.components.T
    assert_allclose(scores, expected, rtol=1e-5, atol=1e-5)
    assert_allclose(FOUND.transform(SEEN[0]), scores[0], rtol=1e-5, atol=1e-5)
    assert_allclose(FOUND.transform(SEEN[:, FACE.mask]), scores, rtol=1e-5, atol=1e-5)
    nearest = FOUND.inverse_transform(scores)
    assert nearest.shape == (3, int(FACE.mask.sum()))
    assert_allclose(FOUND.transform(nearest), scores, atol=1e-4)
    assert np.linalg.norm(nearest - SEEN[:, FACE.mask]) < 0.15 * np.linalg.norm(SEEN)
    assert FOUND.inverse_transform(scores[0]).shape == (int(FACE.mask.sum()),)


@pytest.mark.parametrize("weighted", [False, True])
def test_no_other_combination_is_nearer(weighted: bool) -> None:
    weights = np.linspace(0.5, 2, 24 * 24).reshape(24, 24) if weighted else None
    found = analytic_pca(FACE, 6, weights=weights)
    each = np.ones(FACE.mask.sum()) if weights is None else weights[FACE.mask]
    asked = SEEN[0][FACE.mask] - found.mean
    expected = np.linalg.lstsq((found.components * np.sqrt(each)).T, asked * np.sqrt(each), rcond=None)[0]
    assert_allclose(found.transform(SEEN[0]), expected, atol=1e-4)


@pytest.mark.parametrize("centered", [False, True])
def test_the_light_of_numbers_makes_their_picture(centered: bool) -> None:
    found = analytic_pca(FACE, 6, centered=centered)
    scores = found.transform(SEEN[0])
    drawn = hf.render(FACE, found.light(scores), order=4)[FACE.mask]
    assert_allclose(drawn, found.inverse_transform(scores), atol=1e-4)


@pytest.mark.parametrize(
    "pictures", [np.ones(5), np.ones((24, 25)), np.ones((2, 3, 24, 24)), np.float64(1.0), np.ones((2, 0))]
)
def test_other_pictures_are_refused(pictures: NDArray[np.float64]) -> None:
    with pytest.raises(
        HarmonicFaceError, match=rf"pictures: expected {FACE.mask.sum()} masked pixels or pictures of shape \(24, 24\)"
    ):
        FOUND.transform(pictures)


def test_pixels_that_are_no_numbers_are_refused_in_the_mask_only() -> None:
    bad = SEEN[0].astype(np.float64)
    bad[~FACE.mask] = np.nan
    assert np.isfinite(FOUND.transform(bad)).all()
    bad[FACE.mask] = np.nan
    with pytest.raises(HarmonicFaceError, match="pictures: expected finite numbers"):
        FOUND.transform(bad)


def test_other_numbers_are_refused() -> None:
    for scores in (np.ones(5), np.ones((2, 7)), np.ones((1, 1, 6))):
        with pytest.raises(HarmonicFaceError, match="scores: expected 6 numbers a picture, got"):
            FOUND.inverse_transform(scores)
    with pytest.raises(HarmonicFaceError, match="scores: expected finite numbers"):
        FOUND.light(np.full(6, np.nan))
    with pytest.raises(HarmonicFaceError, match=r"scores: expected those of one picture, got shape \(3, 6\)"):
        FOUND.light(np.ones((3, 6)))
