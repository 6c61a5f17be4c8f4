"""The bounds hold for every vector in the ball, the sharp one is the maximum itself."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from harmonicface.gallery.search import bound
from harmonicface.recognition.subspace import Subspace, unit_photo


def largest(b: np.ndarray, squares: np.ndarray, rho: float) -> float:
    """Return max |b + S t|^2 over |t| <= rho, by the secular equation in float64."""
    most = squares.max()
    if most == 0:
        return float(b @ b)

    def excess(multiplier: float) -> float:
        return float(np.sum(b**2 * squares / (multiplier - squares) ** 2) - rho**2)

    least = most * (1 + 1e-13)
    if excess(least) > 0:
        multiplier = brentq(excess, least, most + 1e3 * np.linalg.norm(b) / rho + 1, xtol=1e-15)
        t = b * np.sqrt(squares) / (multiplier - squares)
    else:  # the hard case: what the other axes leave of the ball goes along the largest one
        t = b * np.sqrt(squares) / (least - squares)
        longest = squares.argmax()
        t[longest] = 0
        t[longest] = np.sqrt(max(0.0, rho**2 - t @ t)) * (1 if b[longest] >= 0 else -1)
    t *= min(1.0, rho / max(np.linalg.norm(t), 1e-300))
    return float(np.sum(np.square(b + np.sqrt(squares) * t)))


@settings(max_examples=200)
@given(st.integers(0, 10_000), st.integers(1, 25), st.sampled_from([1e-5, 1e-3, 0.05, 0.3, 1.0]))
def test_no_vector_in_the_ball_is_above(seed: int, rank: int, rho: float) -> None:
    rng = np.random.default_rng(seed)
    b = (rng.normal(size=(1, rank)) * rng.choice([0, 0.01, 0.5], size=rank)).astype(np.float32)
    squares = (rng.uniform(size=(1, rank)) * rng.choice([0, 1e-4, 1], size=rank)).astype(np.float32)
    remainder = np.array([rho], np.float32)
    explained, plain = bound.plain(b, squares, squares.max(axis=1), remainder)
    sharp = bound.sharp(b, squares, remainder, steps=3)
    t = rng.normal(size=(500, rank))
    t *= remainder / np.linalg.norm(t, axis=1, keepdims=True)
    reached = np.square(b + np.sqrt(squares.astype(np.float64)) * t).sum(axis=1).max()
    exact = largest(b[0].astype(np.float64), squares[0].astype(np.float64), float(remainder[0]))
    assert reached <= exact * (1 + 1e-9) + 1e-12
    assert exact <= sharp[0]
    assert exact <= plain[0]
    assert sharp[0] <= plain[0] * (1 + 1e-5) + 1e-5
    np.testing.assert_allclose(explained[0], np.sum(b.astype(np.float64) ** 2), rtol=1e-5)


def test_newtons_method_reaches_the_maximum() -> None:
    b = np.array([[0.9, 0.3, 0.1, 0.05]], np.float32)
    squares = np.array([[0.01, 0.05, 0.2, 0.3]], np.float32)
    sharp = bound.sharp(b, squares, np.array([0.1], np.float32), steps=6)[0]
    exact = largest(b[0].astype(np.float64), squares[0].astype(np.float64), np.float64(np.float32(0.1)))
    assert exact <= sharp <= exact * (1 + 2e-5)


def test_several_photographs_at_once() -> None:
    rng = np.random.default_rng(0)
    b = rng.normal(size=(6, 4, 3)).astype(np.float32)
    squares = rng.uniform(size=(6, 4)).astype(np.float32)
    remainders = rng.uniform(size=3).astype(np.float32)
    explained, bounds = bound.plain(b, squares[:, :, None], squares.max(axis=1)[:, None], remainders)
    for number in range(3):
        alone = bound.plain(b[:, :, number], squares, squares.max(axis=1), remainders[number])
        np.testing.assert_allclose(explained[:, number], alone[0], rtol=1e-6)
        np.testing.assert_allclose(bounds[:, number], alone[1], rtol=1e-6)


@pytest.mark.parametrize("distance", [0.0, 1e-9, 0.3, 1.0])
def test_least_closeness_is_below_what_the_distance_means(distance: float) -> None:
    least = bound.least_closeness(distance, 4096, 9)
    assert least < 1 - distance**2
    assert least > 1 - distance**2 - 1e-8


def test_rows_that_are_not_quite_orthonormal_only_look_farther() -> None:
    rng = np.random.default_rng(3)
    exact = np.linalg.qr(rng.normal(size=(40, 5)))[0].T
    stored = (exact + 1e-3 * rng.normal(size=(5, 5)) @ exact).astype(np.float32)
    orthonormal = np.linalg.qr(stored.astype(np.float64).T)[0].T
    for _ in range(50):
        unit = unit_photo(rng.normal(size=5) @ exact + 1e-4 * rng.normal(size=40), 40)
        measured = Subspace(stored, np.empty((5, 0))).distance(unit)
        assert np.sum((orthonormal @ unit) ** 2) >= bound.least_closeness(measured, 40, 5)
