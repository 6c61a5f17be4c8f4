"""Complex harmonics against scipy, their symmetry, and sums that must not change."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import sph_harm_y

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.complex import complex_harmonics, to_complex, to_real
from harmonicface.harmonics.indexing import count, degrees, modes


@pytest.mark.parametrize("order", [0, 3, 64])
def test_equal_to_scipy(random_directions, order: int) -> None:
    directions = random_directions(40)
    polar, azimuth = np.arccos(directions[:, 2]), np.arctan2(directions[:, 1], directions[:, 0])
    expected = sph_harm_y(degrees(order)[:, None], modes(order)[:, None], polar, azimuth)
    assert_allclose(complex_harmonics(directions, order), expected, rtol=0, atol=1e-11)


def test_the_papers_list_of_the_first_three_degrees(random_directions) -> None:
    x, y, z = (directions := random_directions(30)).T
    ours = dict(
        zip(zip(degrees(2).tolist(), modes(2).tolist(), strict=True), complex_harmonics(directions, 2), strict=True)
    )
    assert_allclose(ours[0, 0], np.sqrt(1 / (4 * np.pi)), rtol=1e-15)
    assert_allclose(ours[1, 0], np.sqrt(3 / (4 * np.pi)) * z, rtol=0, atol=1e-15)
    assert_allclose(ours[1, 1], -np.sqrt(3 / (8 * np.pi)) * (x + 1j * y), rtol=0, atol=1e-15)
    assert_allclose(ours[2, 0], np.sqrt(5 / (16 * np.pi)) * (3 * z**2 - 1), rtol=0, atol=1e-15)
    assert_allclose(ours[2, 1], -np.sqrt(15 / (8 * np.pi)) * (x + 1j * y) * z, rtol=0, atol=1e-15)
    assert_allclose(ours[2, 2], np.sqrt(15 / (32 * np.pi)) * (x + 1j * y) ** 2, rtol=0, atol=1e-15)
    for mode in (1, 2):
        assert_allclose(ours[2, -mode], (-1) ** mode * ours[2, mode].conj(), rtol=0, atol=1e-16)


def test_the_precision_that_comes_is_kept(random_directions) -> None:
    directions = random_directions(10)
    single = complex_harmonics(directions.astype(np.float32), 3)
    assert single.dtype == np.complex64
    assert_allclose(single, complex_harmonics(directions, 3), rtol=0, atol=1e-6)
    assert to_complex(np.ones(4, np.float32)).dtype == np.complex64
    assert to_real(np.array([1, 1j, 1, 1j], np.complex64)).dtype == np.float32


@pytest.mark.parametrize("channels", [(), (3,), (2, 2)])
def test_a_function_is_the_same_in_both(random_directions, channels: tuple[int, ...]) -> None:
    directions = random_directions(25)
    coefficients = np.random.default_rng(0).normal(size=(count(7), *channels))
    changed = to_complex(coefficients)
    real = np.tensordot(real_harmonics(directions, 7), coefficients, (0, 0))
    assert_allclose(np.tensordot(complex_harmonics(directions, 7), changed, (0, 0)), real, rtol=0, atol=1e-13)
    assert_allclose(to_real(changed), coefficients, rtol=0, atol=1e-15)
    assert_allclose((abs(changed) ** 2).sum(axis=0), (coefficients**2).sum(axis=0), rtol=1e-14)


def test_one_direction() -> None:
    assert complex_harmonics([0.0, 0.0, 1.0], 2).shape == (9,)


@pytest.mark.parametrize(
    ("coefficients", "message"),
    [
        ([0, 1, 0, 1], r"expected those of a real function, a_l-m = .*, got 2 apart"),
        ([1j, 0, 0, 0], "expected those of a real function"),
        ([1, np.nan, 0, 0], "expected finite numbers"),
        ([1, 2, 3], "expected .* of them .*, got 3"),
        (["one"], "expected complex numbers"),
    ],
)
def test_complex_coefficients_of_no_real_function(coefficients: list, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=f"coefficients: {message}"):
        to_real(coefficients)


@pytest.mark.parametrize("coefficients", [[1, 2], [np.inf], [1j]])
def test_real_coefficients_that_are_none(coefficients: list) -> None:
    with pytest.raises(HarmonicFaceError, match="coefficients: expected"):
        to_complex(coefficients)


@pytest.mark.parametrize("directions", [[[0, 0, 0]], [[np.nan, 0, 1]], "up"])
def test_no_directions(directions: object) -> None:
    with pytest.raises(HarmonicFaceError, match="directions: expected"):
        complex_harmonics(directions, 2)


def test_more_than_the_memory_holds() -> None:
    with pytest.raises(HarmonicFaceError, match=r"complex harmonics of order 3000: need .* GB of memory"):
        complex_harmonics(np.broadcast_to([0.0, 0.0, 1.0], (10**8, 3)), 3000)


def test_ragged_coefficients() -> None:
    with pytest.raises(HarmonicFaceError, match="coefficients: expected complex numbers, got list"):
        to_real([[1.0], [1.0, 2.0]])
