"""The convolution formulas against integrals of the light field written here, with scipy's harmonics and rotations."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation
from scipy.special import sph_harm_y

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.complex import to_complex
from harmonicface.reflectance.brdf import Microfacet, Phong
from harmonicface.reflectance.brdf_coefficients import (
    anisotropic_coefficients,
    coefficients_at_angle,
    isotropic_coefficients,
)
from harmonicface.reflectance.estimation import estimate_reflectance
from harmonicface.reflectance.evaluation import evaluate
from harmonicface.reflectance.lightfield import (
    about_reflection,
    anisotropic_light_field,
    light_field,
    light_field_at_angle,
)
from harmonicface.reflectance.lightfield_projection import project_light_field
from harmonicface.reflectance.phong import phong_filter
from harmonicface.reflectance.spectra import apply_filter, degree_norms

ORDER = 2
LIGHT = np.random.default_rng(0).normal(size=9)


def sphere(nodes: int) -> tuple[np.ndarray, np.ndarray]:
    """Polar angle and azimuth of Gauss nodes and even azimuths, (2, n), and their weights."""
    at, weights = np.polynomial.legendre.leggauss(nodes)
    theta, phi = np.meshgrid(np.arccos(at), np.arange(2 * nodes) * math.pi / nodes, indexing="ij")
    return np.stack([theta.ravel(), phi.ravel()]), np.repeat(weights * math.pi / nodes, 2 * nodes)


def vectors(angles: np.ndarray) -> np.ndarray:
    theta, phi = angles
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)


def angles(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return np.arccos(np.clip(points[..., 2], -1, 1)), np.arctan2(points[..., 1], points[..., 0])


def isotropic(incoming: np.ndarray, outgoing: np.ndarray) -> np.ndarray:
    """A kernel of degree 2 in either direction."""
    return (1.5 + (incoming * outgoing * [1, 1, 0.4]).sum(axis=-1)) ** 2


def anisotropic(incoming: np.ndarray, outgoing: np.ndarray) -> np.ndarray:
    """One that knows the tangent and is not its own mirror image."""
    return 3 + incoming[..., 0] * outgoing[..., 1] + 0.7 * incoming[..., 2] * outgoing[..., 0]


def reflect(kernel, gamma: float = 0.0) -> tuple[np.ndarray, ...]:
    """Integrate the light field at a grid of normals and outgoing directions: B, frames and the grid."""
    grid, weights = sphere(7)
    points = vectors(grid)
    frames = Rotation.from_euler("ZYZ", np.stack([grid[1], grid[0], np.full(len(points), gamma)], axis=-1)).as_matrix()
    light = np.einsum("k,kni->ni", LIGHT, real_harmonics(np.einsum("nij,mj->nmi", frames, points), ORDER))
    return light @ (kernel(points[:, None], points[None]) * weights[:, None]), frames, grid, weights


def wigner(frames: np.ndarray, degree: int, mode: int, other: int) -> np.ndarray:
    """D^l_mm' of many rotations by equation 26."""
    grid, weights = sphere(4)
    turned = sph_harm_y(degree, mode, *angles(np.einsum("nij,mj->nmi", frames, vectors(grid))))
    return turned @ (weights * sph_harm_y(degree, other, *grid).conj())


@pytest.fixture(scope="module")
def reflected() -> tuple[np.ndarray, ...]:
    return reflect(isotropic)


def test_equation_49(reflected) -> None:
    field, frames, grid, weights = reflected
    found = light_field(LIGHT, isotropic_coefficients(isotropic, ORDER, 3, form="kernel"))
    assert found.shape == (9, 4, 3)
    for degree in range(3):
        for mode in range(-degree, degree + 1):
            for out in range(4):
                for twin in range(-min(degree, out), min(degree, out) + 1):
                    basis = wigner(frames, degree, mode, twin) / math.sqrt(4 * math.pi / (2 * degree + 1))
                    harmonic = sph_harm_y(out, twin, *grid)
                    expected = (weights * basis.conj()) @ field @ (weights * harmonic.conj())
                    assert_allclose(found[degree**2 + degree + mode, out, abs(twin)], expected, rtol=0, atol=1e-10)


def test_equation_51(reflected) -> None:
    _, frames, grid, weights = reflected
    angle, turns = 0.6, np.arange(8) * math.pi / 4
    outgoing = vectors(np.stack([np.full(8, angle), turns]))
    table = isotropic_coefficients(isotropic, ORDER, form="kernel")
    field = evaluate(LIGHT, table, vectors(grid)[:, None], outgoing[None])
    found = light_field_at_angle(LIGHT, coefficients_at_angle(isotropic, ORDER, angle, form="kernel"))
    for degree, mode, twin in [(0, 0, 0), (1, 1, 1), (1, 0, -1), (2, -2, 1), (2, 1, 2), (2, 0, -2)]:
        basis = wigner(frames, degree, mode, twin) / math.sqrt(4 * math.pi / (2 * degree + 1)) / math.sqrt(2 * math.pi)
        expected = (weights * basis.conj()) @ field @ np.exp(-1j * twin * turns) * (math.pi / 4)
        sign = (-1) ** twin if twin < 0 else 1
        assert_allclose(sign * found[degree**2 + degree + mode, abs(twin)], expected, rtol=0, atol=1e-10)


