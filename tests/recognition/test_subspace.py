"""Subspaces against least squares and scipy's spans; dependent pictures, bad scales, masks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.linalg import orth, subspace_angles

import harmonicface as hf
from harmonicface.recognition.subspace import Subspace, unit_photo

RNG = np.random.default_rng(0)
PICTURES = RNG.normal(size=(9, 60)) * np.linspace(1, 0.1, 9)[:, None]
PHOTO = RNG.normal(size=60)
GOOD = RNG.uniform(size=60) < 0.6


def least_squares(pictures: np.ndarray, photo: np.ndarray) -> tuple[np.ndarray, float]:
    """Coefficients of the best combination, and the share of the photograph's length that it leaves."""
    coefficients = np.linalg.lstsq(pictures.T, photo, rcond=None)[0]
    return coefficients, float(np.linalg.norm(photo - coefficients @ pictures) / np.linalg.norm(photo))


def test_rows_are_orthonormal_and_span_what_scipy_spans() -> None:
    rows = Subspace.of(PICTURES).rows
    assert (rows.dtype, rows.shape, rows.flags.c_contiguous) == (np.float32, (9, 60), True)
    assert_allclose(rows.astype(np.float64) @ rows.T, np.eye(9), rtol=0, atol=1e-6)
    assert subspace_angles(orth(PICTURES.T), rows.T.astype(np.float64)).max() < 1e-6


def test_distance_is_the_residual_of_least_squares() -> None:
    assert_allclose(Subspace.of(PICTURES).distance(PHOTO), least_squares(PICTURES, PHOTO)[1], rtol=1e-6)


def test_nearest_and_coefficients_are_those_of_least_squares() -> None:
    subspace = Subspace.of(PICTURES)
    coefficients = least_squares(PICTURES, PHOTO)[0]
    assert_allclose(subspace.coefficients(PHOTO), coefficients, rtol=0, atol=1e-5)
    assert_allclose(subspace.nearest(PHOTO), coefficients @ PICTURES, rtol=0, atol=1e-6)


@pytest.mark.parametrize("size", [1.0, 1e-2, 1e-4])
def test_small_distances_keep_their_digits(size: float) -> None:
    inside = RNG.normal(size=9) @ PICTURES
    outside = PHOTO - least_squares(PICTURES, PHOTO)[0] @ PICTURES
    photo = inside / np.linalg.norm(inside) + size * outside / np.linalg.norm(outside)
    assert_allclose(Subspace.of(PICTURES).distance(photo), size / np.hypot(1, size), rtol=0, atol=2e-7)


def test_a_picture_of_the_span_is_at_no_distance() -> None:
    subspace = Subspace.of(PICTURES)
    for coefficients in RNG.normal(size=(20, 9)):
        assert subspace.distance(coefficients @ PICTURES) < 3e-7


def test_what_is_orthogonal_is_at_distance_one() -> None:
    outside = PHOTO - least_squares(PICTURES, PHOTO)[0] @ PICTURES
    assert_allclose(Subspace.of(PICTURES).distance(outside), 1, rtol=0, atol=1e-12)
    assert Subspace.of(PICTURES).distance(outside) <= 1


def test_the_light_comes_back() -> None:
    surface = hf.synthetic_person(3, size=32)
    light = hf.lights.natural(1, size=8)
    subspace = Subspace.of(hf.harmonic_images(surface))
    recovered = subspace.coefficients(hf.render(surface, light, order=2)[surface.mask])
    expected = light.coefficients(2)
    error = np.linalg.norm(recovered - expected) / np.linalg.norm(expected)
    assert error < 2 * np.finfo(np.float32).eps * subspace.condition * np.sqrt(9)


def test_condition_is_that_of_the_pictures() -> None:
    assert_allclose(Subspace.of(PICTURES).condition, np.linalg.cond(PICTURES), rtol=1e-10)
    assert Subspace.of(PICTURES[:1]).condition == 1.0


