"""People's rows in one array: what goes in comes out, however it grew and shrank."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from harmonicface.gallery.enrolled.rows import StackedRows
from harmonicface.recognition.subspace import Subspace

PIXELS = 12


def subspace(seed: int) -> Subspace:
    rng = np.random.default_rng(seed)
    return Subspace.of(rng.normal(size=(1 + seed % 4, PIXELS)).astype(np.float32))


def empty() -> StackedRows:
    return StackedRows(np.empty((0, PIXELS), np.float32))


@settings(deadline=None, max_examples=60)
@given(st.lists(st.tuples(st.booleans(), st.integers(0, 1000)), max_size=25))
def test_like_a_list_of_subspaces(steps: list[tuple[bool, int]]) -> None:
    rows, expected = empty(), []
    for add, number in steps:
        if add or not expected:
            rows.append(subspace(number))
            expected.append(subspace(number))
        else:
            rows.remove(number % len(expected))
            del expected[number % len(expected)]
    assert len(rows) == len(rows.to_coefficients) == len(expected)
    assert rows.array.shape == (sum(one.rank for one in expected), PIXELS)
    for index, one in enumerate(expected):
        assert_array_equal(rows.subspace(index).rows, one.rows)
        assert_array_equal(rows.subspace(index).to_coefficients, one.to_coefficients)


def test_closeness_is_the_squared_length_of_each_projection() -> None:
    rows = empty()
    for seed in range(7):
        rows.append(subspace(seed))
    photo = np.random.default_rng(9).normal(size=PIXELS)
    photo /= np.linalg.norm(photo)
    expected = [np.sum((subspace(seed).rows.astype(np.float64) @ photo) ** 2) for seed in range(7)]
    assert_allclose(rows.closeness(photo), expected, rtol=0, atol=1e-6)
    rows.remove(0)
    assert_allclose(rows.closeness(photo), expected[1:], rtol=0, atol=1e-6)


def test_rows_are_not_copied_to_be_read() -> None:
    rows = empty()
    rows.append(subspace(1))
    assert np.shares_memory(rows.subspace(0).rows, rows.array)


def test_many_people_cost_few_copies() -> None:
    rows, buffers = empty(), set()
    for seed in range(200):
        rows.append(subspace(seed))
        buffers.add(rows.array.__array_interface__["data"][0])
    assert len(buffers) < 20


def test_the_largest_closeness_to_some_photographs() -> None:
    rows = empty()
    for number in (3, 5, 8):
        rows.append(subspace(number))
    photos = np.random.default_rng(0).normal(size=(4, PIXELS))
    photos /= np.linalg.norm(photos, axis=1, keepdims=True)
    expected = np.max([rows.closeness(photo) for photo in photos], axis=0)
    assert_allclose(rows.displaced_closeness(photos.astype(np.float32)), expected, rtol=1e-5)
