"""The sketch: what it says of a person is true of her rows, at every stage."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.search.crowd import crowd
from harmonicface.gallery.search.shared_basis import SharedBasis
from harmonicface.gallery.search.sketch import sketch

Draw = Callable[..., list[NDArray[np.float32]]]


@settings(max_examples=60)
@given(
    st.integers(0, 10_000),
    st.sampled_from([1, 5, 9]),
    st.integers(3, 30),
    st.sampled_from(["float16", "float32"]),
    st.booleans(),
)
def test_what_is_left_over_is_within_the_ellipsoid(
    draw: Draw, seed: int, rank: int, m: int, dtype: str, inside: bool
) -> None:
    """Q y = b + S t + e with |t| <= rho and |e| <= doubt, for the Q that the numbers themselves determine."""
    rng = np.random.default_rng(seed)
    rows = draw(rng, [rank], 30, 0.0)[0]
    basis = SharedBasis(np.linalg.qr(rng.normal(size=(30, m)))[0].T)
    seen = sketch(rows, basis, (2, m), dtype)
    unit = rng.normal(size=30)
    unit = basis.rows.T @ (basis.rows @ unit) if inside else unit
    unit /= np.linalg.norm(unit)
    exact = np.linalg.qr(rows.astype(np.float64).T)[0].T
    products, start = np.zeros(rank), 0
    for stage, stop in enumerate((2, m)):
        part = basis.rows[start:stop]
        if stage:
            products = seen.turns[0].astype(np.float64) @ products
        products = products + seen.numbers[:, start:stop].astype(np.float64) @ (part @ unit)
        rest = np.eye(rank) - (exact @ basis.rows[:stop].T) @ (exact @ basis.rows[:stop].T).T
        assert np.sort(np.linalg.eigvalsh(rest)) == pytest.approx(np.sort(seen.squares[stage]), abs=1e-6)
        rho = np.sqrt(max(0.0, 1 - np.sum((basis.rows[:stop] @ unit) ** 2)))
        reach = np.linalg.norm(products) + rho * np.sqrt(seen.squares[stage].max()) + seen.doubts[stage]
        assert np.linalg.norm(exact @ unit) <= reach + 1e-9
        start = stop


def test_a_person_within_the_shared_basis_leaves_nothing() -> None:
    seen = sketch(np.eye(6)[:2], SharedBasis(np.eye(6)[:3]), (3,))
    assert seen.squares.max() < 1e-6
    assert seen.defect < 1e-12


def test_half_precision_costs_doubt() -> None:
    rng = np.random.default_rng(0)
    rows, basis = np.linalg.qr(rng.normal(size=(30, 4)))[0].T, SharedBasis(np.linalg.qr(rng.normal(size=(30, 20)))[0].T)
    half, single = sketch(rows, basis, (20,), "float16"), sketch(rows, basis, (20,))
    assert half.numbers.dtype == np.float16
    assert single.doubts[0] < 1e-5 < half.doubts[0] < 1e-3


@pytest.mark.parametrize(
    ("rows", "columns", "dtype", "expected"),
    [
        (np.ones(3), (1,), "float32", r"rows: expected shape \(r, 3\)"),
        (np.eye(4), (1,), "float32", r"rows: expected shape \(r, 3\)"),
        (np.empty((0, 3)), (1,), "float32", r"rows: expected shape \(r, 3\)"),
        ([[np.nan, 0.0, 0.0]], (1,), "float32", "rows: expected finite numbers"),
        ([[1.1, 0.0, 0.0]], (1,), "float32", "rows: expected orthonormal rows, got some that are not, by 0.21"),
        (np.eye(3), (), "float32", "columns: expected rising numbers"),
        (np.eye(3), (2, 1), "float32", "columns: expected rising numbers"),
        (np.eye(3), (0, 1), "float32", "columns: expected an integer of at least 1"),
        (np.eye(3), (1,), "float64", "dtype: expected one of float16, float32, got 'float64'"),
    ],
)
def test_bad_input(rows: object, columns: tuple[int, ...], dtype: str, expected: str) -> None:
    with pytest.raises(HarmonicFaceError, match=expected):
        sketch(rows, SharedBasis(np.eye(3)[:2]), columns, dtype)


def test_sketches_of_other_stages_are_not_stacked() -> None:
    basis = SharedBasis(np.eye(4))
    sketches: list[Any] = [sketch(np.eye(4)[:2], basis, (1, 3))]
    with pytest.raises(HarmonicFaceError, match=r"sketches: expected stages of \(3,\) columns, got 2 of 3"):
        crowd(sketches, (3,))