def wall(dtype: type) -> hf.Surface:
    normals = np.tile(np.array([0.6, 0.0, 0.8]), (5, 4, 1))
    return hf.Surface(normals.astype(dtype), RNG.uniform(0.2, 1, (5, 4)).astype(dtype))


def cylinder(dtype: type) -> hf.Surface:
    angles = np.linspace(-1.4, 1.4, 30)[None, :] * np.ones((4, 1))
    normals = np.stack([np.sin(angles), np.zeros_like(angles), np.cos(angles)], axis=-1)
    return hf.Surface(normals.astype(dtype), RNG.uniform(0.2, 1, (4, 30)).astype(dtype))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize(("make", "rank"), [(wall, 1), (cylinder, 5)], ids=["wall", "cylinder"])
def test_rank_of_dependent_pictures(make, rank: int, dtype: type) -> None:
    # of a cylinder's normals 1, z, x, xz and x^2 - y^2 are independent, 3z^2 - 1 is a sum of them, y is 0
    surface = make(dtype)
    subspace = Subspace.of(hf.harmonic_images(surface))
    assert subspace.rank == rank
    light = hf.lights.natural(0, size=6)
    photo = hf.render(surface, light, order=2)[surface.mask]
    assert subspace.distance(photo) < 1e-6
    assert_allclose(subspace.coefficients(photo) @ hf.harmonic_images(surface), photo, rtol=0, atol=1e-5)


@pytest.mark.parametrize(
    ("dtype", "exponent"), [(np.float64, 12), (np.float64, 200), (np.float32, 12), (np.float32, 30)]
)
@pytest.mark.parametrize("sign", [1, -1])
def test_scale_does_not_matter(dtype: type, exponent: int, sign: int) -> None:
    scale = 10.0 ** (sign * exponent)
    scaled = Subspace.of((PICTURES * scale).astype(dtype))
    assert scaled.rank == 9
    photo = (PHOTO * scale).astype(dtype)
    coefficients, residual = least_squares(PICTURES, PHOTO)
    assert_allclose(scaled.distance(photo), residual, rtol=1e-5)
    assert_allclose(scaled.coefficients(photo), coefficients, rtol=0, atol=1e-4)
    dependent = np.vstack([PICTURES[:3], PICTURES[:3] @ np.diag(np.ones(60)) * 2]) * scale
    assert Subspace.of(dependent.astype(dtype)).rank == 3


@settings(deadline=None, max_examples=40)
@given(st.integers(1, 9), st.integers(0, 2**32 - 1), st.sampled_from([np.float32, np.float64]))
def test_the_rank_of_a_product_is_its_inner_size(rank: int, seed: int, dtype: type) -> None:
    rng = np.random.default_rng(seed)
    left = np.linalg.qr(rng.normal(size=(9, 9)))[0][:, :rank]  # well conditioned
    subspace = Subspace.of((left @ np.linalg.qr(rng.normal(size=(40, rank)))[0].T).astype(dtype))
    assert subspace.rank == rank


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 2**32 - 1), st.floats(1e-6, 1e6))
def test_brightness_leaves_the_distance_alone(seed: int, factor: float) -> None:
    subspace, photo = Subspace.of(PICTURES), np.random.default_rng(seed).normal(size=60)
    assert_allclose(subspace.distance(factor * photo), subspace.distance(photo), rtol=1e-12, atol=1e-14)
    assert 0 <= subspace.distance(photo) <= 1


def test_the_strongest_directions_are_kept() -> None:
    few = Subspace.of(PICTURES, most=3)
    strongest = np.linalg.svd(PICTURES, full_matrices=False)[2][:3]
    assert few.rank == 3
    assert subspace_angles(strongest.T, few.rows.T.astype(np.float64)).max() < 1e-6
    assert Subspace.of(PICTURES, most=99).rank == 9


