"""Fourier series against the integrals that they stand for, there and back, and turned."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import quad

from harmonicface.errors import HarmonicFaceError
from harmonicface.reflectance.flatland_series import (
    circle_angles,
    fourier_basis,
    fourier_coefficients,
    fourier_series,
    rotate_flat,
)

ROOT = np.sqrt(2 * np.pi)


def light(angle: np.ndarray) -> np.ndarray:
    return 1 + 0.6 * np.cos(angle - 0.4) + 0.3 * np.sin(3 * angle) - 0.2 * np.cos(5 * angle)


def test_the_basis_is_orthonormal() -> None:
    basis = fourier_basis(circle_angles(64), 10)
    assert_allclose(basis.conj() @ basis.T * 2 * np.pi / 64, np.eye(21), rtol=0, atol=1e-14)
    assert_allclose(fourier_basis(0.7, 2), np.exp(1j * np.arange(-2, 3) * 0.7) / ROOT, rtol=1e-15)
    assert_allclose(fourier_basis(0.7, 3)[::-1], fourier_basis(0.7, 3).conj(), rtol=1e-15)  # F_l^* = F_-l


def test_coefficients_are_the_integral() -> None:
    found = fourier_coefficients(light(circle_angles(32)), 5)
    for degree in range(-5, 6):
        parts = [
            quad(lambda a, d=degree, f=wave: float(light(a) * f(d * a)) / ROOT, -np.pi, np.pi, epsabs=1e-12)[0]
            for wave in (np.cos, np.sin)
        ]
        assert_allclose(found[degree + 5], parts[0] - 1j * parts[1], rtol=0, atol=1e-12)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 12), st.integers(0, 2**32 - 1))
def test_there_and_back(order: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    coefficients = random.normal(size=(2 * order + 1, 2)) + 1j * random.normal(size=(2 * order + 1, 2))
    back = fourier_coefficients(fourier_series(coefficients, circle_angles(2 * order + 1)), order)
    assert_allclose(back, coefficients, rtol=0, atol=1e-12)


def test_rotation_is_the_light_seen_from_the_normal() -> None:
    coefficients = fourier_coefficients(light(circle_angles(32)), 5)
    angles = np.linspace(-3, 3, 11)
    assert_allclose(fourier_series(rotate_flat(coefficients, 0.8), angles), light(angles + 0.8), rtol=0, atol=1e-13)
    twice = rotate_flat(rotate_flat(coefficients, 0.8), -2.0)
    assert_allclose(twice, rotate_flat(coefficients, -1.2), rtol=0, atol=1e-14)


def test_errors() -> None:
    with pytest.raises(HarmonicFaceError, match="count: expected an integer of at least 1"):
        circle_angles(0)
    with pytest.raises(HarmonicFaceError, match="angles: expected finite numbers"):
        fourier_basis([np.nan], 2)
    with pytest.raises(HarmonicFaceError, match="order: expected an integer of at least 0"):
        fourier_basis([0.0], -1)
    with pytest.raises(HarmonicFaceError, match="samples: expected at least 5 of them"):
        fourier_coefficients(np.ones(4), 2)
    with pytest.raises(HarmonicFaceError, match=r"coefficients: expected 2 order \+ 1 degrees"):
        fourier_series(np.ones(4), 0.0)
    with pytest.raises(HarmonicFaceError, match=r"coefficients: expected 2 order \+ 1 degrees"):
        rotate_flat(np.ones(4), 0.0)


def test_series_beyond_the_memory() -> None:
    with pytest.raises(HarmonicFaceError, match=r"1000000000000 angles: need 1.6e\+04 GB of memory"):
        circle_angles(10**12)
    with pytest.raises(HarmonicFaceError, match=r"waves of order 1000000000000 at 2 angles: need .* GB of memory"):
        fourier_basis([0.0, 1.0], 10**12)


def test_a_ragged_series() -> None:
    with pytest.raises(HarmonicFaceError, match="coefficients: expected complex numbers, got list"):
        rotate_flat([[1.0], [1.0, 2.0]], 0.0)
