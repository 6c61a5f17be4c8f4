"""The matrices d^l and D^l against closed forms, their defining sum, quadrature, and their properties."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics import wigner
from harmonicface.harmonics.complex import complex_harmonics
from harmonicface.harmonics.wigner import quarter_turn, wigner_d, wigner_matrix

ANGLES = np.concatenate([np.linspace(-np.pi, np.pi, 17), [0.3, 1e-9, np.pi - 1e-9, 2.9]])


def through_a_quarter_turn(degree: int, alpha: np.ndarray) -> np.ndarray:
    """The way that degrees above 2 go, for any degree."""
    modes = np.arange(-degree, degree + 1)
    quarter = wigner._whole(quarter_turn(degree))
    powers = np.array([1, 1j, -1, -1j])[modes % 4]
    middle = (quarter * np.exp(1j * modes * alpha[:, None])[:, None]) @ quarter.T
    return powers[:, None] * middle * powers.conj()


def equation_29(degree: int, xi: Fraction) -> np.ndarray:
    """The paper's formula, a derivative of a polynomial in xi = sin^2(alpha / 2), in exact fractions."""
    result = np.zeros((2 * degree + 1, 2 * degree + 1))
    for m in range(-degree, degree + 1):
        for n in range(-degree, degree + 1):
            derivative = Fraction(0)  # of xi^(l - n) (1 - xi)^(l + n), l - m times
            for k in range(degree + n + 1):
                power = degree - n + k - (degree - m)
                if power >= 0:
                    term = (-1) ** k * math.comb(degree + n, k) * math.perm(degree - n + k, degree - m)
                    derivative += term * xi**power
            below = math.prod(math.factorial(degree + k) for k in (-m, n, -n))
            scale = (-1) ** (m - n) * math.sqrt(math.factorial(degree + m) / below)
            powers = float(xi) ** ((n - m) / 2) * float(1 - xi) ** (-(m + n) / 2)
            result[m + degree, n + degree] = scale * powers * float(derivative)
    return result


def test_degree_1_in_closed_form() -> None:
    c, s = np.cos(0.7), np.sin(0.7)
    half = [np.cos(0.35) ** 2, np.sin(0.35) ** 2]
    edge = s / np.sqrt(2)
    expected = [[half[0], edge, half[1]], [-edge, c, edge], [half[1], -edge, half[0]]]
    assert_allclose(wigner_d(1, 0.7), expected, rtol=0, atol=1e-15)


