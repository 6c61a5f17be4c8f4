"""Robust explanation: something hides a part of a face, and the fit is as if only the rest had been seen."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.datasets.yale_b import load_yale_b
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.patterns import Template, patterns, similarity
from harmonicface.recognition.robust import agreement, robust_fit, shows_light
from harmonicface.stereo.reconstruction import reconstruct

ADA, EMMY = hf.synthetic_people(2, 64, seed=3)
LAMP = hf.lights.directional([0.4, 0.2, 1.0])


def nine(surface: hf.Surface) -> np.ndarray:
    images = np.zeros((9, *surface.shape))
    images[:, surface.mask] = hf.harmonic_images(surface)
    return images


def plain(photo: np.ndarray, images: np.ndarray, seen: np.ndarray) -> np.ndarray:
    return np.tensordot(np.linalg.lstsq(images[:, seen].T, photo[seen], rcond=None)[0], images, 1)


def noisy(surface: hf.Surface) -> np.ndarray:
    clean = hf.render(surface, LAMP)
    return clean + 0.005 * np.random.default_rng(0).standard_normal(clean.shape) * surface.mask


HAT = np.zeros(ADA.shape, np.bool_)
HAT[:26] = True
STRIPES = 0.3 + 0.2 * np.sign(np.sin(np.arange(64) * 1.1))[None, :] * np.ones((64, 1))


@pytest.mark.parametrize(
    "hat", [np.full(ADA.shape, 0.5), STRIPES, np.zeros(ADA.shape)], ids=["grey", "striped", "black"]
)
def test_what_hides_a_face_is_left_out(hat: np.ndarray) -> None:
    photo, images = np.where(HAT, hat, noisy(ADA)), nine(ADA)
    found = robust_fit(photo, images, ADA.mask)
    assert found.left_out[HAT & ADA.mask].mean() > 0.95
    away = np.arange(64)[:, None] >= 26 + 4  # patterns are correlated over some pixels
    assert found.left_out[ADA.mask & away].mean() < 0.05
    assert not found.left_out[~ADA.mask].any()
    seen = ~HAT & ADA.mask
    truth = hf.render(ADA, LAMP)[seen]
    errors = [np.linalg.norm(fit[seen] - truth) for fit in (found.picture, plain(photo, images, ADA.mask))]
    assert errors[0] < 0.4 * errors[1]
    assert errors[0] < 1.5 * np.linalg.norm(plain(photo, images, seen)[seen] - truth)  # as if one knew where the hat is


def test_where_nothing_hides_it_is_least_squares_nearly() -> None:
    photo, images = noisy(ADA), nine(ADA)
    found, usual = robust_fit(photo, images, ADA.mask), plain(photo, images, ADA.mask)
    assert found.left_out[ADA.mask].mean() < 0.05
    assert np.linalg.norm((found.picture - usual)[ADA.mask]) < 0.02 * np.linalg.norm(usual[ADA.mask])
    assert_allclose(found.residual[ADA.mask], (photo - found.picture)[ADA.mask], atol=1e-6)
    assert_allclose(np.tensordot(found.coefficients, images, 1), found.picture, atol=1e-5)


def test_somebody_cannot_win_by_explaining_little() -> None:
    photo = np.where(HAT, STRIPES, noisy(ADA))
    right, wrong = (robust_fit(photo, nine(one), ADA.mask & EMMY.mask) for one in (ADA, EMMY))
    assert right.remaining > 1.5 * wrong.remaining
    assert right.penalized < wrong.penalized
    assert wrong.penalized > 0.45


def test_the_distance_is_over_what_remains() -> None:
    photo = np.where(HAT, 0.5, noisy(ADA))
    found = robust_fit(photo, nine(ADA), ADA.mask)
    kept = ADA.mask & ~found.left_out
    assert found.distance == pytest.approx(np.linalg.norm(found.residual[kept]) / np.linalg.norm(photo[kept]), rel=1e-4)
    assert found.remaining == pytest.approx((photo[kept] ** 2).sum() / (photo[ADA.mask] ** 2).sum(), rel=1e-4)
    assert found.penalized**2 == pytest.approx(found.remaining * found.distance**2 + (1 - found.remaining) / 4)


def test_burnt_out_skin_does_not_count() -> None:
    clean = hf.render(ADA, LAMP)
    burnt = clean > np.quantile(clean[ADA.mask], 0.8)
    photo = np.minimum(clean, clean[burnt].min())
    found = robust_fit(photo, nine(ADA), ADA.mask)
    assert not found.weights[photo == photo.max()].any()
    seen = ADA.mask & ~burnt
    assert np.linalg.norm((found.picture - clean)[ADA.mask]) < 0.08 * np.linalg.norm(clean[ADA.mask])
    assert found.left_out[seen].mean() < 0.1


@given(st.floats(-12, 12))
def test_the_unit_does_not_matter(power: float) -> None:
    photo, images = np.where(HAT, 0.5, noisy(ADA)), nine(ADA)
    one, other = (
        robust_fit(photo, images, ADA.mask, rounds=2),
        robust_fit(10**power * photo, images, ADA.mask, rounds=2),
    )
    assert_allclose(other.coefficients, 10**power * one.coefficients, rtol=1e-3, atol=1e-4 * 10**power)
    assert other.distance == pytest.approx(one.distance, abs=1e-4)


def test_a_large_photograph_is_weighed_on_the_grid() -> None:
    large = hf.synthetic_person(0, 160)
    photo = hf.render(large, LAMP)
    photo[:65] = 0.5
    found = robust_fit(photo, nine(large), large.mask)
    assert found.weights.shape == found.picture.shape == found.left_out.shape == (160, 160)
    assert found.left_out[:65][large.mask[:65]].mean() > 0.95
    assert found.left_out[72:][large.mask[72:]].mean() < 0.12


def test_agreement_is_a_local_correlation() -> None:
    one, other = (patterns(np.random.default_rng(seed).uniform(0.1, 1, (64, 64))) for seed in (0, 1))
    both = np.where(np.arange(64) < 32, one, other)
    found = agreement(one, both)
    assert found[:, :16].min() > 0.95 and np.abs(found[:, 48:]).max() < 0.5
    assert np.abs(agreement(one, np.zeros_like(one))).max() == 0


def test_a_few_pixels_that_are_not_burnt_out_show_no_light() -> None:
    photo, everywhere = np.ones((64, 64), np.float32), np.ones((64, 64), np.bool_)
    photo[10, 10] = photo[30, 40] = 0.9
    assert shows_light(photo, everywhere)
    large = np.ones((192, 192), np.float32)
    large[10, 10] = large[30, 40] = 0.9  # less than half of a pixel of the grid
    everywhere = np.ones((192, 192), np.bool_)
    assert not shows_light(large, everywhere) and not shows_light(large, ~everywhere)
    with pytest.raises(HarmonicFaceError, match="photo: expected some light in it that is not burnt out, got none"):
        robust_fit(large, np.ones((1, 192, 192)))


@pytest.mark.data
def test_people_of_yale_b_behind_blocks(data_dir: Path) -> None:
    faces = load_yale_b(data_dir / "yaleb", [1, 2, 3])
    frontal = [face.subsets == 1 for face in faces]
    templates, pictures = [], []
    for face, chosen in zip(faces, frontal, strict=True):
        templates.append(Template.of([patterns(photo) for photo in face.photographs[chosen]]))
        pictures.append(nine(reconstruct(face.photographs[chosen], face.lights[chosen])))
    covered, right = [], []
    rng = np.random.default_rng(0)
    for index, face in enumerate(faces):
        for photo in face.photographs[face.subsets == 3][::4]:
            top, left = rng.integers(0, 192 - 105), rng.integers(0, 168 - 92)
            query = photo.copy()
            query[top : top + 105, left : left + 92] = np.quantile(photo, 0.95) * rng.uniform(0.3, 1)  # 30 % of it
            shifts = 2 * similarity(patterns(query), templates).shifts
            moved = [np.roll(one, shift[::-1], axis=(1, 2)) for one, shift in zip(pictures, shifts, strict=True)]
            found = [robust_fit(query, one) for one in moved]
            right.append(np.argmin([fit.penalized for fit in found]) == index)
            covered.append(found[index].left_out[top : top + 105, left : left + 92].mean())
    assert len(right) == 9 and all(right)
    assert np.mean(covered) > 0.9


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"photo": np.ones((64, 64, 3))}, r"photo: expected shape \(h, w\), got"),
        ({"photo": np.full((64, 64), np.nan)}, "photo: expected finite numbers"),
        ({"photo": np.ones((32, 64))}, r"images: expected shape \(k, 32, 64\), got \(9, 64, 64\)"),
        ({"photo": np.zeros((64, 64))}, "photo: expected some light in it that is not burnt out, got none"),
        ({"photo": np.ones((64, 64))}, "photo: expected some light in it that is not burnt out, got none"),
        ({"images": np.ones((64, 64))}, r"images: expected shape \(k, 64, 64\), got \(64, 64\)"),
        ({"images": np.zeros((9, 64, 64))}, "images: expected something in them where the mask is, got zeros"),
        ({"mask": np.ones((2, 2), np.bool_)}, r"mask: expected a boolean mask of shape \(64, 64\)"),
        ({"rounds": 0}, "rounds: expected an integer of at least 1"),
        ({"photo": np.ones((8, 8)), "images": np.ones((1, 8, 8)), "mask": None}, "photo: expected at least 24 pixels"),
    ],
)
def test_bad_input(arguments: dict, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        robust_fit(**{"photo": noisy(ADA), "images": nine(ADA), "mask": ADA.mask, **arguments})


def test_bad_patterns() -> None:
    with pytest.raises(HarmonicFaceError, match=r"patterns: expected two of one shape \(s, h, w\)"):
        agreement(np.zeros((3, 8, 8), np.float32), np.zeros((3, 8, 9), np.float32))
