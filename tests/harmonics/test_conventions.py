"""Converters between conventions against the libraries that have them, and round trips."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import sphericart
from numpy.testing import assert_allclose, assert_array_equal
from scipy.special import sph_harm_y_all

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics import conventions
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import count, index, modes


@pytest.fixture
def coefficients() -> np.ndarray:
    return np.random.default_rng(0).normal(size=count(6))


def test_scipys_harmonics_with_scipys_coefficients(random_directions, coefficients: np.ndarray) -> None:
    directions = random_directions(30)
    polar, azimuth = np.arccos(directions[:, 2]), np.arctan2(directions[:, 1], directions[:, 0])
    theirs = sph_harm_y_all(6, 6, polar, azimuth)
    value = np.tensordot(conventions.to_scipy(coefficients), theirs, ([0, 1], [0, 1]))
    assert_allclose(value, coefficients @ real_harmonics(directions, 6), rtol=0, atol=1e-13)
    assert_allclose(conventions.from_scipy(conventions.to_scipy(coefficients)), coefficients, rtol=0, atol=1e-15)


def test_sphericarts_harmonics(random_directions) -> None:
    directions = random_directions(30)
    theirs = sphericart.SphericalHarmonics(6).compute(directions)
    assert_allclose(conventions.to_sphericart(real_harmonics(directions, 6)), theirs, rtol=0, atol=1e-13)
    ours = conventions.from_sphericart(theirs)
    assert ours.flags.c_contiguous
    assert_allclose(ours, real_harmonics(directions, 6), rtol=0, atol=1e-13)


def test_four_pi_normalized_harmonics_have_a_mean_square_of_one(coefficients: np.ndarray) -> None:
    assert_allclose(conventions.to_four_pi([np.sqrt(4 * np.pi)]), [1], rtol=1e-15)
    converted = conventions.to_four_pi(coefficients)
    assert_allclose((converted**2).sum(), (coefficients**2).sum() / (4 * np.pi), rtol=1e-14)  # the mean square
    assert_allclose(conventions.from_four_pi(converted), coefficients, rtol=1e-15)


def test_the_phase_is_a_sign_of_odd_modes(coefficients: np.ndarray) -> None:
    switched = conventions.switch_condon_shortley(coefficients)
    assert_array_equal(switched, coefficients * (-1.0) ** modes(6))
    assert_array_equal(conventions.switch_condon_shortley(switched), coefficients)
    assert switched[index(3, -3)] == -coefficients[index(3, -3)]


@pytest.mark.parametrize(
    "function",
    [
        conventions.switch_condon_shortley,
        conventions.to_four_pi,
        conventions.from_four_pi,
        lambda c: conventions.from_scipy(conventions.to_scipy(c)),
        lambda c: conventions.from_sphericart(conventions.to_sphericart(c)),
    ],
)
def test_channels_and_types_pass_through(function: Callable[[np.ndarray], np.ndarray]) -> None:
    coloured = np.random.default_rng(1).normal(size=(9, 3)).astype(np.float32)
    answer = function(coloured)
    assert answer.shape == (9, 3)
    assert answer.dtype == np.float32
    for channel in range(3):
        assert_allclose(answer[:, channel], function(coloured[:, channel]), rtol=1e-6)


@pytest.mark.parametrize(
    "function",
    [
        conventions.switch_condon_shortley,
        conventions.to_four_pi,
        conventions.from_four_pi,
        conventions.to_scipy,
        conventions.to_sphericart,
    ],
)
@pytest.mark.parametrize("bad", [np.ones(5), [np.nan], "light"])
def test_coefficients_that_are_none(function: Callable[[object], object], bad: object) -> None:
    with pytest.raises(HarmonicFaceError, match=r"(coefficients|harmonics): expected"):
        function(bad)


def test_harmonics_that_are_not_sphericarts() -> None:
    with pytest.raises(HarmonicFaceError, match=r"expected .* of them .*, got 5"):
        conventions.from_sphericart(np.ones((9, 5)))
    with pytest.raises(HarmonicFaceError, match="harmonics: expected finite numbers"):
        conventions.from_sphericart(np.full((2, 9), np.nan))


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (np.ones(9), r"expected shape \(order \+ 1, 2 order \+ 1, ...\), got \(9,\)"),
        (np.ones((3, 4)), r"expected shape \(order \+ 1, 2 order \+ 1, ...\), got \(3, 4\)"),
        (np.ones((2, 3)), r"expected zeros for \|m\| > l, got 1"),
        (np.array([[0, 0, 0], [0, 1, 1]]), "expected those of a real function"),
        (np.array([[np.nan, 0, 0], [0, 0, 0]]), "expected finite numbers"),
    ],
)
def test_arrays_that_are_not_scipys(given: np.ndarray, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=f"coefficients: {message}"):
        conventions.from_scipy(given)


def test_ragged_coefficients_of_scipy() -> None:
    with pytest.raises(HarmonicFaceError, match="coefficients: expected complex numbers, got list"):
        conventions.from_scipy([[1.0], [1.0, 2.0]])
