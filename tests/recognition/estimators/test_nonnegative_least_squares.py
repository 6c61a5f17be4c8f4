"""Non-negative least squares, many at once, against SciPy's and against its own optimality."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import nnls

from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.estimators.nonnegative_least_squares import nonnegative_solutions


def problems(people: int, rays: int, size: int, queries: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Random rays (people, rays, size) of mostly positive numbers, and pictures (queries, size)."""
    random = np.random.default_rng(seed)
    return random.normal(0.3, 1, (people, rays, size)), random.normal(0.3, 1, (queries, size))


def solved(rays: np.ndarray, pictures: np.ndarray) -> np.ndarray:
    return nonnegative_solutions(rays @ rays.transpose(0, 2, 1), np.einsum("ckp,np->nck", rays, pictures))


@pytest.mark.parametrize(("people", "k", "size", "queries"), [(1, 1, 5, 1), (3, 12, 30, 7), (2, 40, 60, 5)])
def test_it_is_scipys(people: int, k: int, size: int, queries: int) -> None:
    rays, pictures = problems(people, k, size, queries)
    expected = [[nnls(own.T, picture)[0] for own in rays] for picture in pictures]
    np.testing.assert_allclose(solved(rays, pictures), expected, atol=1e-7)


def test_more_rays_than_dimensions_leave_scipys_residual() -> None:
    """The weights are not unique then; what they explain is."""
    rays, pictures = problems(4, 80, 9, 20)
    rays = np.abs(rays)
    explained = np.einsum("nck,ckp->ncp", solved(rays, pictures), rays)
    left = np.linalg.norm(pictures[:, None] - explained, axis=2)
    expected = [[nnls(own.T, picture)[1] for own in rays] for picture in pictures]
    np.testing.assert_allclose(left, expected, atol=1e-6)


def test_equal_and_dark_rays_do_no_harm() -> None:
    rays, pictures = problems(1, 6, 20, 4)
    rays[:, 3] = rays[:, 2]
    rays[:, 5] = 0
    weights = solved(rays, pictures)
    left = np.linalg.norm(pictures - np.einsum("nck,ckp->np", weights, rays), axis=1)
    np.testing.assert_allclose(left, [nnls(rays[0].T, picture)[1] for picture in pictures], atol=1e-9)
    assert (weights[:, 0, 5] == 0).all()


@given(st.integers(0, 10_000), st.integers(1, 25), st.integers(1, 25))
def test_it_is_optimal(seed: int, k: int, size: int) -> None:
    """Karush, Kuhn & Tucker: nothing negative, no slope upward, none at all where something is positive."""
    rays, pictures = problems(2, k, size, 3, seed)
    grams, targets = rays @ rays.transpose(0, 2, 1), np.einsum("ckp,np->nck", rays, pictures)
    weights = nonnegative_solutions(grams, targets)
    slopes = targets - np.einsum("ckl,ncl->nck", grams, weights)
    scale = np.abs(targets).max()
    assert (weights >= 0).all()
    assert slopes.max() <= 1e-6 * scale
    assert np.abs(slopes[weights > 0]).max(initial=0) <= 1e-6 * scale


def test_nothing_positive_explains_a_picture_on_the_other_side() -> None:
    rays, pictures = problems(1, 5, 9, 1)
    assert not solved(np.abs(rays), -np.abs(pictures)).any()


def test_no_queries_no_answers() -> None:
    assert nonnegative_solutions(np.eye(3)[None], np.zeros((0, 1, 3))).shape == (0, 1, 3)


def test_problems_that_stay_open_are_told() -> None:
    rays, pictures = problems(1, 12, 30, 2)
    grams, targets = rays @ rays.transpose(0, 2, 1), np.einsum("ckp,np->nck", rays, pictures)
    with pytest.raises(HarmonicFaceError, match="settle in 2 rounds, got 2 that do not"):
        nonnegative_solutions(grams, targets, rounds=2)
