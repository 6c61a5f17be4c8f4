"""References without rounding, against numpy, scipy and closed forms where these do not round much."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.special import sph_harm_y_all

from harmonicface.bench.stability import exact, exact_harmonics
from harmonicface.harmonics.conventions import to_scipy

RANDOM = np.random.default_rng(0)
TALL, PHOTO = RANDOM.normal(size=(12, 4)), RANDOM.normal(size=12)


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=6))
def test_numbers_are_kept_to_the_last_bit(numbers: list[float]) -> None:
    assert exact.rationals(numbers).tolist() == [Fraction(number) for number in numbers]


@pytest.mark.parametrize("factor", [1.0, 2.0**-1000, 2.0**900])
def test_least_squares_of_any_scale(factor: float) -> None:
    expected = np.linalg.lstsq(TALL, PHOTO)[0]
    found = exact.longs(exact.least_squares(factor * TALL, factor * PHOTO))
    assert_allclose(found.astype(float), expected, rtol=1e-12)


def test_least_squares_of_least_norm() -> None:
    dependent = np.column_stack([np.round(TALL, 2), np.round(TALL, 2) @ [1.0, 2.0, 0.0, -1.0]])
    whole = np.round(128 * dependent)
    whole[:, 4] = whole[:, :4] @ [1.0, 2.0, 0.0, -1.0]
    found = exact.longs(exact.least_squares(whole, PHOTO)).astype(float)
    assert_allclose(found, np.linalg.pinv(whole) @ PHOTO, rtol=1e-10)
    assert exact.least_squares(np.zeros((3, 2)), np.ones(3)).tolist() == [0, 0]


def test_a_tenth_is_not_a_tenth() -> None:
    """What float64 cannot tell apart, fractions can."""
    near = np.array([[1.0, 1.0], [1.0, 1.0 + 2.0**-52]])
    assert exact.least_squares(near, [1.0, 1.0]).tolist() == [1, 0]
    assert exact.condition_of(near) == pytest.approx(4 * 2.0**52, rel=1e-9)


def test_sine_and_closeness() -> None:
    basis = np.linalg.qr(TALL)[0]
    rest = PHOTO - basis @ (basis.T @ PHOTO)
    assert exact.sine(TALL.T, PHOTO) == pytest.approx(np.linalg.norm(rest) / np.linalg.norm(PHOTO), rel=1e-12)
    assert exact.closeness(TALL.T, PHOTO) == pytest.approx(np.linalg.norm(basis.T @ PHOTO) ** 2, rel=1e-12)
    assert exact.sine(TALL.T, 2.0 * TALL[:, 1]) == 0


@pytest.mark.parametrize("shape", [(9, 4), (4, 9)])
def test_singular_values(shape: tuple[int, int]) -> None:
    matrix = RANDOM.normal(size=shape)
    assert_allclose(exact.singular_values(matrix).astype(float), np.linalg.svd(matrix)[1], rtol=1e-12)


def test_small_singular_values_keep_their_digits() -> None:
    hilbert = [[Fraction(1, i + j + 1) for j in range(8)] for i in range(8)]  # its eigenvalues are published
    values, _ = exact.eigen(np.array(hilbert, object), roots=False)
    assert float(values[0]) == pytest.approx(1.69593899692194, rel=1e-13)
    assert float(values[-1]) == pytest.approx(1.11153896637242e-10, rel=1e-13)


def test_eigenvectors_diagonalize() -> None:
    matrix = np.array([[2, 1, 0], [1, 3, 1], [0, 1, 4]], object)
    values, vectors = exact.eigen(matrix, roots=False)
    assert_allclose((vectors.T @ matrix @ vectors).astype(float), np.diag(values.astype(float)), atol=1e-15)


@pytest.mark.parametrize("degree", [0, 1, 2, 5, 20])
def test_harmonics_are_those_of_scipy(degree: int) -> None:
    direction = np.array([0.48, -0.6, 0.64])
    theirs = sph_harm_y_all(degree, degree, np.arccos(direction[2]), np.arctan2(direction[1], direction[0]))
    for mode in range(-degree, degree + 1):
        one = np.zeros((degree + 1) ** 2)
        one[degree * (degree + 1) + mode] = 1
        expected = np.tensordot(to_scipy(one), theirs, ([0, 1], [0, 1])).real
        assert float(exact_harmonics.harmonics(direction, degree)[degree + mode]) == pytest.approx(expected, abs=1e-13)


def test_the_clamped_cosine_is_that_of_the_papers() -> None:
    over_pi = (exact_harmonics.clamped_cosine(6) / exact_harmonics.PI).astype(float)
    assert_allclose(over_pi, [1, 2 / 3, 1 / 4, 0, -1 / 24, 0, 1 / 64], atol=1e-18)


def test_pictures_are_albedo_times_filter_times_harmonics() -> None:
    directions = np.array([[0.48, -0.6, 0.64], [0.0, 0.0, 1.0]])
    found = exact_harmonics.harmonic_pictures(directions, [0.5, 0.0], 1).astype(float)
    root = np.sqrt(3 / (4 * np.pi)) * 2 * np.pi / 3
    assert_allclose(found[:, 0], 0.5 * np.array([np.sqrt(np.pi) / 2, -0.6 * root, 0.64 * root, 0.48 * root]))
    assert not found[:, 1].any()
