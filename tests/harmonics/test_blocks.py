"""The blocks of the hot path against slow, readable twins."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harmonicface.harmonics._blocks import all_harmonics, low_harmonics


def nine_by_hand(direction: np.ndarray) -> list[float]:
    x, y, z = direction
    root = np.sqrt(1 / np.pi)
    return [
        root / 2,
        np.sqrt(3) * root / 2 * y,
        np.sqrt(3) * root / 2 * z,
        np.sqrt(3) * root / 2 * x,
        np.sqrt(15) * root / 2 * x * y,
        np.sqrt(15) * root / 2 * y * z,
        np.sqrt(5) * root / 4 * (3 * z**2 - 1),
        np.sqrt(15) * root / 2 * x * z,
        np.sqrt(15) * root / 4 * (x**2 - y**2),
    ]


@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-15), (np.float32, 4e-7)])
def test_nine_polynomials_without_temporaries(random_directions, dtype: type, tolerance: float) -> None:
    directions = random_directions(64).astype(dtype)
    out = np.full((9, 64), np.nan, dtype)
    least, largest = low_harmonics(2, 100, np.dtype(dtype))(directions, out)
    twin = np.array([nine_by_hand(direction) for direction in directions.astype(np.float64)]).T
    assert_allclose(out, twin, rtol=0, atol=tolerance)
    assert_allclose([least, largest], 1, rtol=0, atol=1e-6)


def test_one_kernel_serves_many_blocks(random_directions) -> None:
    write = low_harmonics(2, 10, np.dtype(np.float64))
    for number in (10, 3, 10, 1):
        directions, out = random_directions(number, seed=number), np.empty((9, number))
        write(directions, out)
        assert_allclose(out, np.array([nine_by_hand(direction) for direction in directions]).T, rtol=0, atol=1e-15)


@pytest.mark.parametrize("order", [0, 1, 2])
def test_both_kernels_are_the_nine_polynomials(random_directions, order: int) -> None:
    directions = random_directions(20)
    twin = np.array([nine_by_hand(direction) for direction in directions]).T
    for write in (all_harmonics(order), low_harmonics(order, 20, np.dtype(np.float64))):
        out = np.empty(((order + 1) ** 2, 20))
        write(directions, out)
        assert_allclose(out, twin[: len(out)], rtol=0, atol=1e-15)


@pytest.mark.parametrize("recursive", [True, False])
@pytest.mark.parametrize("order", [0, 1, 2])
def test_both_kernels_measure_the_vectors(order: int, recursive: bool) -> None:
    directions = np.array([[0.0, 0.0, 0.5], [0.0, 3.0, 4.0], [1.0, 0.0, 0.0]])
    write = all_harmonics(order) if recursive else low_harmonics(order, 3, np.dtype(np.float64))
    assert_allclose(write(directions, np.empty(((order + 1) ** 2, 3))), (0.25, 25), rtol=1e-14)
    directions[1, 1] = np.nan
    assert np.isnan(write(directions, np.empty(((order + 1) ** 2, 3)))).all()
