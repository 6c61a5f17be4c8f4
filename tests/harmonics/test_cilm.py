"""The conventions of pyshtools, against the formulas of its documentation and, where it is installed, itself."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import lpmv

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.cilm import NORMALIZATIONS, from_pyshtools, to_pyshtools
from harmonicface.harmonics.indexing import count

CASES = [(normalization, phase) for normalization in NORMALIZATIONS for phase in (1, -1)]


def documented_sum(cilm: np.ndarray, normalization: str, phase: int, directions: np.ndarray) -> np.ndarray:
    """The sum over P_lm cos(m phi), P_lm sin(m phi), each factor as documented (scipy's P_lm carries the phase)."""
    azimuth = np.arctan2(directions[:, 1], directions[:, 0])
    total = np.zeros(len(directions))
    for l in range(cilm.shape[1]):  # noqa: E741
        for m in range(l + 1):
            twice = 1 if m == 0 else 2
            schmidt = math.sqrt(twice * math.factorial(l - m) / math.factorial(l + m))
            factor = {
                "4pi": schmidt * math.sqrt(2 * l + 1),
                "ortho": schmidt * math.sqrt((2 * l + 1) / (4 * math.pi)),
                "schmidt": schmidt,
                "unnorm": 1.0,
            }[normalization]
            legendre = (-1) ** m * lpmv(m, l, directions[:, 2]) * phase**m
            waves = cilm[0, l, m] * np.cos(m * azimuth) + cilm[1, l, m] * np.sin(m * azimuth)
            total += factor * legendre * waves
    return total


@pytest.mark.parametrize(("normalization", "phase"), CASES)
def test_the_documented_sum_is_the_same_function(random_directions, normalization: str, phase: int) -> None:
    directions = random_directions(20)
    coefficients = np.random.default_rng(0).normal(size=count(6))
    cilm = to_pyshtools(coefficients, normalization, phase)
    assert cilm.shape == (2, 7, 7)
    value = documented_sum(cilm, normalization, phase, directions)
    assert_allclose(value, coefficients @ real_harmonics(directions, 6), rtol=0, atol=1e-12)
    assert_allclose(from_pyshtools(cilm, normalization, phase), coefficients, rtol=1e-14)


@pytest.mark.parametrize(("normalization", "phase"), CASES)
def test_pyshtools_itself(random_directions, normalization: str, phase: int) -> None:
    pyshtools = pytest.importorskip(
        "pyshtools", reason="pyshtools is not installed; its documented sum is tested above"
    )
    directions = random_directions(20)
    coefficients = np.random.default_rng(0).normal(size=count(6))
    cilm = to_pyshtools(coefficients, normalization, phase)
    theirs = pyshtools.SHCoeffs.from_array(cilm, normalization=normalization, csphase=phase)
    latitude, longitude = np.arcsin(directions[:, 2]), np.arctan2(directions[:, 1], directions[:, 0])
    value = theirs.expand(lat=latitude, lon=longitude, degrees=False)
    assert_allclose(value, coefficients @ real_harmonics(directions, 6), rtol=0, atol=1e-11)


def test_channels_and_types_pass_through() -> None:
    coloured = np.random.default_rng(1).normal(size=(9, 3)).astype(np.float32)
    cilm = to_pyshtools(coloured)
    assert cilm.shape == (2, 3, 3, 3)
    assert cilm.dtype == from_pyshtools(cilm).dtype == np.float32
    assert_allclose(from_pyshtools(cilm), coloured, rtol=1e-6)


def test_unnormalized_harmonics_up_to_where_they_overflow() -> None:
    coefficients = np.ones(count(80))
    cilm = to_pyshtools(coefficients, "unnorm")
    assert np.isfinite(cilm).all()
    assert_allclose(from_pyshtools(cilm, "unnorm"), coefficients, rtol=1e-13)
    with pytest.raises(HarmonicFaceError, match="expected order 80 at most for 'unnorm', got 81"):
        to_pyshtools(np.ones(count(81)), "unnorm")


@pytest.mark.parametrize("bad", [np.ones(3), [np.inf], "sea"])
def test_coefficients_that_are_none(bad: object) -> None:
    with pytest.raises(HarmonicFaceError, match="coefficients: expected"):
        to_pyshtools(bad)


@pytest.mark.parametrize(
    ("cilm", "message"),
    [
        (np.zeros((2, 3)), r"cilm: expected shape \(2, order \+ 1, order \+ 1, ...\), got \(2, 3\)"),
        (np.zeros((1, 3, 3)), "cilm: expected shape"),
        (np.zeros((2, 3, 4)), "cilm: expected shape"),
        (np.zeros((2, 0, 0)), "cilm: expected shape"),
        (np.full((2, 1, 1), np.nan), "cilm: expected finite numbers"),
        (np.ones((2, 1, 1)), "coefficients: expected zeros for m > l, and for the sine of m = 0, got 1"),
        (np.array([[[0, 5], [0, 0]], [[0, 0], [0, 0]]]), "coefficients: expected zeros for m > l"),
    ],
)
def test_arrays_that_are_not_pyshtools(cilm: np.ndarray, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        from_pyshtools(cilm)


def test_conventions_that_are_none() -> None:
    with pytest.raises(
        HarmonicFaceError, match="normalization: expected one of 4pi, ortho, schmidt, unnorm, got 'sn3d'"
    ):
        to_pyshtools(np.ones(4), "sn3d")
    with pytest.raises(HarmonicFaceError, match="csphase: expected 1 or -1, got 0"):
        from_pyshtools(np.zeros((2, 2, 2)), csphase=0)


def test_numbers_that_leave_their_type() -> None:
    cilm = np.zeros((2, 31, 31), np.float32)
    cilm[0, 30, 30] = 1.0
    with pytest.raises(
        HarmonicFaceError, match="coefficients: expected ones that fit float32 when scaled, got an over"
    ):
        from_pyshtools(cilm, "unnorm")
    with pytest.raises(
        HarmonicFaceError, match="coefficients: expected ones that fit float64 when scaled, got an over"
    ):
        to_pyshtools(np.full(121, 1.7e308), "schmidt")
