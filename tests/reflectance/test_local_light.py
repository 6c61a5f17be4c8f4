"""Tangent frames and the light that they see, against scipy's rotations and the complex matrices of the paper."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation
from scipy.special import sph_harm_y

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.complex import to_complex
from harmonicface.reflectance.local_light import local_light, tangent_frames

angle = st.floats(-math.pi, math.pi)


def unit(count: int, seed: int = 0) -> np.ndarray:
    points = np.random.default_rng(seed).normal(size=(count, 3))
    return points / np.linalg.norm(points, axis=-1, keepdims=True)


def normal(alpha: float, beta: float) -> np.ndarray:
    return np.array([math.sin(alpha) * math.cos(beta), math.sin(alpha) * math.sin(beta), math.cos(alpha)])


@given(st.floats(1e-6, math.pi - 1e-6), angle, angle)
@settings(deadline=None)
def test_frames_are_the_papers_rotation(alpha: float, beta: float, gamma: float) -> None:
    expected = Rotation.from_euler("ZYZ", [beta, alpha, gamma]).as_matrix()
    assert_allclose(tangent_frames(normal(alpha, beta), gamma), expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("z", [1.0, -1.0])
def test_frames_at_the_poles(z: float) -> None:
    expected = Rotation.from_euler("ZYZ", [0, 0 if z > 0 else math.pi, 0.3]).as_matrix()
    assert_allclose(tangent_frames([0, 0, z], 0.3), expected, rtol=0, atol=1e-15)


def test_frames_broadcast_with_the_angles() -> None:
    frames = tangent_frames(unit(4)[:, None], np.linspace(0, 1, 3))
    assert frames.shape == (4, 3, 3, 3)
    assert_allclose(frames @ frames.swapaxes(-1, -2), np.broadcast_to(np.eye(3), frames.shape), atol=1e-14)


@given(st.floats(0, math.pi), angle, angle)
@settings(max_examples=30, deadline=None)
def test_the_local_light_is_the_light_at_turned_directions(alpha: float, beta: float, gamma: float) -> None:
    light = np.random.default_rng(1).normal(size=100)
    points = unit(20)
    frame = tangent_frames(normal(alpha, beta), gamma)
    seen = local_light(light, normal(alpha, beta), gamma)
    assert_allclose(seen @ real_harmonics(points, 9), light @ real_harmonics(points @ frame.T, 9), rtol=0, atol=1e-12)


def test_the_papers_formula_with_matrices_by_quadrature() -> None:
    # D^l_mm' by equation 26, harmonics by scipy, for one rotation
    alpha, beta, gamma = 0.7, -1.1, 2.0
    at, weights = np.polynomial.legendre.leggauss(8)
    theta, phi = (each.ravel() for each in np.meshgrid(np.arccos(at), np.arange(16) * math.pi / 8, indexing="ij"))
    points = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    turned = points @ Rotation.from_euler("ZYZ", [beta, alpha, gamma]).as_matrix().T
    light = np.random.default_rng(2).normal(size=16)
    expected = np.zeros(16, complex)
    for degree in range(4):
        for out in range(-degree, degree + 1):
            for mode in range(-degree, degree + 1):
                there = sph_harm_y(degree, mode, np.arccos(turned[:, 2]), np.arctan2(turned[:, 1], turned[:, 0]))
                here = sph_harm_y(degree, out, theta, phi).conj()
                matrix = (np.repeat(weights * math.pi / 8, 16) * there * here).sum()
                expected[degree**2 + degree + out] += to_complex(light)[degree**2 + degree + mode] * matrix
    assert_allclose(to_complex(local_light(light, normal(alpha, beta), gamma)), expected, rtol=0, atol=1e-13)


def test_an_upright_frame_sees_the_light_as_it_is() -> None:
    light = np.random.default_rng(3).normal(size=(49, 3))
    assert_allclose(local_light(light, [0.0, 0.0, 1.0]), light, rtol=0, atol=1e-13)


def test_turning_keeps_the_energy_of_every_degree_at_order_64() -> None:
    light = np.random.default_rng(4).normal(size=65**2)
    seen = local_light(light, unit(3), 0.4)
    starts = np.arange(65) ** 2
    before, after = np.add.reduceat(light**2, starts), np.add.reduceat(seen**2, starts)
    assert_allclose(after, np.repeat(before[:, None], 3, axis=1), rtol=1e-11)


def test_shapes() -> None:
    assert local_light(np.ones(9), unit(6).reshape(2, 3, 3)).shape == (9, 2, 3)
    assert local_light(np.ones((9, 3)), unit(6)).shape == (9, 6, 3)
    assert local_light(np.ones(9), unit(2)[:, None], np.zeros(5)).shape == (9, 2, 5)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: local_light(np.ones(5), [0, 0, 1.0]), "coefficients: expected .order . 1..2 of them"),
        (lambda: local_light(np.ones((1, 3, 2)), [0, 0, 1.0]), r"light: expected .*\(k,\) or \(k, channels\)"),
        (lambda: local_light([np.nan], [0, 0, 1.0]), "light: expected finite numbers"),
        (lambda: local_light([1.0], [0, 0, 2.0]), "normals: expected unit vectors, got one of length 2"),
        (lambda: local_light([1.0], [0, 0, 1.0], np.nan), "gamma: expected finite numbers"),
        (lambda: tangent_frames([0, 0, 0.0]), "normals: expected unit vectors"),
        (lambda: local_light([1.0], unit(2), np.zeros(3)), r"gamma: expected angles that broadcast .* \(2, 3\)"),
        (lambda: tangent_frames(unit(2), np.zeros(3)), r"gamma: expected angles that broadcast .* \(2, 3\)"),
        (lambda: tangent_frames([0, 0, 1.0], np.inf), "gamma: expected finite numbers"),
        (
            lambda: local_light(np.ones(1001**2), np.broadcast_to([0, 0, 1.0], (10**6, 3))),
            r"light of order 1000 at 1000000 normals: need 8.02e\+03 GB of memory",
        ),
    ],
)
def test_bad_input(call, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        call()
