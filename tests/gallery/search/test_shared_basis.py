"""The shared basis: principal directions of the weighted rows, and what they leave over of photographs."""

from __future__ import annotations

from unittest.mock import patch

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.search.shared_basis import Question, SharedBasis


def test_the_energy_left_over_is_the_least_possible() -> None:
    rng = np.random.default_rng(0)
    rows = rng.normal(size=(40, 25)) @ np.diag(np.geomspace(1, 0.01, 25))
    weights = rng.uniform(0.1, 3, size=40)
    basis = SharedBasis.of(rows, weights, 7)
    left = np.sum(weights * np.square(rows - rows @ basis.rows.T @ basis.rows).sum(axis=1))
    values = np.linalg.eigvalsh(rows.T @ (weights[:, None] * rows))
    assert_allclose(left, values[:-7].sum(), rtol=1e-6)
    assert_allclose(basis.rows @ basis.rows.T, np.eye(7), atol=1e-14)


def test_fewer_rows_where_the_sample_spans_less() -> None:
    rows = np.random.default_rng(0).normal(size=(2, 30))
    assert SharedBasis.of(rows[[0, 1, 0, 1]], np.ones(4), 10).rows.shape == (2, 30)
    assert SharedBasis.of(np.resize(rows, (40, 30)), np.ones(40), 10).rows.shape == (2, 30)


def test_a_large_sample_gives_what_a_small_one_of_the_same_rows_gives() -> None:
    rng = np.random.default_rng(2)
    rows = (rng.normal(size=(20, 40)) @ np.diag(np.geomspace(1, 0.01, 40))).astype(np.float32)
    few = SharedBasis.of(rows, np.ones(20), 6)
    with patch("harmonicface.gallery.search.shared_basis.TOGETHER", 7):
        many = SharedBasis.of(np.concatenate([rows, rows, rows]), np.ones(60), 6)
    assert_allclose(many.rows.T @ many.rows, few.rows.T @ few.rows, atol=1e-4)


def test_what_is_left_over_is_never_more_than_said() -> None:
    rng = np.random.default_rng(1)
    basis = SharedBasis(np.linalg.qr(rng.normal(size=(50, 20)))[0].T)
    units = np.concatenate([rng.normal(size=(50, 5)), basis.rows[:2].T, basis.rows[:3].T @ rng.normal(size=(3, 2))], 1)
    units /= np.linalg.norm(units, axis=0)
    question = Question(basis, units.T)
    for stop in (1, 3, 20):
        left = units - basis.rows[:stop].T @ (basis.rows[:stop] @ units)
        squares = question.left(stop)
        assert (squares >= np.square(left).sum(axis=0)).all()
        assert_allclose(squares, np.square(left).sum(axis=0), atol=1e-7)
        assert_allclose(question.coordinates(stop), basis.rows[:stop] @ units, atol=1e-7)


@pytest.mark.parametrize(
    ("rows", "weights", "m", "expected"),
    [
        (np.ones(3), np.ones(3), 1, r"rows: expected shape \(n, p\)"),
        (np.empty((0, 3)), np.ones(0), 1, r"rows: expected shape \(n, p\)"),
        ([[np.nan, 1.0]], [1.0], 1, "rows: expected finite numbers"),
        (np.eye(3), np.ones(2), 1, "weights: expected 3 numbers above 0"),
        (np.eye(2), [1.0, 0.0], 1, "weights: expected 2 numbers above 0"),
        (np.zeros((2, 3)), np.ones(2), 1, "rows: expected some that are not 0"),
        (np.eye(2), np.ones(2), 0, "m: expected an integer of at least 1"),
    ],
)
def test_a_bad_sample(rows: object, weights: object, m: int, expected: str) -> None:
    with pytest.raises(HarmonicFaceError, match=expected):
        SharedBasis.of(rows, weights, m)


@pytest.mark.parametrize(
    ("rows", "expected"),
    [
        (np.ones(3), r"rows: expected shape \(m, p\)"),
        ([[1.0, 0.0], [0.1, 1.0]], "rows: expected orthonormal rows, got some that are not, by 0.1"),
        ([[np.inf, 0.0]], "rows: expected finite"),
    ],
)
def test_a_bad_basis(rows: object, expected: str) -> None:
    with pytest.raises(HarmonicFaceError, match=expected):
        SharedBasis(rows)  # type: ignore[arg-type]
