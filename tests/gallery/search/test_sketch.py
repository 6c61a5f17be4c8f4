"""The sketch: what it says of a person is true of her rows, at every stage."""

from __future__ import annotations

from collections.abc import Callable
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.search.bound import features
from harmonicface.gallery.search.shared_basis import SharedBasis
from harmonicface.gallery.search.sketch import sketch, sketches

Draw = Callable[..., list[NDArray[np.float32]]]


@settings(max_examples=100)
@given(
    st.integers(0, 10_000),
    st.sampled_from([1, 5, 9]),
    st.integers(3, 30),
    st.sampled_from(["float16", "float32"]),
    st.sampled_from(["anything", "inside", "worst"]),
)
def test_no_photograph_is_explained_better_than_the_bounds_say(
    draw: Draw, seed: int, rank: int, m: int, dtype: str, kind: str
) -> None:
    rng = np.random.default_rng(seed)
    rows = draw(rng, [rank], 30, 0.0)[0]
    basis = SharedBasis(np.linalg.qr(rng.normal(size=(30, m)))[0].T)
    seen = sketch(rows, basis, (2, m), dtype)
    exact = np.linalg.qr(rows.astype(np.float64).T)[0].T
    unit = rng.normal(size=30)
    if kind == "inside":
        unit = basis.rows.T @ (basis.rows @ unit)
    if kind == "worst":  # a photograph of her own, with what the shared basis leaves over of her and nothing else
        unit = (rng.normal(size=rank) * 10.0 ** -np.arange(rank)) @ exact
    unit /= np.linalg.norm(unit)
    explained = np.sum((exact @ unit) ** 2)
    seen_of_unit = (basis.rows @ unit).astype(np.float32)
    for stage, stop in enumerate((2, 2, m)):
        rho = max(0.0, 1 - np.sum((basis.rows[:stop] @ unit) ** 2))
        if stage:
            square = float(np.sum((seen.numbers[stage - 1] @ seen_of_unit[:stop]) ** 2))
        else:
            square = float(seen.form @ features(seen_of_unit[:stop, None], np.ones(1, np.float32))[:-2, 0])
        assert explained <= square + float(seen.levels[stage]) * rho + float(seen.doubts[stage])
        assert seen.doubts[stage] < (1e-2 if dtype == "float16" and stage else 1e-4)


def test_a_person_within_the_shared_basis_leaves_nothing() -> None:
    seen = sketch(np.eye(6)[:2], SharedBasis(np.eye(6)[:3]), (3,))
    assert seen.levels.max() < 1e-3
    assert seen.defect < 1e-12


def test_many_are_sketched_like_one() -> None:
    rng = np.random.default_rng(0)
    people = [np.linalg.qr(rng.normal(size=(30, rank)))[0].T for rank in (4, 9, 4, 1)]
    basis = SharedBasis(np.linalg.qr(rng.normal(size=(30, 20)))[0].T)
    with patch("harmonicface.gallery.search.sketch.TOGETHER", 3 * 30 * 9 * 8):
        together = list(sketches(people, basis, (5, 20)))
    for rows, one in zip(people, together, strict=True):
        alone = sketch(rows, basis, (5, 20))
        np.testing.assert_allclose(one.form, alone.form, atol=1e-6)
        np.testing.assert_allclose(one.levels, alone.levels, rtol=1e-6)
        np.testing.assert_allclose(np.abs(one.numbers[1]), np.abs(alone.numbers[1]), atol=1e-5)


def test_half_precision_costs_doubt() -> None:
    rng = np.random.default_rng(0)
    rows, basis = np.linalg.qr(rng.normal(size=(30, 4)))[0].T, SharedBasis(np.linalg.qr(rng.normal(size=(30, 20)))[0].T)
    half, single = sketch(rows, basis, (20,), "float16"), sketch(rows, basis, (20,))
    assert half.numbers[0].dtype == np.float16
    assert single.doubts[1] < 1e-4 < half.doubts[1] < 3e-3


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
