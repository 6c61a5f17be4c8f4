"""Least squares on scattered samples: recovery, weights, conditioning, and refusal."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import count
from harmonicface.harmonics.quadrature import sphere_grid
from harmonicface.harmonics.scattered import fit


@pytest.mark.parametrize("channels", [(), (3,)])
@pytest.mark.parametrize("order", [0, 2, 8])
def test_band_limited_functions_are_recovered(random_directions, order: int, channels: tuple[int, ...]) -> None:
    directions = random_directions(4 * count(order))
    coefficients = np.random.default_rng(0).normal(size=(count(order), *channels))
    values = np.tensordot(real_harmonics(directions, order), coefficients, (0, 0))
    found = fit(directions, values, order)
    assert_allclose(found.coefficients, coefficients, rtol=0, atol=1e-12)
    assert found.residual.shape == channels
    assert_allclose(found.residual, 0, atol=1e-13)


def test_as_many_samples_as_harmonics_are_enough(random_directions) -> None:
    directions = random_directions(9)
    found = fit(directions, np.arange(9.0), 2)
    assert_allclose(found.coefficients @ real_harmonics(directions, 2), np.arange(9.0), rtol=0, atol=1e-10)


def test_condition_and_residual_are_those_of_the_equations(random_directions) -> None:
    directions = random_directions(60)
    values, weights = np.random.default_rng(1).normal(size=60), np.random.default_rng(2).uniform(0.5, 2, 60)
    found = fit(directions, values, 2, weights)
    equations = real_harmonics(directions, 2).T * np.sqrt(weights)[:, None]
    expected, _, _, singular = np.linalg.lstsq(equations, values * np.sqrt(weights))
    assert_allclose(found.coefficients, expected, rtol=0, atol=1e-13)
    assert_allclose(found.condition, singular[0] / singular[-1], rtol=1e-12)
    errors = values - expected @ real_harmonics(directions, 2)
    assert_allclose(found.residual, np.sqrt((weights * errors**2).sum() / weights.sum()), rtol=1e-12)


def test_quadrature_weights_make_it_a_projection() -> None:
    grid = sphere_grid(6)
    found = fit(grid.directions, np.exp(grid.directions[:, 0]), 6, grid.weights)
    assert_allclose(found.condition, 1, rtol=1e-12)
    expected = real_harmonics(grid.directions, 6) @ (grid.weights * np.exp(grid.directions[:, 0]))
    assert_allclose(found.coefficients, expected, rtol=0, atol=1e-13)


def test_samples_of_no_weight_do_not_count(random_directions) -> None:
    directions = random_directions(30)
    values = np.random.default_rng(3).normal(size=30)
    weights = np.repeat([1.0, 0.0], 15)
    spoiled = values + 1e6 * (weights == 0)
    found, other = fit(directions[:15], values[:15], 1), fit(directions, spoiled, 1, weights)
    assert_allclose(other.coefficients, found.coefficients, rtol=0, atol=1e-12)
    assert_allclose(other.residual, found.residual, rtol=1e-10)


def test_a_half_sphere_is_ill_conditioned_and_says_so(random_directions) -> None:
    directions = random_directions(500)
    half = directions * np.where(directions[:, 2:] < 0, -1, 1)
    whole_sphere, half_sphere = fit(directions, np.ones(500), 4), fit(half, np.ones(500), 4)
    assert whole_sphere.condition < 3
    assert half_sphere.condition > 100


@pytest.mark.parametrize(("number", "order"), [(0, 0), (3, 1), (24, 4)])
def test_too_few_samples(random_directions, number: int, order: int) -> None:
    expected = f"^directions: {number} samples do not determine the {count(order)} harmonics of order {order}, at least"
    with pytest.raises(HarmonicFaceError, match=expected):
        fit(random_directions(max(number, 1))[:number], np.ones(number), order)


def test_enough_samples_on_too_few_directions(random_directions) -> None:
    expected = r"^directions: 40 samples do not determine the 9 harmonics of order 2, their directions determine 5$"
    with pytest.raises(HarmonicFaceError, match=expected):
        fit(np.tile(random_directions(5), (8, 1)), np.ones(40), 2)
    circle = np.linspace(0, 2 * np.pi, 50, endpoint=False)
    equator = np.stack([np.cos(circle), np.sin(circle), 0 * circle], axis=1)
    with pytest.raises(HarmonicFaceError, match=r"50 samples .* order 2, their directions determine 5"):
        fit(equator, np.ones(50), 2)


def test_samples_left_by_their_weights_are_too_few(random_directions) -> None:
    weights = np.zeros(30)
    weights[:4] = 1
    with pytest.raises(HarmonicFaceError, match="4 samples do not determine the 9 harmonics of order 2"):
        fit(random_directions(30), np.ones(30), 2, weights)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"directions": np.ones((20, 3))}, "directions: expected unit vectors"),
        ({"directions": np.full((20, 3), np.nan)}, "directions: expected finite numbers"),
        ({"directions": [0.0, 0.0, 1.0]}, r"directions: expected shape \(n, 3\), got \(3,\)"),
        ({"values": np.ones(19)}, "values: expected 20 of them, one a direction"),
        ({"values": np.ones((20, 2, 2))}, "values: expected 20 of them, one a direction"),
        ({"values": np.full(20, np.inf)}, "values: expected finite numbers"),
        ({"weights": np.ones(3)}, "weights: expected 20 numbers of at least 0"),
        ({"weights": np.linspace(-1, 1, 20)}, "weights: expected 20 numbers of at least 0, got .*, least -1"),
        ({"order": -1}, "order: expected an integer of at least 0"),
    ],
)
def test_bad_input(random_directions, changes: dict, message: str) -> None:
    arguments = {"directions": random_directions(20), "values": np.ones(20), "order": 2, **changes}
    with pytest.raises(HarmonicFaceError, match=message):
        fit(**arguments)


def test_more_than_the_memory_holds(random_directions, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("harmonicface._memory.physical_memory", lambda: 10**4)
    with pytest.raises(HarmonicFaceError, match=r"a fit of order 2 to 100 samples: need 2.16e-05 GB of memory"):
        fit(random_directions(100), np.ones(100), 2)