def test_equations_39_and_40() -> None:
    table = anisotropic_coefficients(anisotropic, ORDER, 1, form="kernel")
    whole = anisotropic_light_field(LIGHT, table)
    out = np.array([0.48, 0.6, 0.64])
    at_one = anisotropic_light_field(LIGHT, table, out)
    turns = np.arange(8) * math.pi / 4
    fields = [reflect(anisotropic, turn) for turn in turns]
    grid, weights = fields[0][2:]
    for degree, mode, twin in [(0, 0, 0), (1, -1, 1), (1, 1, 0), (1, 0, -1), (2, 2, 1), (2, -1, 0)]:
        scale = math.sqrt((2 * degree + 1) / (8 * math.pi**2))
        bases = [scale * wigner(frames, degree, mode, twin).conj() * weights for _, frames, _, _ in fields]
        projected = sum(basis @ field for basis, (field, *_) in zip(bases, fields, strict=True)) * math.pi / 4
        for place, (low, high) in enumerate([(0, 0), (1, -1), (1, 0), (1, 1)]):
            expected = projected @ (weights * sph_harm_y(low, high, *grid).conj())
            assert_allclose(whole[degree][degree + mode, degree + twin, place], expected, rtol=0, atol=1e-10)
        harmonics = np.array([sph_harm_y(k, m, *angles(out)) for k, m in [(0, 0), (1, -1), (1, 0), (1, 1)]])
        expected = whole[degree][degree + mode, degree + twin] @ harmonics
        assert_allclose(at_one[degree][degree + mode, degree + twin], expected, rtol=0, atol=1e-12)


def test_the_projection_of_a_light_field_is_the_convolution() -> None:
    table = isotropic_coefficients(Phong(5), 4, 3)
    light = np.random.default_rng(1).normal(size=25)
    found = project_light_field(lambda normals, outgoing: evaluate(light, table, normals, outgoing), 4, 3)
    assert_allclose(found, light_field(light, table), rtol=0, atol=1e-12)
    finer = project_light_field(lambda normals, outgoing: evaluate(light, table, normals, outgoing), 2, nodes=9)
    assert_allclose(finer, light_field(light[:9], table[:3, :3, :3]), rtol=0, atol=1e-12)


def test_a_lamp_above_the_pole_shows_the_brdf_itself() -> None:
    # equation 64: B_l0pq = rho_lpq, and nothing for m other than 0
    table = isotropic_coefficients(Microfacet(0.3), 5)
    found = light_field(real_harmonics([0.0, 0.0, 1.0], 5), table)
    centres = [degree * (degree + 1) for degree in range(6)]
    assert_allclose(found[centres], table, rtol=0, atol=1e-14)
    assert np.abs(np.delete(found, centres, axis=0)).max() == 0


def test_uniform_light_shows_only_rho_0p0() -> None:
    # equation 65
    table = isotropic_coefficients(Phong(9), 3)
    found = light_field(np.eye(16)[0] / math.sqrt(4 * math.pi), table)
    assert_allclose(found[0, :, 0], table[0, :, 0], rtol=0, atol=1e-15)
    assert np.abs(found[1:]).max() == 0
    assert np.abs(found[0, :, 1:]).max() == 0


def lobe(incoming: np.ndarray, outgoing: np.ndarray) -> np.ndarray:
    """The paper's Phong transfer function, equation 75: no horizon."""
    return 21 / (2 * math.pi) * np.maximum((incoming * outgoing * [-1, -1, 1]).sum(axis=-1), 0) ** 20


def test_about_the_reflection_vector_phong_depends_on_one_angle() -> None:
    found = isotropic_coefficients(about_reflection(lobe, form="kernel"), 10, 3, form="kernel", tolerance=1e-7)
    response = phong_filter(20, 10) / degree_norms(10)  # rho_l, of a function that is the same for all outgoing
    assert_allclose(found[:, 0, 0], math.sqrt(4 * math.pi) * response, rtol=0, atol=1e-7)
    found[:, 0, 0] = 0
    assert np.abs(found).max() < 1e-7


