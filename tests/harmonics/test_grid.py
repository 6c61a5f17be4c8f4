"""Grids and the harmonics on them: exact integrals, orthonormality at order 64."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import factorial2

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.grid import SphereGrid, harmonics_on_grid, latlong_grid, sphere_grid
from harmonicface.harmonics.indexing import count


def monomial_integral(powers: tuple[int, int, int]) -> float:
    """The integral of x^a y^b z^c over the sphere, in closed form."""
    if any(power % 2 for power in powers):
        return 0.0
    return (
        4 * np.pi * np.prod([factorial2(power - 1) if power else 1 for power in powers]) / factorial2(sum(powers) + 1)
    )


@pytest.mark.parametrize("order", [0, 1, 2, 5])
def test_monomials_up_to_twice_the_order_are_exact(order: int) -> None:
    grid = sphere_grid(order)
    assert grid.shape == (order + 1, 2 * order + 1)
    x, y, z = grid.directions.T
    for a in range(2 * order + 1):
        for b in range(2 * order + 1 - a):
            for c in range(2 * order + 1 - a - b):
                expected = monomial_integral((a, b, c))
                assert_allclose(grid.weights @ (x**a * y**b * z**c), expected, rtol=0, atol=1e-13)


def test_the_next_degree_is_not_exact() -> None:
    grid = sphere_grid(2)
    x, y, _ = grid.directions.T
    assert abs(grid.weights @ (x**5 - 10 * x**3 * y**2 + 5 * x * y**4)) > 0.1  # sin^5 cos(5 phi) integrates to 0


def test_order_64_is_orthonormal() -> None:
    grid = sphere_grid(64)
    weighted = harmonics_on_grid(grid, 64)
    weighted *= np.sqrt(grid.row_weights)[:, None]
    flat = weighted.reshape(count(64), -1)
    gram = flat @ flat.T
    gram[np.diag_indices_from(gram)] -= 1
    assert max(gram.max(), -gram.min()) < 1e-12


@pytest.mark.parametrize("grid", [sphere_grid(6), latlong_grid(5, 8), latlong_grid(1, 1)], ids=["exact", "map", "one"])
@pytest.mark.parametrize("order", [0, 1, 4, 20])
def test_the_same_as_evaluating_each_direction(grid: SphereGrid, order: int) -> None:
    expected = real_harmonics(grid.directions, order).reshape(-1, *grid.shape)
    assert_allclose(harmonics_on_grid(grid, order), expected, rtol=0, atol=1e-13)


def test_zonal_harmonics_of_order_200_are_orthonormal() -> None:
    grid = sphere_grid(200)
    zonal = real_harmonics(np.stack([np.sqrt((1 - grid.z) * (1 + grid.z)), 0 * grid.z, grid.z], axis=1), 200)
    zonal = zonal[np.arange(201) * np.arange(1, 202)]
    gram = (zonal * (grid.columns * grid.row_weights)) @ zonal.T
    assert_allclose(gram, np.eye(201), rtol=0, atol=1e-13)
    assert_allclose(grid.weights.sum(), 4 * np.pi, rtol=1e-14)


def test_directions_are_unit_vectors_in_rows() -> None:
    grid = sphere_grid(40)
    assert_allclose(np.linalg.norm(grid.directions, axis=1), 1, rtol=1e-15)
    rows = grid.directions.reshape(*grid.shape, 3)
    assert_allclose(rows[..., 2], np.broadcast_to(grid.z[:, None], grid.shape))
    assert (np.diff(grid.z) < 0).all()
    assert_allclose(rows[:, 0, 1], 0)


@pytest.mark.parametrize("shape", [(1, 1), (7, 3), (16, 32)])
def test_cells_of_a_map_cover_the_sphere(shape: tuple[int, int]) -> None:
    grid = latlong_grid(*shape)
    assert grid.shape == shape
    assert_allclose(grid.weights.sum(), 4 * np.pi, rtol=1e-14)
    assert len(grid.weights) == len(grid.directions) == shape[0] * shape[1]


def test_a_map_converges_as_the_square_of_its_rows() -> None:
    errors = []
    for rows in (8, 16, 32):
        grid = latlong_grid(rows, 2 * rows)
        errors.append(abs(grid.weights @ grid.directions[:, 2] ** 4 - 4 * np.pi / 5))
    assert 3.5 < errors[0] / errors[1] < 4.5
    assert 3.5 < errors[1] / errors[2] < 4.5


@pytest.mark.parametrize(
    ("z", "weights", "columns", "message"),
    [
        (np.zeros(2), np.zeros(3), 4, "grid: expected rows of z"),
        (np.zeros((2, 1)), np.zeros((2, 1)), 4, "grid: expected rows of z"),
        (np.array([1.1]), np.ones(1), 4, "grid: expected rows of z from -1 to 1"),
        (np.array([np.nan]), np.ones(1), 4, "grid: expected rows of z from -1 to 1"),
        ([0.0, 0.5], [1.0], 4, "grid: expected rows of z"),
        ("x", np.ones(1), 4, "z: expected an array of real numbers"),
        (np.zeros(1), [[1.0], [1.0, 2.0]], 4, "row_weights: expected an array of real numbers"),
        (np.zeros(1), np.array([np.nan]), 4, "row_weights: expected finite numbers"),
        (np.zeros(1), np.ones(1), 0, "columns: expected an integer of at least 1"),
    ],
)
def test_rows_that_are_no_grid(z: np.ndarray, weights: np.ndarray, columns: int, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        SphereGrid(z, weights, columns)


def test_sizes_that_are_none() -> None:
    with pytest.raises(HarmonicFaceError, match="order: expected an integer of at least 0"):
        sphere_grid(-1)
    with pytest.raises(HarmonicFaceError, match="rows: expected an integer of at least 1"):
        latlong_grid(0, 4)
    with pytest.raises(HarmonicFaceError, match="columns: expected an integer of at least 1"):
        latlong_grid(4, 0)
    with pytest.raises(HarmonicFaceError, match="order: expected an integer of at least 0"):
        harmonics_on_grid(sphere_grid(1), -1)


def test_grids_beyond_the_memory() -> None:
    with pytest.raises(HarmonicFaceError, match=r"the grid of order 1000000: need .* GB of memory"):
        sphere_grid(10**6)
    with pytest.raises(HarmonicFaceError, match=r"a grid of 1000000 x 2000000 directions: need .* GB of memory"):
        latlong_grid(10**6, 2 * 10**6)
    with pytest.raises(HarmonicFaceError, match=r"harmonics of order 20000 on \(65, 129\): need .* GB of memory"):
        harmonics_on_grid(sphere_grid(64), 20000)


def test_lists_are_rows_too() -> None:
    grid = SphereGrid([-0.5, 0.5], [np.pi / 2, np.pi / 2], 4)
    assert grid.directions.shape == (8, 3)
    assert grid.weights.sum() == pytest.approx(4 * np.pi)


def test_harmonics_on_no_grid() -> None:
    with pytest.raises(HarmonicFaceError, match="grid: expected a SphereGrid, got str 'x'"):
        harmonics_on_grid("x", 1)
