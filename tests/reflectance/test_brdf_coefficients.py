"""Coefficients of BRDFs against integrals written here: scipy's complex harmonics over two half spheres."""

from __future__ import annotations

import math
import tracemalloc

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import sph_harm_y

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.complex import complex_harmonics
from harmonicface.reflectance import _brdf_quadrature
from harmonicface.reflectance.brdf import Lambertian, Microfacet, Phong, Ward, values
from harmonicface.reflectance.brdf_coefficients import (
    anisotropic_coefficients,
    coefficients_at_angle,
    isotropic_coefficients,
)
from harmonicface.reflectance.filters import lambertian_filter
from harmonicface.reflectance.spectra import degree_norms


def angles(nodes: int, limit: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Polar angles by Gauss in theta up to a limit, even azimuths: theta, phi, directions and weights."""
    at, weights = np.polynomial.legendre.leggauss(nodes)
    theta, phi = np.meshgrid(limit / 2 * (at + 1), np.arange(2 * nodes) * math.pi / nodes, indexing="ij")
    points = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    measure = (limit / 2 * weights)[:, None] * np.sin(theta) * math.pi / nodes
    return theta.ravel(), phi.ravel(), points.reshape(-1, 3), measure.ravel()


def brute_force(function, order: int, nodes: int, limit: float = math.pi / 2) -> np.ndarray:
    """Return rho_ln,pq = integral of the function times Y_ln(in) conj(Y_pq(out)), both over a (half) sphere."""
    theta, phi, points, weights = angles(nodes, limit)
    table = function(points[:, None], points[None])
    harmonics = np.array([sph_harm_y(k, m, theta, phi) for k in range(order + 1) for m in range(-k, k + 1)]) * weights
    return harmonics @ table @ harmonics.conj().T


def spread(isotropic: np.ndarray) -> np.ndarray:
    """Return isotropic coefficients in the table of anisotropic ones."""
    order = len(isotropic) - 1
    table = np.zeros(((order + 1) ** 2,) * 2)
    for low in range(order + 1):
        for out in range(order + 1):
            for mode in range(-min(low, out), min(low, out) + 1):
                table[low**2 + low + mode, out**2 + out + mode] = isotropic[low, out, abs(mode)]
    return table


def turned_ward(incoming: np.ndarray, outgoing: np.ndarray) -> np.ndarray:
    cosine, sine = math.cos(0.5), math.sin(0.5)
    turn = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]])
    return Ward(0.5, 0.9)(incoming @ turn, outgoing @ turn)


@pytest.mark.parametrize(
    ("form", "factor"),
    [
        ("reciprocal", lambda i, o: i[..., 2] * o[..., 2]),
        ("transfer", lambda i, o: i[..., 2]),
    ],
)
def test_isotropic_against_brute_force(form: str, factor) -> None:
    phong = Phong(7)
    expected = brute_force(lambda i, o: phong(i, o) * factor(i, o), 4, 28)
    assert_allclose(spread(isotropic_coefficients(phong, 4, form=form)), expected, rtol=0, atol=1e-7)


def test_a_smooth_kernel_on_the_whole_sphere() -> None:
    def kernel(i, o):
        return (2 + (i * o).sum(axis=-1) + 0.5 * i[..., 2] * o[..., 2] + 0.3 * o[..., 2]) ** 2

    expected = brute_force(kernel, 4, 24, math.pi)
    assert_allclose(spread(isotropic_coefficients(kernel, 4, form="kernel")), expected, rtol=0, atol=1e-11)
    assert_allclose(anisotropic_coefficients(kernel, 4, form="kernel", tolerance=1e-10), expected, rtol=0, atol=1e-11)


def test_the_microfacet_model_against_brute_force() -> None:
    # the lobe narrows to nothing at the horizon, where an even grid of azimuths converges slowly: a fine one
    nodes, order, model = 160, 6, Microfacet(0.3)
    at, weights = np.polynomial.legendre.leggauss(nodes)
    theta, weights = math.pi / 4 * (at + 1), math.pi / 4 * weights * np.sin(math.pi / 4 * (at + 1))
    turn = (np.arange(800) + 0.5) * math.pi / 800
    incoming = np.stack([np.sin(theta), 0 * theta, np.cos(theta)], axis=-1)[:, None, None]
    outgoing = np.stack(
        np.broadcast_arrays(
            np.sin(theta)[:, None] * np.cos(turn), np.sin(theta)[:, None] * np.sin(turn), np.cos(theta)[:, None]
        ),
        axis=-1,
    )
    table = np.concatenate([values(model, each[None], outgoing) for each in incoming])
    found = isotropic_coefficients(model, order)
    for low, out, mode in [(0, 0, 0), (1, 2, 1), (3, 3, 3), (5, 6, 0), (6, 6, 4)]:
        polar = sph_harm_y(low, mode, theta, 0.0).real * weights, sph_harm_y(out, mode, theta, 0.0).real * weights
        wave = 4 * math.pi * (math.pi / 800) * (table @ np.cos(mode * turn))
        assert_allclose(found[low, out, mode], polar[0] @ wave @ polar[1], rtol=0, atol=2e-6)


def test_a_matte_surface_in_closed_form() -> None:
    clamped = lambertian_filter(30) / degree_norms(30)
    found = isotropic_coefficients(Lambertian(0.6), 30)
    assert_allclose(found[:, :, 0], 0.6 / math.pi * np.outer(clamped, clamped), rtol=0, atol=1e-12)
    assert np.abs(found[:, :, 1:]).max() < 1e-12


def test_anisotropic_against_brute_force() -> None:
    def function(i, o):
        return turned_ward(i, o) * i[..., 2] * o[..., 2]

    # the root of the cosines converges slowly at the horizon on this grid
    assert_allclose(anisotropic_coefficients(turned_ward, 4), brute_force(function, 4, 40), rtol=0, atol=2e-5)


def test_reciprocity_of_an_anisotropic_brdf_is_hermitian_and_not_symmetric() -> None:
    found = anisotropic_coefficients(turned_ward, 6, tolerance=1e-8)
    assert_allclose(found, found.conj().T, rtol=0, atol=1e-9)
    assert np.abs(found - found.T).max() > 0.01  # as section 4.3.2 of the paper would have it


def test_turning_the_tangent_multiplies_by_phases() -> None:
    modes = np.concatenate([np.arange(-k, k + 1) for k in range(7)])
    phases = np.exp(1j * 0.5 * (modes[:, None] - modes))
    plain, turned = (
        anisotropic_coefficients(Ward(0.5, 0.9), 6, tolerance=1e-8),
        anisotropic_coefficients(turned_ward, 6, tolerance=1e-8),
    )
    assert_allclose(turned, phases * plain, rtol=0, atol=1e-8)


@pytest.mark.parametrize("model", [Phong(20), Microfacet(0.3), Ward(0.4, 0.4)])
def test_both_expansions_of_an_isotropic_brdf_agree(model) -> None:
    assert_allclose(
        anisotropic_coefficients(model, 8, 5, tolerance=1e-8),
        spread(isotropic_coefficients(model, 8))[:, :36],
        rtol=0,
        atol=1e-8,
    )


@pytest.mark.parametrize("model", [Phong(20), Microfacet(0.3)])
def test_isotropic_coefficients_are_symmetric_and_the_same_at_any_order(model) -> None:
    found = isotropic_coefficients(model, 10)
    assert_allclose(found, found.transpose(1, 0, 2), rtol=0, atol=1e-14)
    assert_allclose(isotropic_coefficients(model, 4, 7), found[:5, :8, :5], rtol=0, atol=1e-9)


def test_the_series_returns_to_the_brdf() -> None:
    rng = np.random.default_rng(0)
    incoming, outgoing = rng.normal(size=(2, 40, 3))
    incoming, outgoing = (np.abs(d / np.linalg.norm(d, axis=-1, keepdims=True)) for d in (incoming, outgoing))
    table = spread(isotropic_coefficients(Phong(5), 40))
    series = np.einsum("an,ab,bn->n", complex_harmonics(incoming, 40).conj(), table, complex_harmonics(outgoing, 40))
    assert_allclose(series.imag, 0, atol=1e-12)
    assert_allclose(series.real, values(Phong(5), incoming, outgoing), rtol=0, atol=0.01)


@pytest.mark.parametrize("model", [Phong(20), Microfacet(0.3)])
def test_one_outgoing_angle_integrates_to_the_whole(model) -> None:
    at, weights = np.polynomial.legendre.leggauss(40)
    root = (at + 1) / 2
    theta = np.arccos(root**2)
    kernels = np.array([coefficients_at_angle(model, 6, each) for each in theta])  # theta_o, l, q
    expected = isotropic_coefficients(model, 6)
    for mode in range(7):
        for out in range(mode, 7):
            polar = sph_harm_y(out, mode, theta, 0.0).real * weights * root * math.sqrt(2 * math.pi)
            assert_allclose(polar @ kernels[:, :, mode], expected[:, out, mode], rtol=0, atol=1e-7)


def test_along_the_normal_only_q_0_is_left_and_is_the_lobe() -> None:
    found = coefficients_at_angle(Phong(20), 8, 0.0)
    at, weights = np.polynomial.legendre.leggauss(40)
    cosine = (at + 1) / 2
    for degree in range(9):
        polar = sph_harm_y(degree, 0, np.arccos(cosine), 0.0).real
        expected = (2 * math.pi) ** 1.5 * (weights / 2 * polar * 22 / (2 * math.pi) * cosine**21).sum()
        assert_allclose(found[degree, 0], expected, rtol=0, atol=1e-9)
    assert np.abs(found[:, 1:]).max() < 1e-12


def test_the_mirror_over_half_a_sphere_is_not_the_papers_diagonal() -> None:
    # equation 66 integrates over theta up to pi / 2: half on the diagonal, and odd l - p do not vanish
    theta, phi, _, weights = angles(24, math.pi / 2)
    mirrored = [sph_harm_y(k, 1, theta, phi + math.pi).conj() for k in (1, 2, 3)]
    table = np.array([[(sph_harm_y(k, 1, theta, phi) * each * weights).sum() for each in mirrored] for k in (1, 2, 3)])
    assert_allclose(np.diag(table), -0.5, atol=1e-12)
    assert abs(table[0, 2]) < 1e-12
    assert abs(table[0, 1]) > 0.1


def test_with_a_cosine_in_the_denominator_nothing_settles(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_brdf_quadrature, "MOST_ISOTROPIC", 80)
    with pytest.raises(
        HarmonicFaceError, match=r"settle to 1e-07 of the largest, got a change of 0.00\d+ at 80 angles"
    ):
        isotropic_coefficients(Microfacet(0.3), 4, form="transfer")


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: isotropic_coefficients(Phong(2), -1), "order: expected an integer of at least 0, got int -1"),
        (lambda: isotropic_coefficients(Phong(2), 2, -1), "outgoing_order: expected an integer of at least 0"),
        (
            lambda: isotropic_coefficients(Phong(2), 10**5),
            r"BRDF of order 100000 by 100000 on 140023 angles: need .* GB",
        ),
        (lambda: anisotropic_coefficients(Phong(2), 1000), r"BRDF of order 1000 by 1000 on 1412 angles: need .* GB"),
        (lambda: coefficients_at_angle(Phong(2), 10**6, 0.1), "BRDF of order 1000000 on 1400045 angles: need .* GB"),
        (lambda: isotropic_coefficients(Phong(2), 2, form="cosine"), "form: expected one of"),
        (lambda: anisotropic_coefficients(Phong(2), 2, form="cosine"), "form: expected one of"),
        (lambda: coefficients_at_angle(Phong(2), 2, 0.1, form="cosine"), "form: expected one of"),
        (lambda: isotropic_coefficients(Phong(2), 2, tolerance=0.0), "tolerance: expected a finite number above 0"),
        (lambda: coefficients_at_angle(Phong(2), 2, 1.6), "outgoing_angle: expected radians from 0 to 1.5708, got 1.6"),
        (lambda: coefficients_at_angle(Phong(2), 2, math.nan), "outgoing_angle: expected finite numbers"),
        (lambda: coefficients_at_angle(Phong(2), 2, [0.1, 0.2]), "outgoing_angle: expected one number"),
        (lambda: isotropic_coefficients(7, 2), "brdf: expected a function"),
        (lambda: anisotropic_coefficients(None, 2), "brdf: expected a function"),
        (
            lambda: isotropic_coefficients(lambda i, o: np.sqrt(i[..., 0] + 0 * o[..., 0]), 2),
            "brdf's values: expected finite numbers",
        ),
        (
            lambda: anisotropic_coefficients(lambda i, o: i[..., 0] + 0 * o[..., 0], 2),
            "brdf: expected values of at least 0",
        ),
        (lambda: anisotropic_coefficients(lambda i, o: np.ones(3), 2), "brdf: expected values of shape"),
        (
            lambda: isotropic_coefficients(Ward(0.2, 0.5), 2),
            "expected an isotropic one, got .* turned about the normal",
        ),
        (lambda: coefficients_at_angle(Ward(0.05, 0.2), 2, 0.3), "expected an isotropic one"),
        (
            lambda: isotropic_coefficients(lambda i, o: 1 + np.cross(i, o)[..., 2], 2),
            "expected an isotropic one, got .* mirrored; use anisotropic_coefficients",
        ),
    ],
)
@pytest.mark.filterwarnings("ignore:invalid value encountered in sqrt")
def test_bad_input(call, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message) as raised:
        call()
    assert "\n" not in str(raised.value)


def test_a_dark_material_is_zero() -> None:
    assert not isotropic_coefficients(lambda i, o: 0 * i[..., 0] * o[..., 0], 3).any()


EXPANSIONS = [
    (lambda: anisotropic_coefficients(Ward(0.3, 0.6), 8, tolerance=1e-2), "BRDF of order 8 by 8 on 23 angles: need"),
    (lambda: isotropic_coefficients(Phong(5), 30, tolerance=1e-2), "BRDF of order 30 by 30 on 65 angles: need"),
    (lambda: coefficients_at_angle(Phong(5), 60, 0.3, tolerance=1e-2), "BRDF of order 60 on 129 angles: need"),
]


@pytest.mark.parametrize(("expand", "message"), EXPANSIONS)
def test_what_is_asked_of_the_memory_holds_what_is_taken(monkeypatch: pytest.MonkeyPatch, expand, message) -> None:
    monkeypatch.setattr("harmonicface.reflectance._brdf_quadrature.BLOCK", 1)
    asked: list[int] = []
    monkeypatch.setattr("harmonicface.reflectance.brdf_coefficients.require", lambda needed, _: asked.append(needed))
    tracemalloc.start()
    expand()
    taken = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert 0.4 * max(asked) < taken < 1.2 * max(asked)


@pytest.mark.parametrize(("expand", "message"), EXPANSIONS)
def test_the_refinement_is_refused_before_anything_is_expanded(monkeypatch, expand, message: str) -> None:
    monkeypatch.setattr("harmonicface._memory.physical_memory", lambda: 10**6)
    with pytest.raises(HarmonicFaceError, match=message):
        expand()
