"""A sketch is right if its bound is above what its person explains, of any photograph; else it is found."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.disk.sketch_check import check_sketch
from harmonicface.gallery.search.packing import packed
from harmonicface.gallery.search.shared_basis import SharedBasis
from harmonicface.gallery.search.sketch import Sketch, sketch
from harmonicface.store.entry import Entry

PIXELS, STOPS = 90, (16, 40)


def orthonormal(count: int, seed: int) -> np.ndarray:
    return np.linalg.qr(np.random.default_rng(seed).normal(size=(PIXELS, count)))[0].T


BASIS = SharedBasis(orthonormal(STOPS[-1], 0))


def alike(count: int, seed: int) -> np.ndarray:
    """Return rows most of which the basis explains."""
    mixed = orthonormal(count, seed) * 0.2 + (orthonormal(count, seed) @ BASIS.rows.T) @ BASIS.rows
    return np.linalg.qr(mixed.T)[0].T.astype(np.float32)


def check(rows: np.ndarray, made: Sketch, stops: tuple[int, ...] = STOPS) -> None:
    check_sketch(Entry("ada", {"rows": rows, **packed(made)}), rows, seen(rows), stops)


def seen(rows: np.ndarray) -> np.ndarray:
    return rows.astype(np.float64) @ BASIS.rows.T


@given(
    st.integers(1, 25),
    st.integers(0, 1000),
    st.sampled_from(["float16", "float32"]),
    st.sampled_from(["float16", "float32"]),
)
def test_right_ones_are_right(count, seed, dtype, stored) -> None:
    rows = alike(count, seed).astype(stored)
    check(rows, sketch(rows, BASIS, STOPS, dtype))


def test_nobody_has_to_have_one() -> None:
    rows, made = alike(3, 1), sketch(alike(3, 1), BASIS, STOPS)
    check_sketch(Entry("ada", {name: array[:0] for name, array in packed(made).items()}), rows, seen(rows), STOPS)


def less(array: np.ndarray) -> np.ndarray:
    return (array * np.float32(0.99)).astype(array.dtype)


@pytest.mark.parametrize(
    "change",
    [
        lambda made: {"form": less(made.form)},
        lambda made: {"numbers": (less(made.numbers[0]), made.numbers[1])},
        lambda made: {"numbers": (made.numbers[0], less(made.numbers[1]))},
        lambda made: {"levels": less(made.levels)},
        lambda made: {"levels": -made.levels},
        lambda made: {"levels": made.levels[:2]},
        lambda made: {"doubts": made.doubts - np.float32(0.01)},
        lambda made: {"doubts": made.doubts * np.float32(np.nan)},
        lambda made: {"form": made.form * np.float32(np.nan)},
        lambda made: {"numbers": tuple(some[:-1] for some in made.numbers)},
        lambda made: {"numbers": tuple(some[:, :-1] for some in made.numbers)},
        lambda made: {"numbers": made.numbers[:1], "doubts": made.doubts[:2]},
        lambda made: {"defect": -1.0},
    ],
)
def test_others_are_found(change) -> None:
    rows = alike(9, 5)
    made = sketch(rows, BASIS, STOPS)
    check(rows, made)
    with pytest.raises(HarmonicFaceError, match="'ada': expected a sketch of her rows, got another one"):
        check(rows, dataclasses.replace(made, **change(made)))


def test_that_of_somebody_else() -> None:
    with pytest.raises(HarmonicFaceError, match="expected a sketch of her rows"):
        check(alike(9, 5), sketch(alike(9, 6), BASIS, STOPS))


def test_an_array_is_missing() -> None:
    rows = alike(9, 5)
    arrays = packed(sketch(rows, BASIS, STOPS))
    arrays["sketch_form"] = arrays["sketch_form"][:0]
    with pytest.raises(HarmonicFaceError, match="expected a sketch of her rows"):
        check_sketch(Entry("ada", arrays), rows, seen(rows), STOPS)
