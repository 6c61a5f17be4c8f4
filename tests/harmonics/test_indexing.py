from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import count, degrees, index, modes, order_of


def test_harmonics_are_stored_degree_by_degree_and_mode_by_mode() -> None:
    pairs = [(degree, mode) for degree in range(6) for mode in range(-degree, degree + 1)]
    assert [index(degree, mode) for degree, mode in pairs] == list(range(count(5)))
    assert degrees(5).tolist() == [degree for degree, _ in pairs]
    assert modes(5).tolist() == [mode for _, mode in pairs]


@settings(deadline=None, max_examples=50)
@given(st.integers(0, 10_000))
def test_an_order_is_known_by_its_count(order: int) -> None:
    assert order_of(count(order)) == order


@pytest.mark.parametrize("size", [0, -4, 2, 3, 5, 8, 10, 10**30 + 1])
def test_no_square_number_is_no_order(size: int) -> None:
    with pytest.raises(HarmonicFaceError, match=rf"expected \(order \+ 1\)\^2 of them .*, got {size}"):
        order_of(size)


@pytest.mark.parametrize(("degree", "mode"), [(0, 1), (2, 3), (2, -3), (2, 0.5), (1, np.nan)])
def test_a_mode_beyond_its_degree(degree: int, mode: int) -> None:
    with pytest.raises(HarmonicFaceError, match="mode: expected an integer"):
        index(degree, mode)


@pytest.mark.parametrize("order", [-1, 1.5, "2", True])
def test_an_order_that_is_none(order: int) -> None:
    for function in (count, degrees, modes):
        with pytest.raises(HarmonicFaceError, match="order: expected an integer of at least 0"):
            function(order)
    with pytest.raises(HarmonicFaceError, match="degree: expected an integer of at least 0"):
        index(order, 0)


def test_harmonics_beyond_the_memory() -> None:
    for function in (degrees, modes):
        with pytest.raises(
            HarmonicFaceError, match=rf"{function.__name__} of the harmonics of order 10000000: need .* GB"
        ):
            function(10**7)


@pytest.mark.parametrize("size", [9.0, "9", None, True])
def test_no_whole_number_is_no_order(size: object) -> None:
    with pytest.raises(HarmonicFaceError, match=rf"expected \(order \+ 1\)\^2 of them .*, got {size!r}"):
        order_of(size)