def test_about_the_reflection_vector_the_same_light_comes_back() -> None:
    rng = np.random.default_rng(2)
    light, table = (
        rng.normal(size=16),
        isotropic_coefficients(about_reflection(isotropic, "kernel"), 3, 40, "kernel", 1e-3),
    )
    normals, eyes = rng.normal(size=(2, 20, 3))
    normals, eyes = (each / np.linalg.norm(each, axis=-1, keepdims=True) for each in (normals, eyes))
    eyes *= np.sign((normals * eyes).sum(axis=-1, keepdims=True))
    mirrored = 2 * (normals * eyes).sum(axis=-1, keepdims=True) * normals - eyes

    def seen(axes: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
        theta, phi = angles(axes)
        frames = Rotation.from_euler("ZY", np.stack([phi, theta], axis=-1)).as_matrix()
        return evaluate(light, coefficients, axes, np.einsum("nji,nj->ni", frames, eyes))

    expected = seen(normals, isotropic_coefficients(isotropic, 3, form="kernel"))
    assert np.linalg.norm(seen(mirrored, table) - expected) < 1e-2 * np.linalg.norm(expected)


def test_a_mirror_under_blurred_light_is_the_gloss_under_the_light() -> None:
    light = np.random.default_rng(3).normal(size=(49, 3))
    grid, weights = sphere(60)
    for reflection in ([0.0, 0.6, 0.8], [-0.48, 0.64, -0.6]):
        gloss = 21 / (2 * math.pi) * np.maximum(vectors(grid) @ reflection, 0) ** 20 * weights
        expected = light.T @ (real_harmonics(vectors(grid), 6) @ gloss)
        blurred = apply_filter(phong_filter(20, 9), light)
        assert_allclose(blurred.T @ real_harmonics(reflection, 6), expected, rtol=0, atol=1e-9)
        assert_allclose(apply_filter(np.ones(7), blurred), blurred, rtol=0, atol=0)  # the mirror's filter


def test_the_brdf_comes_back_where_the_light_is_known() -> None:
    # equation 58, over all m
    light, table = np.random.default_rng(4).normal(size=25), isotropic_coefficients(Microfacet(0.3), 4)
    found = estimate_reflectance(light_field(light, table), to_complex(light), noise=1e-9)
    lengths = degree_norms(4)[:, None, None]
    assert_allclose(np.asarray(found.filter) / lengths, table, rtol=0, atol=1e-12)


def test_the_lower_order_counts() -> None:
    table = isotropic_coefficients(Phong(5), 3)
    assert light_field(LIGHT, table).shape == (9, 4, 3)
    assert light_field(np.ones(36), table).shape == (16, 4, 4)


UP = [0.0, 0.0, 1.0]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: light_field(LIGHT, np.eye(4)), r"brdf: expected isotropic coefficients \(l, p, q\)"),
        (lambda: light_field(np.ones((9, 3)), np.ones((3, 3, 3))), r"light: expected one channel, \(k,\)"),
        (lambda: light_field([1.0, np.inf], np.ones((3, 3, 3))), "light: expected finite numbers"),
        (lambda: light_field(np.ones(10), np.ones((3, 3, 3))), "coefficients: expected .order . 1..2 of them"),
        (
            lambda: light_field(np.ones(301**2), np.broadcast_to(1.0, (301, 301, 301))),
            "light field of order 300 by 300: need 131 GB of memory",
        ),
        (lambda: light_field_at_angle(LIGHT, np.ones((2, 3))), r"kernel: expected shape \(l \+ 1, l \+ 1\)"),
        (lambda: anisotropic_light_field(LIGHT, np.ones((3, 3, 3))), r"brdf: expected anisotropic coefficients"),
        (lambda: anisotropic_light_field(LIGHT, np.eye(4), [0, 0, 3.0]), "outgoing: expected unit vectors"),
        (lambda: anisotropic_light_field(LIGHT, np.eye(4), [UP, UP]), r"outgoing: expected one direction \(3,\)"),
        (
            lambda: anisotropic_light_field(np.ones(61**2), np.ones((61**2, 21**2))),
            "anisotropic light field of order 60: need 2.14 GB",
        ),
        (lambda: about_reflection(0.5)(np.array(UP), np.array(UP)), "brdf: expected a function"),
        (lambda: project_light_field(0.5, 2), "field: expected a function of .normals, outgoing., got float 0.5"),
        (lambda: project_light_field(lambda n, o: n[..., 2], 2), r"field: expected values of shape \(50, 50\)"),
        (lambda: project_light_field(lambda n, o: np.nan * n * o, 2), "field's values: expected finite numbers"),
        (lambda: project_light_field(lambda n, o: n, -1), "order: expected an integer of at least 0"),
        (lambda: project_light_field(lambda n, o: n, 1, -1), "outgoing_order: expected an integer of at least 0"),
        (lambda: project_light_field(lambda n, o: n, 1, nodes=0), "nodes: expected an integer of at least 1"),
        (
            lambda: project_light_field(lambda n, o: n, 500),
            "light field sampled at 1001 polar angles: need 3.21e.04 GB",
        ),
    ],
)
def test_bad_input(call, message: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("harmonicface._memory.physical_memory", lambda: 10**9)
    with pytest.raises(HarmonicFaceError, match=message) as raised:
        call()
    assert "\n" not in str(raised.value)