def test_degree_2_in_closed_form() -> None:
    """Equation 30 of the 2004 paper, entry by entry."""
    a = 0.7
    c, s = np.cos(a / 2), np.sin(a / 2)
    p, q, r = 2 * c**3 * s, 2 * c * s**3, 0.5 * np.sqrt(1.5) * np.sin(a) ** 2
    t = np.sqrt(1.5) * np.cos(a) * np.sin(a)
    u, v = c**2 * (-1 + 2 * np.cos(a)), s**2 * (1 + 2 * np.cos(a))
    expected = [
        [c**4, p, r, q, s**4],
        [-p, u, t, v, q],
        [r, -t, 0.5 * (3 * np.cos(a) ** 2 - 1), t, r],
        [-q, v, -t, u, p],
        [s**4, -q, r, -p, c**4],
    ]
    assert_allclose(wigner_d(2, a), expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize("degree", [0, 1, 2])
def test_the_recursion_gives_the_closed_forms(degree: int) -> None:
    general = through_a_quarter_turn(degree, ANGLES)
    assert_allclose(general.real, wigner_d(degree, ANGLES), rtol=0, atol=1e-14)
    assert_allclose(general.imag, 0, rtol=0, atol=1e-14)


@pytest.mark.parametrize("degree", [0, 1, 2, 3, 5, 12])
def test_the_papers_general_formula(degree: int) -> None:
    for xi in (Fraction(1, 100), Fraction(1, 7), Fraction(1, 2), Fraction(29, 31)):
        alpha = 2 * math.asin(math.sqrt(xi))
        assert_allclose(wigner_d(degree, alpha), equation_29(degree, xi), rtol=0, atol=1e-13)


@pytest.mark.parametrize("degree", [1, 2, 3, 10, 64])
def test_harmonics_of_rotated_directions(random_directions, degree: int) -> None:
    directions = random_directions(30)
    alpha, beta, gamma = 2.1, -0.8, 4.0
    rotation = Rotation.from_euler("ZYZ", [beta, alpha, gamma]).as_matrix()
    here, there = complex_harmonics(directions, degree), complex_harmonics(directions @ rotation.T, degree)
    inside = slice(degree**2, None)
    assert_allclose(wigner_matrix(degree, alpha, beta, gamma) @ here[inside], there[inside], rtol=0, atol=2e-12)


@pytest.mark.parametrize(("degree", "tolerance"), [(0, 1e-14), (1, 1e-14), (2, 1e-14), (3, 1e-14), (64, 1e-12)])
def test_the_two_properties(degree: int, tolerance: float) -> None:
    scale = np.sqrt(4 * np.pi / (2 * degree + 1))
    inside = slice(degree**2, None)
    for alpha in ANGLES[8:]:  # 0 to pi: a polar angle
        for beta, gamma in ((0.4, 1.1), (-2.0, 0.0)):
            back = complex_harmonics([-np.sin(alpha), 0.0, np.cos(alpha)], degree)[inside]
            assert_allclose(
                wigner_matrix(degree, alpha, beta, 0.0)[degree], scale * back.conj(), rtol=0, atol=tolerance
            )
            towards = [np.sin(alpha) * np.cos(beta), np.sin(alpha) * np.sin(beta), np.cos(alpha)]
            assert_allclose(
                wigner_matrix(degree, alpha, beta, gamma)[:, degree],
                scale * complex_harmonics(towards, degree)[inside],
                rtol=0,
                atol=tolerance,
            )


@pytest.mark.parametrize(("degree", "tolerance"), [(2, 1e-14), (64, 1e-13), (200, 1e-12)])
def test_orthogonal_at_every_angle(degree: int, tolerance: float) -> None:
    for alpha in (0.0, 1e-9, 0.3, np.pi / 2, 3.0, np.pi):
        matrix = wigner_d(degree, alpha)
        assert_allclose(matrix @ matrix.T, np.eye(2 * degree + 1), rtol=0, atol=tolerance)


def test_no_turn_and_a_half_turn() -> None:
    degree = 64
    assert_allclose(wigner_d(degree, 0.0), np.eye(129), rtol=0, atol=1e-13)
    flipped = np.diag((-1.0) ** (degree + np.arange(-degree, degree + 1)))[:, ::-1]
    assert_allclose(wigner_d(degree, np.pi), flipped, rtol=0, atol=1e-12)


def test_the_corner_of_the_largest_degree_is_no_zero() -> None:
    quarter = quarter_turn(wigner.LARGEST_DEGREE)
    assert quarter[-1, -1] == pytest.approx(2.0**-wigner.LARGEST_DEGREE, rel=1e-10)
    rows = wigner._whole(quarter)[::97]
    assert_allclose(rows @ rows.T, np.eye(len(rows)), rtol=0, atol=1e-12)


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 12), st.floats(-7, 7), st.floats(-7, 7))
def test_turns_about_y_add_up(degree: int, first: float, second: float) -> None:
    product = wigner_d(degree, first) @ wigner_d(degree, second)
    assert_allclose(product, wigner_d(degree, first + second), rtol=0, atol=1e-12)


def test_many_angles_at_once() -> None:
    angles = ANGLES[:6].reshape(2, 3)
    stacked = wigner_matrix(3, angles, 0.5, angles[:, :1])
    assert stacked.shape == (2, 3, 7, 7)
    assert_allclose(stacked[1, 2], wigner_matrix(3, angles[1, 2], 0.5, angles[1, 0]), rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("degree", "alpha", "message"),
    [
        (-1, 0.0, "degree: expected an integer of at least 0"),
        (1025, 0.0, "degree: expected at most 1024 for rotations, got 1025"),
        (2, np.nan, "alpha: expected finite numbers"),
        (1000, np.broadcast_to(0.1, 10**7), r"matrices of degree 1000 at 10000000 angles: need .* GB of memory"),
    ],
)
def test_bad_input(degree: int, alpha: float, message: str) -> None:
    for function in (wigner_d, wigner_matrix):
        with pytest.raises(HarmonicFaceError, match=message):
            function(degree, alpha)


def test_angles_that_do_not_broadcast() -> None:
    with pytest.raises(HarmonicFaceError, match=r"expected shapes that broadcast, got \(2,\), \(3,\), \(\)"):
        wigner_matrix(1, [0.0, 1.0], [0.0, 1.0, 2.0])