@pytest.mark.parametrize("pictures", [PICTURES, PICTURES.astype(np.float32)], ids=["double", "single"])
def test_behind_a_mask_as_if_made_there(pictures: np.ndarray) -> None:
    seen, made = Subspace.of(pictures).restrict(GOOD), Subspace.of(pictures[:, GOOD])
    assert seen.rank == made.rank == 9
    assert subspace_angles(seen.rows.T.astype(np.float64), made.rows.T.astype(np.float64)).max() < 3e-6
    assert_allclose(seen.distance(PHOTO[GOOD]), least_squares(PICTURES[:, GOOD], PHOTO[GOOD])[1], rtol=1e-5)
    expected = least_squares(PICTURES[:, GOOD], PHOTO[GOOD])[0]
    assert_allclose(seen.coefficients(PHOTO[GOOD]), expected, rtol=0, atol=1e-3)


def test_few_pixels_behind_a_mask_have_a_smaller_rank() -> None:
    few = np.zeros(60, np.bool_)
    few[[3, 30, 55]] = True
    seen = Subspace.of(PICTURES).restrict(few)
    assert seen.rank == 3
    assert seen.distance(PHOTO[few]) < 1e-6


@pytest.mark.parametrize(
    ("images", "most", "message"),
    [
        (np.zeros((3, 5)), None, "images: expected a picture with something in it, got 3 of zeros"),
        (np.ones(5), None, r"images: expected shape \(k, p\), got an array of shape \(5,\)"),
        (1.0, None, r"images: expected shape \(k, p\), got an array of shape \(\)"),
        (np.ones((3, 0)), None, r"images: expected shape \(k, p\), got an array of shape \(3, 0\)"),
        ([[1.0, np.nan]], None, "images: expected finite numbers"),
        (PICTURES, 0, "most: expected an integer of at least 1, got int 0"),
        (PICTURES, -2, "most: expected an integer of at least 1, got int -2"),
    ],
)
def test_pictures_that_span_nothing(images: np.ndarray, most: int | None, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        Subspace.of(images, most)


@pytest.mark.parametrize("method", ["distance", "nearest", "coefficients"])
@pytest.mark.parametrize(
    ("photo", "message"),
    [
        (PHOTO[:-1], r"photo: expected 60 pixels, got an array of shape \(59,\)"),
        (PHOTO[None], r"photo: expected 60 pixels, got an array of shape \(1, 60\)"),
        (PHOTO * np.inf, "photo: expected finite numbers"),
    ],
)
def test_another_photograph(method: str, photo: np.ndarray, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        getattr(Subspace.of(PICTURES), method)(photo)


def test_a_black_photograph_has_no_angle() -> None:
    for function in (Subspace.of(PICTURES).distance, lambda photo: unit_photo(photo, 60)):
        with pytest.raises(hf.HarmonicFaceError, match="photo: expected some light in it, got 60 pixels that are all"):
            function(np.zeros(60))


@pytest.mark.parametrize(
    ("good", "message"),
    [
        (GOOD[:-1], r"good: expected booleans of shape \(60,\), got an array of shape \(59,\) and type bool"),
        (np.arange(60), r"good: expected booleans of shape \(60,\), got an array of shape \(60,\) and type int64"),
        (np.zeros(60, np.bool_), r"images: expected shape \(k, p\), got an array of shape \(9, 0\)"),
    ],
)
def test_a_mask_that_is_none(good: np.ndarray, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        Subspace.of(PICTURES).restrict(good)


def test_a_mask_that_leaves_nothing_of_the_pictures() -> None:
    half = np.zeros((2, 60))
    half[:, :30] = RNG.normal(size=(2, 30))
    with pytest.raises(hf.HarmonicFaceError, match="images: expected a picture with something in it"):
        Subspace.of(half).restrict(np.arange(60) >= 30)


def test_pictures_too_dark_for_coefficients_are_refused() -> None:
    with pytest.raises(hf.HarmonicFaceError, match="images: expected brighter pictures, got values of at most 1e-310"):
        Subspace.of(1e-310 * np.eye(2))
    span = Subspace.of(1e-307 * np.eye(2))
    assert span.distance([1.0, 1.0]) == 0
    with pytest.raises(hf.HarmonicFaceError, match="coefficients beyond any number"):
        span.coefficients([100.0, 1.0])
