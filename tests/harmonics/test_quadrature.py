"""Projection and synthesis: round trips, closed forms, and what aliases."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import eval_legendre

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.grid import harmonics_on_grid, latlong_grid
from harmonicface.harmonics.indexing import count, index
from harmonicface.harmonics.quadrature import project, sphere_grid, synthesize


@pytest.mark.parametrize("order", [0, 1, 2, 7, 64, 200])
def test_band_limited_functions_come_back(order: int) -> None:
    coefficients = np.random.default_rng(order).normal(size=(count(order), 2))
    samples = synthesize(coefficients, sphere_grid(order))
    assert_allclose(project(samples, order), coefficients, rtol=0, atol=1e-11)


@pytest.mark.parametrize("channels", [(), (3,)])
def test_functions_and_samples_of_any_layout(channels: tuple[int, ...]) -> None:
    coefficients = np.random.default_rng(0).normal(size=(count(5), *channels))
    grid = sphere_grid(8)

    def function(directions: np.ndarray) -> np.ndarray:
        return np.tensordot(real_harmonics(directions, 5), coefficients, (0, 0))

    expected = np.concatenate([coefficients, np.zeros((count(8) - count(5), *channels))])
    flat = function(grid.directions)
    for answer in (
        project(function, 8),
        project(function, 8, grid),
        project(flat, 8),
        project(flat.reshape(*grid.shape, *channels), 8, grid),
        project(flat.astype(np.float64).tolist(), 8, grid),
    ):
        assert_allclose(answer, expected, rtol=0, atol=1e-13)
    assert_allclose(synthesize(coefficients, grid), flat.reshape(*grid.shape, *channels), rtol=0, atol=1e-13)


def test_projection_is_the_plain_sum_over_the_grid() -> None:
    grid = latlong_grid(9, 14)
    samples = np.random.default_rng(1).normal(size=grid.shape)
    plain = real_harmonics(grid.directions, 6) @ (grid.weights * samples.ravel())
    assert_allclose(project(samples, 6, grid), plain, rtol=0, atol=1e-13)


@pytest.mark.parametrize("degree", [1, 2, 9])
def test_legendre_polynomials_have_one_coefficient(degree: int) -> None:
    found = project(lambda n: eval_legendre(degree, n[:, 2]), degree)
    expected = np.zeros(count(degree))
    expected[index(degree, 0)] = np.sqrt(4 * np.pi / (2 * degree + 1))
    assert_allclose(found, expected, rtol=0, atol=1e-13)


def test_the_clamped_cosine_converges_to_its_closed_form() -> None:
    expected = np.sqrt(4 * np.pi / (2 * np.arange(3) + 1)) ** -1 * [np.pi, 2 * np.pi / 3, np.pi / 4]
    errors = []
    for order in (16, 64, 256):
        found = project(lambda n: np.maximum(n[:, 2], 0), 2, sphere_grid(order))
        errors.append(np.abs(found[[0, 2, 6]] - expected).max())
    assert errors[0] > 4 * errors[1] > 16 * errors[2]
    assert errors[2] < 1e-4


def test_what_lies_beyond_the_grid_aliases_and_a_finer_grid_helps() -> None:
    def function(directions: np.ndarray) -> np.ndarray:
        return real_harmonics(directions, 5)[index(5, 5)]

    assert np.abs(project(function, 3)).max() > 1e-3  # degree 5 on the grid of order 3
    assert_allclose(project(function, 3, sphere_grid(4)), 0, atol=1e-14)


def test_synthesis_is_the_sum_of_the_harmonics() -> None:
    grid = latlong_grid(4, 6)
    coefficients = np.random.default_rng(2).normal(size=count(9))
    expected = np.tensordot(coefficients, harmonics_on_grid(grid, 9), (0, 0))
    assert_allclose(synthesize(coefficients, grid), expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (np.ones(14), r"values: expected one a direction, 15 or \(3, 5\) and channels, got an array of shape \(14,\)"),
        (np.ones((5, 3)), "values: expected one a direction"),
        (np.ones((3, 5, 2, 2)), "values: expected one a direction"),
        (1.0, "values: expected one a direction"),
        (np.full((3, 5), np.nan), "values: expected finite numbers"),
        (lambda n: np.log(n[:, 2] * 0 + 1)[:-1], "values: expected one a direction"),
        (lambda n: n[:, 0] * np.inf, "values: expected finite numbers"),
    ],
)
@pytest.mark.filterwarnings("ignore:invalid value")
def test_values_that_do_not_fit(values: object, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        project(values, 2)


def test_an_order_that_the_grid_cannot_tell() -> None:
    with pytest.raises(HarmonicFaceError, match="grid: expected at least 9 columns for order 4, got 7"):
        project(lambda n: n[:, 0], 4, sphere_grid(3))
    with pytest.raises(HarmonicFaceError, match="order: expected an integer of at least 0"):
        project(lambda n: n[:, 0], -1)


@pytest.mark.parametrize(
    ("coefficients", "message"),
    [
        (np.ones(3), r"coefficients: expected \(order \+ 1\)\^2"),
        (np.ones((4, 1, 1)), r"coefficients: expected shape \(k,\) or \(k, channels\), got \(4, 1, 1\)"),
        ([np.nan], "coefficients: expected finite numbers"),
    ],
)
def test_coefficients_that_are_none(coefficients: object, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        synthesize(coefficients, sphere_grid(1))


def test_values_beyond_the_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    grid = latlong_grid(1000, 2000)
    monkeypatch.setattr("harmonicface._memory.physical_memory", lambda: 10**7)
    with pytest.raises(HarmonicFaceError, match=r"values on a grid of \(1000, 2000\): need 0.048 GB of memory"):
        synthesize(np.ones(4), grid)


def test_no_grid() -> None:
    with pytest.raises(HarmonicFaceError, match="grid: expected a SphereGrid, got str 'x'"):
        project(lambda n: n[:, 2], 1, "x")
    with pytest.raises(HarmonicFaceError, match="grid: expected a SphereGrid, got str 'x'"):
        synthesize(np.ones(4), "x")
