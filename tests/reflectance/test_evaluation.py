"""Reflected light from coefficients against the integral over the half sphere, written here, and where it is exact."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.lighting.environment import EnvironmentMap
from harmonicface.reflectance.brdf import Lambertian, Microfacet, Phong, Ward
from harmonicface.reflectance.brdf_coefficients import (
    anisotropic_coefficients,
    coefficients_at_angle,
    isotropic_coefficients,
)
from harmonicface.reflectance.evaluation import evaluate, evaluate_at_angle, evaluate_under_lamp
from harmonicface.reflectance.filters import lambertian_filter, lambertian_weights
from harmonicface.reflectance.outgoing_kernels import outgoing_kernels


def directions(count: int, seed: int, lowest: float = -1.0) -> np.ndarray:
    """Return random unit vectors whose z is at least the lowest."""
    rng = np.random.default_rng(seed)
    z, phi = rng.uniform(lowest, 1, count), rng.uniform(0, 2 * math.pi, count)
    return np.stack([np.sqrt(1 - z**2) * np.cos(phi), np.sqrt(1 - z**2) * np.sin(phi), z], axis=-1)


def grid(nodes: int, lowest: float) -> tuple[np.ndarray, np.ndarray]:
    """Return directions and weights of Gauss nodes in z from the lowest to 1 and even azimuths."""
    at, weights = np.polynomial.legendre.leggauss(nodes)
    z, weights = lowest + (1 - lowest) / 2 * (at + 1), (1 - lowest) / 2 * weights
    z, phi = np.meshgrid(z, np.arange(2 * nodes) * math.pi / nodes, indexing="ij")
    points = np.stack([np.sqrt(1 - z**2) * np.cos(phi), np.sqrt(1 - z**2) * np.sin(phi), z], axis=-1)
    return points.reshape(-1, 3), np.repeat(weights * math.pi / nodes, 2 * nodes)


def frames(normals: np.ndarray, gamma: float) -> np.ndarray:
    alpha, beta = np.arccos(normals[:, 2]), np.arctan2(normals[:, 1], normals[:, 0])
    return Rotation.from_euler("ZYZ", np.stack([beta, alpha, np.full_like(alpha, gamma)], axis=-1)).as_matrix()


def brute_force(radiance, brdf, normals, outgoing, gamma=0.0, nodes=120) -> np.ndarray:
    """Integrate the radiance times rho cos(theta_i) cos(theta_o), one normal and direction after the other."""
    incoming, weights = grid(nodes, 0.0)
    result = []
    for frame, out in zip(frames(normals, gamma), outgoing, strict=True):
        result.append((radiance(incoming @ frame.T) * brdf(incoming, out) * incoming[:, 2] * out[2]) @ weights)
    return np.array(result)


def lamp_and_sky(points: np.ndarray) -> np.ndarray:
    """A bright lobe of 12 degrees, a wide one and a constant: three decades of radiance."""
    lamp, window = np.array([0.6, 0.3, math.sqrt(0.55)]), np.array([-0.48, -0.6, 0.64])
    return 20 * np.exp(45 * (points @ lamp - 1)) + 2 * np.exp(6 * (points @ window - 1)) + 0.1


def coefficients(radiance, order: int) -> np.ndarray:
    points, weights = grid(order + 40, -1.0)
    return (real_harmonics(points, order) * weights) @ radiance(points)


def relative(found: np.ndarray, expected: np.ndarray) -> float:
    return float(np.linalg.norm(found - expected) / np.linalg.norm(expected))


NORMALS, OUTGOING = directions(150, 1), directions(150, 2, math.cos(math.radians(70)))


def polynomial(incoming: np.ndarray, outgoing: np.ndarray) -> np.ndarray:
    """A kernel of degree 2 in either direction."""
    return (1.5 + (incoming * outgoing * [1, 1, 0.4]).sum(axis=-1)) ** 2


def tangential(incoming: np.ndarray, outgoing: np.ndarray) -> np.ndarray:
    """An anisotropic one that is not even its own mirror image."""
    return (2 + incoming[..., 0] * outgoing[..., 1] + 0.3 * incoming[..., 2]) ** 2 + 0 * outgoing[..., 2]


@pytest.mark.parametrize("kernel", [polynomial, tangential])
def test_exact_for_what_is_band_limited(kernel) -> None:
    light = np.random.default_rng(3).normal(size=(36, 3))
    normals, outgoing = directions(12, 4), directions(12, 5)
    points, weights = grid(12, -1.0)
    expected = []
    for frame, out in zip(frames(normals, 0.7), outgoing, strict=True):
        expected.append(light.T @ real_harmonics(points @ frame.T, 5) @ (weights * kernel(points, out)))
    table = anisotropic_coefficients(kernel, 2, form="kernel", tolerance=1e-10)
    assert_allclose(evaluate(light, table, normals, outgoing, gamma=0.7), expected, rtol=0, atol=1e-11)


def test_exact_for_what_is_band_limited_and_isotropic() -> None:
    light = np.random.default_rng(3).normal(size=36)
    normals, outgoing = directions(12, 4), directions(12, 5)
    points, weights = grid(12, -1.0)
    expected = []
    for frame, out in zip(frames(normals, 0.0), outgoing, strict=True):
        expected.append(light @ real_harmonics(points @ frame.T, 5) @ (weights * polynomial(points, out)))
    table = isotropic_coefficients(polynomial, 4, 3, form="kernel")
    assert_allclose(evaluate(light, table, normals, outgoing), expected, rtol=0, atol=1e-11)


@pytest.mark.parametrize(
    ("brdf", "order", "bound"),
    [(Phong(20), 12, 1e-2), (Phong(20), 24, 1e-3), (Microfacet(0.3), 12, 1e-2), (Microfacet(0.3), 32, 3e-3)],
)
def test_the_error_up_to_70_degrees(brdf, order: int, bound: float) -> None:
    expected = brute_force(lamp_and_sky, brdf, NORMALS, OUTGOING)
    table = isotropic_coefficients(brdf, order)
    assert relative(evaluate(coefficients(lamp_and_sky, order), table, NORMALS, OUTGOING), expected) < bound


@pytest.mark.parametrize(("order", "bound"), [(10, 1e-2), (20, 2e-3)])
def test_the_error_of_an_anisotropic_material(order: int, bound: float) -> None:
    brdf = Ward(0.3, 0.6)
    expected = brute_force(lamp_and_sky, brdf, NORMALS, OUTGOING, gamma=0.4)
    table = anisotropic_coefficients(brdf, order)
    light = coefficients(lamp_and_sky, order)
    assert relative(evaluate(light, table, NORMALS, OUTGOING, gamma=0.4), expected) < bound
    assert relative(evaluate(light, table, NORMALS, OUTGOING, gamma=0.4 + math.pi / 2), expected) > 0.05


def test_phong_and_a_lamp_without_size() -> None:
    # nothing in the light helps: the error is that of the series of the BRDF itself
    lamp = np.array([0.48, 0.64, 0.6])
    light = real_harmonics(lamp, 24)
    local = np.einsum("nji,j->ni", frames(NORMALS, 0.0), lamp)
    expected = Phong(20)(local, OUTGOING) * local[:, 2] * OUTGOING[:, 2]
    assert relative(evaluate(light, isotropic_coefficients(Phong(20), 24), NORMALS, OUTGOING), expected) < 1e-2


@pytest.mark.data
@pytest.mark.parametrize("place", ["grace", "pisa"])
def test_the_error_under_measured_light(place: str, data_dir: Path) -> None:
    # every pixel of the map is a lamp of its own, and their sum is the reference
    sky = EnvironmentMap.load(data_dir / "probes" / "cube" / place, layout="cube").grey().converted("latlong", 48)
    towards, strengths = (np.asarray(each, np.float64) for each in sky.lamps())
    light = real_harmonics(towards, 16) @ strengths
    normals, outgoing = NORMALS[:30], OUTGOING[:30]
    for brdf in (Phong(20), Microfacet(0.3)):
        expected = []
        for frame, out in zip(frames(normals, 0.0), outgoing, strict=True):
            local = towards @ frame
            expected.append((strengths * brdf(local, out) * np.maximum(local[:, 2], 0)).sum() * out[2])
        found = evaluate(light, isotropic_coefficients(brdf, 16), normals, outgoing)
        assert relative(found, np.array(expected)) < 1e-2


def lit(brdf, lamp: np.ndarray, gamma: float) -> np.ndarray:
    """Return B cos(theta_o) of a lamp in closed form: the BRDF itself."""
    local = np.einsum("nji,j->ni", frames(NORMALS, gamma), lamp)
    return brdf(local, OUTGOING) * np.maximum(local[:, 2], 0) * OUTGOING[:, 2]


def test_a_lamp_and_the_jump_of_the_microfacet_model() -> None:
    lamp, table = np.array([0.48, 0.64, 0.6]), isotropic_coefficients(Microfacet(0.3), 24)
    expected = lit(Microfacet(0.3), lamp, 0.0)
    found = evaluate_under_lamp(lamp, table, NORMALS, OUTGOING)
    assert relative(found, expected) < 1e-2
    assert relative(evaluate(real_harmonics(lamp, 24), table, NORMALS, OUTGOING), expected) > 1.5e-2
    assert not found[NORMALS @ lamp <= 0].any()


def test_a_lamp_on_brushed_metal() -> None:
    lamp, table = np.array([0.48, 0.64, 0.6]), anisotropic_coefficients(Ward(0.3, 0.6), 20)
    expected = lit(Ward(0.3, 0.6), lamp, 0.4)
    for extension in ("zero", "odd"):
        assert relative(evaluate_under_lamp(lamp, table, NORMALS, OUTGOING, 0.4, extension), expected) < 1e-2
    every = evaluate_under_lamp(lamp, table, NORMALS[:4, None], OUTGOING[None, :5], 0.4)
    assert_allclose(every[3, 3], evaluate_under_lamp(lamp, table, NORMALS[3], OUTGOING[3], 0.4), atol=1e-13)


def test_without_extension_a_lamp_is_its_coefficients_and_a_sharp_terminator() -> None:
    lamp, table = np.array([0.48, 0.64, 0.6]), isotropic_coefficients(Phong(20), 9)
    found = evaluate_under_lamp(lamp, table, NORMALS, OUTGOING, extension="zero")
    series = evaluate(real_harmonics(lamp, 9), table, NORMALS, OUTGOING)
    assert_allclose(found, np.where(NORMALS @ lamp > 0, series, 0), rtol=0, atol=1e-12)


def test_the_even_extension_mends_the_jump_of_the_microfacet_model() -> None:
    expected = brute_force(lamp_and_sky, Microfacet(0.3), NORMALS, OUTGOING)
    table, light = isotropic_coefficients(Microfacet(0.3), 24), coefficients(lamp_and_sky, 24)
    plain, even = (relative(evaluate(light, table, NORMALS, OUTGOING, extension=e), expected) for e in ("zero", "even"))
    assert even < 0.6 * plain


def test_the_series_is_the_mean_of_its_even_and_odd_part() -> None:
    light, table = coefficients(lamp_and_sky, 9), isotropic_coefficients(Phong(5), 9)
    zero, even, odd = (evaluate(light, table, NORMALS, OUTGOING, extension=e) for e in ("zero", "even", "odd"))
    assert_allclose((even + odd) / 2, zero, rtol=0, atol=1e-12)


def test_a_matte_surface_reflects_its_irradiance() -> None:
    light = coefficients(lamp_and_sky, 6)
    irradiance = (lambertian_weights(6) * light) @ real_harmonics(NORMALS, 6)
    found = evaluate(light, isotropic_coefficients(Lambertian(0.5), 6), NORMALS, OUTGOING, extension="odd")
    assert lambertian_filter(6)[3] == 0
    assert_allclose(found, 0.5 / math.pi * irradiance * OUTGOING[:, 2], rtol=0, atol=1e-11)


@pytest.mark.parametrize("brdf", [Phong(20), Microfacet(0.3)])
@pytest.mark.parametrize("angle", [0.0, 0.7, math.radians(70)])
def test_one_outgoing_angle_needs_only_the_light_s_order(brdf, angle: float) -> None:
    light = np.random.default_rng(6).normal(size=81)
    normals, azimuths = directions(20, 7), np.random.default_rng(8).uniform(-3, 3, 20)
    outgoing = np.stack([np.sin(angle) * np.cos(azimuths), np.sin(angle) * np.sin(azimuths)], axis=-1)
    outgoing = np.concatenate([outgoing, np.full((20, 1), math.cos(angle))], axis=-1)
    expected = brute_force(lambda points: light @ real_harmonics(points, 8), brdf, normals, outgoing)
    found = evaluate_at_angle(light, coefficients_at_angle(brdf, 8, angle), normals, azimuths)
    assert_allclose(found, expected, rtol=0, atol=1e-7)


def test_every_normal_with_every_direction_is_the_same_as_pairs() -> None:
    light, table = np.random.default_rng(9).normal(size=(49, 3)), isotropic_coefficients(Phong(10), 6)
    normals, outgoing = directions(4, 1), directions(5, 2)
    every = evaluate(light, table, normals[:, None], outgoing[None])
    assert every.shape == (4, 5, 3)
    assert_allclose(every[3, 2], evaluate(light, table, normals[3], outgoing[2]), rtol=1e-12, atol=1e-13)
    assert_allclose(evaluate(light[:, 1], table, normals[:, None], outgoing[None]), every[..., 1], atol=1e-12)
    same = evaluate(light, table, normals[3], outgoing)
    assert_allclose(same, every[3], rtol=1e-12, atol=1e-13)
    turned = evaluate(light, table, normals[:, None], outgoing[None], gamma=np.zeros((4, 5)))
    assert_allclose(turned, every, rtol=1e-12, atol=1e-13)


def test_turning_the_frame_of_an_isotropic_material_turns_only_phi() -> None:
    light, table = np.random.default_rng(9).normal(size=49), isotropic_coefficients(Phong(10), 6)
    turn = Rotation.from_euler("z", 0.6).as_matrix()
    turned = evaluate(light, table, NORMALS, OUTGOING @ turn, gamma=0.6)
    assert_allclose(turned, evaluate(light, table, NORMALS, OUTGOING), rtol=0, atol=1e-12)


def test_the_lower_order_counts() -> None:
    light, table = np.random.default_rng(9).normal(size=49), isotropic_coefficients(Phong(10), 4)
    assert_allclose(evaluate(light, table, NORMALS, OUTGOING), evaluate(light[:25], table, NORMALS, OUTGOING))
    assert_allclose(evaluate(light[:9], table, NORMALS, OUTGOING), evaluate(light[:9], table[:3], NORMALS, OUTGOING))
    kernel = coefficients_at_angle(Phong(10), 4, 0.5)
    assert_allclose(evaluate_at_angle(light, kernel, NORMALS, 0.3), evaluate_at_angle(light[:25], kernel, NORMALS, 0.3))


UP = [0.0, 0.0, 1.0]
NOT_REAL = np.diag([1.0, 1j, 0, 0])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: evaluate([1.0, 2.0], np.ones((1, 1, 1)), UP, UP), "coefficients: expected .order . 1..2 of them"),
        (lambda: evaluate([1.0], np.ones((2, 2, 1)), UP, UP), r"brdf: expected isotropic coefficients \(l, p, q\)"),
        (lambda: evaluate([1.0], np.ones((3, 4)), UP, UP), "coefficients: expected .order . 1..2 of them"),
        (lambda: evaluate([1.0], np.ones((4, 3)), UP, UP), "coefficients: expected .order . 1..2 of them"),
        (lambda: evaluate([1.0], np.full((1, 1, 1), np.nan), UP, UP), "brdf: expected finite numbers"),
        (lambda: evaluate([1.0], np.full((1, 1), np.nan), UP, UP), "or finite anisotropic ones"),
        (lambda: evaluate([1.0], np.ones(3), UP, UP), "brdf: expected isotropic coefficients"),
        (
            lambda: evaluate(np.ones(4), NOT_REAL, UP, UP),
            "brdf: expected coefficients of a real function, .* differ by",
        ),
        (lambda: evaluate([1.0], np.ones((1, 1, 1)), UP, [0, 0, 2.0]), "outgoing: expected unit vectors"),
        (lambda: evaluate([1.0], np.ones((1, 1, 1)), [0, 0, 0.0], UP), "normals: expected unit vectors"),
        (
            lambda: evaluate([1.0], np.ones((1, 1, 1)), NORMALS[:3], OUTGOING[:2]),
            r"outgoing: expected ones that broadcast with \(3,\) normals, got \(2,\)",
        ),
        (
            lambda: evaluate([1.0], np.ones((1, 1, 1)), NORMALS[:3], UP, gamma=np.zeros(2)),
            "gamma: expected angles that broadcast",
        ),
        (lambda: evaluate_under_lamp([UP, UP], np.ones((1, 1, 1)), UP, UP), r"lamp: expected one direction \(3,\)"),
        (lambda: evaluate_under_lamp([0, 0, 2.0], np.ones((1, 1, 1)), UP, UP), "lamp: expected unit vectors"),
        (lambda: evaluate_under_lamp(UP, np.ones((1, 1, 1)), UP, UP, 0.0, "mirror"), "extension: expected one of"),
        (
            lambda: evaluate_under_lamp(UP, np.ones((1, 1, 1)), NORMALS[:3], OUTGOING[:2]),
            r"outgoing: expected ones that broadcast with \(3,\) normals",
        ),
        (lambda: outgoing_kernels(np.ones((1, 1, 1)), UP, "mirror"), "extension: expected one of zero, even, odd"),
        (lambda: evaluate_at_angle([1.0], np.ones((2, 3)), UP, 0.0), r"kernel: expected .* shape \(l \+ 1, l \+ 1\)"),
        (lambda: evaluate_at_angle([1.0], np.ones((1, 1)), UP, np.nan), "azimuths: expected finite numbers"),
        (
            lambda: evaluate_at_angle([1.0], np.ones((1, 1)), NORMALS[:3], [0.0, 1.0]),
            r"azimuths: expected ones that broadcast with \(3,\) normals, got \(2,\)",
        ),
    ],
)
def test_bad_input(call, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message) as raised:
        call()
    assert "\n" not in str(raised.value)
