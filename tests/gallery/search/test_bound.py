"""The bound holds for every vector in the ball, and its best level is the maximum itself."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq, minimize_scalar

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


def reached(b: np.ndarray, squares: np.ndarray, rho: float, level: float) -> float:
    """Return |N a|^2 + l rho^2, with b = C a, in the axes of G."""
    return float(np.sum(b**2 * level / (level - squares)) + level * rho**2)


@settings(max_examples=200)
@given(st.integers(0, 10_000), st.integers(1, 25), st.sampled_from([1e-5, 1e-3, 0.05, 0.3, 1.0]))
def test_any_level_is_above_every_vector_in_the_ball_and_the_best_one_is_the_maximum(
    seed: int, rank: int, rho: float
) -> None:
    rng = np.random.default_rng(seed)
    b = rng.normal(size=rank) * rng.choice([0.01, 0.5], size=rank)
    squares = rng.uniform(0.01, 1, size=rank) * rng.choice([1e-3, 1], size=rank)
    exact = largest(b, squares, rho)
    most = float(squares.max())
    gaps = most * np.geomspace(1e-6, 1e6, 50)
    assert min(reached(b, squares, rho, most + gap) for gap in gaps) >= exact * (1 - 1e-9)
    best = minimize_scalar(lambda power: reached(b, squares, rho, most * (1 + np.exp(power))), bounds=(-30, 30))
    assert best.fun <= exact * (1 + 1e-4)
    ball = rng.normal(size=(500, rank))
    ball *= rho / np.linalg.norm(ball, axis=1, keepdims=True)
    assert np.square(b + np.sqrt(squares) * ball).sum(axis=1).max() <= exact * (1 + 1e-9)


@settings(max_examples=50)
@given(st.integers(0, 10_000), st.integers(1, 25))
def test_the_level_is_near_the_best_for_photographs_of_the_person(seed: int, rank: int) -> None:
    rng = np.random.default_rng(seed)
    squares = np.sort(rng.uniform(size=rank) ** 4)
    turns = np.linalg.qr(np.eye(rank) + 0.1 * rng.normal(size=(rank, rank)))[0]
    energies = np.arange(1, rank + 1.0) ** -2
    shares = np.square(turns).T @ energies / energies.sum()
    rho = np.sqrt(squares @ shares + bound.NOISE * 0.5)

    def expected(level: float) -> float:
        return reached((1 - squares) * np.sqrt(shares), squares, float(rho), level)

    chosen = bound.level(squares, turns, 0.5)
    assert chosen > squares.max()
    tried = squares.max() * (1 + np.geomspace(bound.LEAST_GAP, 1e4, 400)) + bound.TINY
    assert expected(chosen) <= min(map(expected, tried)) * 1.01


def test_the_quadratic_form_is_the_square() -> None:
    rng = np.random.default_rng(1)
    folded, coordinates = rng.normal(size=(9, 7)), rng.normal(size=(7, 3)).astype(np.float32)
    asked = bound.features(coordinates, np.array([0.1, 0.2, 0.3], np.float32))
    assert asked.shape == (7 * 8 // 2 + 2, 3)
    np.testing.assert_allclose(bound.quadratic(folded) @ asked[:-2], np.square(folded @ coordinates).sum(axis=0), 1e-5)
    np.testing.assert_array_equal(asked[-2:], np.array([[0.1, 0.2, 0.3], [1, 1, 1]], np.float32))


def test_so_many_roundings_that_nothing_is_certain() -> None:
    assert bound.gamma(1 << 24) == np.inf
    assert bound.gamma(1000) == pytest.approx(1000 * 2.0**-24, rel=1e-3)


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
