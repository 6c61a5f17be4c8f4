"""Rotation of coefficients against evaluation at rotated directions, composition, and quadrature."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import count
from harmonicface.harmonics.quadrature import project
from harmonicface.harmonics.rotation import rotate, rotation_blocks


@pytest.mark.parametrize("order", [2, 9, 64])
def test_evaluation_at_rotated_directions(random_directions, awkward_rotations, order: int) -> None:
    directions = random_directions(40)
    coefficients = np.random.default_rng(1).normal(size=count(order))
    here = real_harmonics(directions, order)
    for name, rotation in awkward_rotations.items():
        expected = coefficients @ real_harmonics(rotation.inv().apply(directions), order)
        assert_allclose(rotate(coefficients, rotation) @ here, expected, rtol=0, atol=2e-11, err_msg=name)


def test_order_64_is_orthogonal_and_composes(awkward_rotations) -> None:
    blocks = {name: rotation_blocks(rotation, 64) for name, rotation in awkward_rotations.items()}
    for name, matrices in blocks.items():
        for matrix in matrices:
            assert_allclose(matrix @ matrix.T, np.eye(len(matrix)), rtol=0, atol=1e-11, err_msg=name)
    for name in ("half about x", "almost about z", "half about a slanted axis", "generic"):
        for other in ("half about y", "about z only", "another"):
            both = rotation_blocks(awkward_rotations[name] * awkward_rotations[other], 64)
            for left, right, product in zip(blocks[name], blocks[other], both, strict=True):
                assert_allclose(left @ right, product, rtol=0, atol=1e-11, err_msg=f"{name} after {other}")


def test_order_200_stays_finite_and_orthogonal(awkward_rotations, random_directions) -> None:
    coefficients = np.random.default_rng(2).normal(size=count(200))
    directions = random_directions(5)
    for name in ("half about x", "generic"):
        rotation = awkward_rotations[name]
        turned = rotate(coefficients, rotation)
        assert np.isfinite(turned).all()
        assert_allclose(np.linalg.norm(turned), np.linalg.norm(coefficients), rtol=1e-12)
        expected = coefficients @ real_harmonics(rotation.inv().apply(directions), 200)
        assert_allclose(turned @ real_harmonics(directions, 200), expected, rtol=0, atol=1e-9)


def test_degree_1_is_the_rotation_itself(awkward_rotations) -> None:
    for name, rotation in awkward_rotations.items():
        constant, linear = rotation_blocks(rotation, 1)
        assert_array_equal(constant, [[1.0]])
        expected = rotation.as_matrix()[[1, 2, 0]][:, [1, 2, 0]]  # y, z, x
        assert_allclose(linear, expected, rtol=0, atol=2e-15, err_msg=name)


def test_blocks_are_integrals_of_rotated_harmonics(awkward_rotations) -> None:
    rotation = awkward_rotations["generic"]
    order = 5
    integrals = project(lambda n: real_harmonics(rotation.apply(n), order).T, order)  # (k of here, k of there)
    for degree, matrix in enumerate(rotation_blocks(rotation, order)):
        inside = slice(degree**2, (degree + 1) ** 2)
        assert_allclose(integrals[inside, inside].T, matrix, rtol=0, atol=1e-13)


def test_rotate_and_blocks_are_the_same(awkward_rotations) -> None:
    coefficients = np.random.default_rng(3).normal(size=(count(6), 3))
    for name, rotation in awkward_rotations.items():
        parts = [
            matrix @ coefficients[degree**2 : (degree + 1) ** 2]
            for degree, matrix in enumerate(rotation_blocks(rotation.as_matrix(), 6))
        ]
        assert_allclose(rotate(coefficients, rotation), np.concatenate(parts), rtol=0, atol=1e-14, err_msg=name)
        assert_allclose(rotate(coefficients[:, 0], rotation), np.concatenate(parts)[:, 0], rtol=0, atol=1e-14)


@settings(deadline=None, max_examples=40)
@given(
    st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: sum(x * x for x in q) > 1e-6),
    st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: sum(x * x for x in q) > 1e-6),
)
def test_rotations_compose_and_invert(first: tuple[float, ...], second: tuple[float, ...]) -> None:
    coefficients = np.random.default_rng(4).normal(size=count(8))
    one, two = Rotation.from_quat(first), Rotation.from_quat(second)
    assert_allclose(rotate(rotate(coefficients, one), two), rotate(coefficients, two * one), rtol=0, atol=1e-12)
    assert_allclose(rotate(rotate(coefficients, one), one.inv()), coefficients, rtol=0, atol=1e-12)


def test_types_and_inputs_are_kept() -> None:
    coefficients = np.arange(9, dtype=np.float32)
    turned = rotate(coefficients, Rotation.from_euler("x", 1.0))
    assert turned.dtype == np.float32
    assert_array_equal(coefficients, np.arange(9))
    assert rotate([1, 2, 3, 4], np.eye(3, dtype=int)).dtype == np.float64


@pytest.mark.parametrize(
    ("rotation", "message"),
    [
        (np.diag([1.0, 1.0, -1.0]), "expected an orthogonal matrix of determinant 1, got determinant -1"),
        (2 * np.eye(3), "expected an orthogonal matrix of determinant 1, got determinant 8"),
        (np.eye(4), r"expected a scipy Rotation or a 3 x 3 matrix, got shape \(4, 4\)"),
        (np.full((3, 3), np.nan), "expected finite numbers"),
        ("north", "expected an array of real numbers"),
        (Rotation.random(2, rng=np.random.default_rng(0)), "expected one rotation, got 2 of them"),
    ],
)
def test_no_rotation(rotation: object, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=f"rotation: {message}"):
        rotate(np.ones(4), rotation)
    with pytest.raises(HarmonicFaceError, match=f"rotation: {message}"):
        rotation_blocks(rotation, 1)


@pytest.mark.parametrize(
    ("coefficients", "message"),
    [
        (np.ones(5), r"coefficients: expected \(order \+ 1\)\^2 of them"),
        (np.ones((4, 2, 2)), r"coefficients: expected shape \(k,\) or \(k, channels\), got \(4, 2, 2\)"),
        ([1.0, np.inf, 0.0, 0.0], "coefficients: expected finite numbers"),
        (np.zeros(1026**2), "order: expected at most 1024 for rotations, got 1025"),
    ],
)
def test_no_coefficients(coefficients: object, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        rotate(coefficients, np.eye(3))


@pytest.mark.parametrize(
    ("order", "message"), [(-1, "order: expected an integer"), (10**6, "order: expected at most 1024")]
)
def test_no_order(order: int, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        rotation_blocks(np.eye(3), order)


def test_blocks_beyond_the_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("harmonicface._memory.physical_memory", lambda: 10**9)
    with pytest.raises(HarmonicFaceError, match=r"rotation matrices up to order 1000: need 10.7 GB of memory"):
        rotation_blocks(np.eye(3), 1000)
