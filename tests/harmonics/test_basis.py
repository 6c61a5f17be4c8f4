"""Real harmonics against closed forms, quadrature, and two other implementations."""

from __future__ import annotations

import numpy as np
import pytest
import sphericart
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.special import eval_legendre, sph_harm_y

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics import basis
from harmonicface.harmonics.basis import real_harmonics, scaled_harmonics
from harmonicface.harmonics.indexing import count, degrees, index


def random_directions(number: int, seed: int = 0) -> np.ndarray:
    vectors = np.random.default_rng(seed).normal(size=(number, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def sphere_rule(degree: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights that integrate polynomials of that degree over the sphere exactly: Gauss by trapezoid."""
    z, weights = np.polynomial.legendre.leggauss(degree // 2 + 1)
    angles = 2 * np.pi * np.arange(degree + 1) / (degree + 1)
    across = np.sqrt(1 - z**2)[:, None]
    nodes = np.stack(np.broadcast_arrays(across * np.cos(angles), across * np.sin(angles), z[:, None]), axis=-1)
    return nodes.reshape(-1, 3), np.repeat(weights * 2 * np.pi / (degree + 1), degree + 1)


def from_scipy(directions: np.ndarray, order: int) -> np.ndarray:
    """The real harmonics out of scipy's complex ones, its Condon-Shortley phase taken out."""
    polar, azimuth = np.arccos(directions[:, 2]), np.arctan2(directions[:, 1], directions[:, 0])
    rows = []
    for degree in range(order + 1):
        for mode in range(-degree, degree + 1):
            complex_one = (-1) ** mode * sph_harm_y(degree, abs(mode), polar, azimuth)
            part = complex_one.real if mode >= 0 else complex_one.imag
            rows.append(part * (np.sqrt(2) if mode else 1))
    return np.array(rows)


def test_the_nine_polynomials() -> None:
    x, y, z = (directions := random_directions(300)).T
    expected = [
        0.282095 * np.ones_like(x),
        0.488603 * y,
        0.488603 * z,
        0.488603 * x,
        1.092548 * x * y,
        1.092548 * y * z,
        0.315392 * (3 * z**2 - 1),
        1.092548 * x * z,
        0.546274 * (x**2 - y**2),
    ]
    assert_allclose(real_harmonics(directions, 2), expected, rtol=0, atol=1e-6)


def test_the_nine_constants_in_closed_form() -> None:
    x, y, z = (directions := random_directions(300)).T
    root = np.sqrt(1 / np.pi)
    expected = [
        root / 2 * np.ones_like(x),
        np.sqrt(3) * root / 2 * y,
        np.sqrt(3) * root / 2 * z,
        np.sqrt(3) * root / 2 * x,
        np.sqrt(15) * root / 2 * x * y,
        np.sqrt(15) * root / 2 * y * z,
        np.sqrt(5) * root / 4 * (3 * z**2 - 1),
        np.sqrt(15) * root / 2 * x * z,
        np.sqrt(15) * root / 4 * (x**2 - y**2),
    ]
    assert_allclose(real_harmonics(directions, 2), expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize("order", [0, 2, 8, 12])
def test_orthonormal_over_the_sphere(order: int) -> None:
    nodes, weights = sphere_rule(2 * order)
    assert_allclose(weights.sum(), 4 * np.pi, rtol=1e-13)
    harmonics = real_harmonics(nodes, order)
    assert_allclose((harmonics * weights) @ harmonics.T, np.eye(count(order)), rtol=0, atol=1e-12)


@pytest.mark.parametrize("order", [16, 64])
def test_equal_to_scipy(order: int) -> None:
    directions = random_directions(100, seed=1)
    assert_allclose(real_harmonics(directions, order), from_scipy(directions, order), rtol=0, atol=1e-11)


def test_equal_to_sphericart() -> None:
    directions = random_directions(200, seed=2)
    other = sphericart.SphericalHarmonics(16).compute(directions)  # the same order, axes and phase, a row a direction
    assert_allclose(real_harmonics(directions, 16), other.T, rtol=0, atol=1e-12)


@pytest.mark.parametrize("order", [1, 5, 40])
def test_addition_theorem(order: int) -> None:
    first, second = random_directions(50, seed=3), random_directions(50, seed=4)
    cosines = np.einsum("ij,ij->i", first, second)
    products = real_harmonics(first, order) * real_harmonics(second, order)
    for degree in range(order + 1):
        ours = products[degrees(order) == degree].sum(axis=0)
        assert_allclose(ours, (2 * degree + 1) / (4 * np.pi) * eval_legendre(degree, cosines), rtol=0, atol=1e-11)


@pytest.mark.parametrize("pole", [1.0, -1.0])
def test_at_the_poles_only_mode_zero_is_left(pole: float) -> None:
    harmonics = real_harmonics([0.0, 0.0, pole], 10)
    expected = np.zeros(count(10))
    for degree in range(11):
        expected[index(degree, 0)] = pole**degree * np.sqrt((2 * degree + 1) / (4 * np.pi))
    assert_allclose(harmonics, expected, rtol=0, atol=1e-14)


def test_high_degrees_stay_finite_and_normalized() -> None:
    directions = np.vstack([random_directions(20), [[0, 0, 1], [1, 0, 0], [1e-12, 0, 1]]])
    squares = (real_harmonics(directions, 200) ** 2).sum(axis=0)
    assert_allclose(squares, count(200) / (4 * np.pi), rtol=1e-10)


@settings(deadline=None, max_examples=50)
@given(st.floats(0, np.pi), st.floats(-np.pi, np.pi))
def test_opposite_directions_differ_by_the_degrees_parity(polar: float, azimuth: float) -> None:
    sine = np.sin(polar)
    direction = np.array([sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(polar)])
    parity = (-1.0) ** degrees(6)
    assert_allclose(real_harmonics(-direction, 6), parity * real_harmonics(direction, 6), rtol=0, atol=1e-13)


def test_single_precision_stays_single_within_rounding() -> None:
    directions = random_directions(500)
    single = real_harmonics(directions.astype(np.float32), 4)
    assert single.dtype == np.float32
    assert_allclose(single, real_harmonics(directions, 4), rtol=0, atol=2e-6)
    assert real_harmonics([[0, 0, 1]], 1).dtype == np.float64


@pytest.mark.parametrize("shape", [(), (0,), (7,), (2, 5), (2, 1, 3)])
def test_one_contiguous_row_a_harmonic_for_any_shape(shape: tuple[int, ...]) -> None:
    directions = random_directions(int(np.prod(shape))).reshape(*shape, 3)
    harmonics = real_harmonics(directions, 3)
    assert harmonics.shape == (16, *shape)
    assert harmonics.flags.c_contiguous
    flat = real_harmonics(directions.reshape(-1, 3), 3)
    assert_array_equal(harmonics.reshape(16, -1), flat)


def test_the_result_goes_where_it_is_told() -> None:
    directions = random_directions(11)
    out = np.full((9, 11), np.nan)
    assert real_harmonics(directions, 2, out=out) is out
    assert_array_equal(out, real_harmonics(directions, 2))


@pytest.mark.parametrize(
    "out",
    [np.empty((9, 4)), np.empty((4, 5)), np.empty((9, 5), np.float32), np.empty((5, 9)).T, [0.0] * 9],
    ids=["pixels", "order", "type", "order in memory", "list"],
)
def test_a_place_that_does_not_fit(out: np.ndarray) -> None:
    with pytest.raises(HarmonicFaceError, match=r"out: expected a C-contiguous array of shape \(9, 5\) .*, got"):
        real_harmonics(random_directions(5), 2, out=out)


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_same_whatever_the_blocks_and_threads(order: int, dtype: type, monkeypatch: pytest.MonkeyPatch) -> None:
    directions = random_directions(5000).astype(dtype)
    whole = real_harmonics(directions, order)
    monkeypatch.setattr(basis, "LOW_BLOCK", 700)
    monkeypatch.setattr(basis, "BLOCK", 700)
    assert_array_equal(real_harmonics(directions, order), whole)
    monkeypatch.setattr(basis, "THREADED_SIZE", 1)
    monkeypatch.setattr(basis, "_cores", lambda: 3)
    assert_array_equal(real_harmonics(directions, order), whole)


@pytest.mark.parametrize("order", [0, 1, 2, 5])
@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e30, 0.5, -1.002])
@pytest.mark.parametrize("place", [0, 1234, 4999])
def test_one_bad_vector_is_found_in_any_block(
    order: int, bad: float, place: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(basis, "LOW_BLOCK", 1000)
    monkeypatch.setattr(basis, "BLOCK", 1000)
    directions = random_directions(5000).astype(np.float32)
    directions[place] = [0, 0, bad]
    with pytest.raises(HarmonicFaceError, match=r"directions: expected (finite numbers|unit vectors), got"):
        real_harmonics(directions, order)
    monkeypatch.setattr(basis, "THREADED_SIZE", 1)
    monkeypatch.setattr(basis, "_cores", lambda: 2)
    with pytest.raises(HarmonicFaceError, match=r"directions: expected (finite numbers|unit vectors), got"):
        real_harmonics(directions, order)


def test_directions_in_any_memory_order() -> None:
    directions = random_directions(600)
    expected = real_harmonics(directions, 2)
    assert_array_equal(real_harmonics(np.asfortranarray(directions), 2), expected)
    assert_array_equal(real_harmonics(directions[::-1], 2), expected[:, ::-1])
    image = np.ascontiguousarray(directions.reshape(20, 30, 3).transpose(2, 0, 1)).transpose(1, 2, 0)
    assert_array_equal(real_harmonics(image, 2), expected.reshape(9, 20, 30))


def test_more_than_the_memory_holds_is_refused_at_once() -> None:
    directions = np.broadcast_to([0.0, 0.0, 1.0], (10**9, 3))
    expected = r"^harmonics of order 5000 at directions of shape \(1000000000,\): need 2e\+08 GB of memory, expected"
    with pytest.raises(HarmonicFaceError, match=expected):
        real_harmonics(directions, 5000)


@pytest.mark.parametrize(
    ("directions", "order", "message"),
    [
        ([[0, 0, 0]], 2, "directions: expected unit vectors, got one of length 0"),
        (1.0, 2, "directions: expected vectors of shape"),
        ([[0, 0, 2]], 2, "directions: expected unit vectors, got one of length 2"),
        ([[0, 0, np.nan]], 2, "directions: expected finite numbers"),
        ([[0, 1]], 2, "directions: expected vectors"),
        ([[0, 0, 1]], -1, "order: expected an integer of at least 0"),
    ],
)
def test_bad_input(directions: list, order: int, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        real_harmonics(directions, order)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("order", [0, 1, 2, 3, 6])
def test_scaled_harmonics_are_harmonics_times_weights_and_factors(order: int, dtype: type) -> None:
    directions = random_directions(70_001).astype(dtype)  # more than one block
    rng = np.random.default_rng(1)
    weights, factors = rng.normal(size=order + 1), rng.normal(size=len(directions))
    weights[order // 2] = 0
    expected = real_harmonics(directions, order) * weights[degrees(order)][:, None] * factors
    out = np.empty(((order + 1) ** 2, len(directions)), dtype)
    found = scaled_harmonics(directions, order, weights, factors, out)
    assert found is out
    assert_allclose(found, expected, rtol=0, atol=1e-14 if dtype is np.float64 else 4e-6)


def test_scaled_harmonics_of_nothing() -> None:
    assert scaled_harmonics(np.zeros((0, 3)), 2, np.ones(3), np.zeros(0)).shape == (9, 0)


def test_scaled_harmonics_by_threads_are_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    directions, factors = random_directions(1000), np.random.default_rng(2).normal(size=1000)
    alone = scaled_harmonics(directions, 2, np.ones(3), factors)
    monkeypatch.setattr(basis, "THREADED_SIZE", 1)
    monkeypatch.setattr(basis, "_cores", lambda: 3)
    assert_array_equal(scaled_harmonics(directions, 2, np.ones(3), factors), alone)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.zeros((2, 2, 3)), 1, np.ones(2), np.ones(4)), r"directions: expected vectors of shape \(n, 3\)"),
        ((np.zeros((4, 2)), 1, np.ones(2), np.ones(4)), r"directions: expected vectors of shape \(..., 3\)"),
        ((np.zeros((4, 3)), -1, np.ones(2), np.ones(4)), "order: expected"),
        ((np.zeros((4, 3)), 1, np.ones(3), np.ones(4)), r"weights: expected shape \(2,\)"),
        ((np.zeros((4, 3)), 1, [1, np.inf], np.ones(4)), "weights: expected finite"),
        ((np.zeros((4, 3)), 1, np.ones(2), np.ones(5)), r"factors: expected shape \(4,\)"),
        ((np.zeros((4, 3)), 1, np.ones(2), [1, 2, np.nan, 4]), "factors: expected finite"),
        ((np.zeros((4, 3)), 1, np.ones(2), np.ones(4), np.zeros((3, 4))), "out: expected a C-contiguous array"),
    ],
)
def test_bad_scales_are_refused(arguments: tuple, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        scaled_harmonics(*arguments)
