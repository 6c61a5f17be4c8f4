"""Flatland's reflection: each equation of the papers against the integral that it stands for."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad

from harmonicface.errors import HarmonicFaceError
from harmonicface.reflectance.flatland import (
    light_field,
    reflect_flat,
    reflect_flat_directly,
    transfer_coefficients,
)
from harmonicface.reflectance.flatland_series import circle_angles, fourier_basis, fourier_coefficients, fourier_series


def light(angle: np.ndarray) -> np.ndarray:
    return 1 + 0.6 * np.cos(angle - 0.4) + 0.3 * np.sin(3 * angle) - 0.2 * np.cos(5 * angle)


def transfer(incident: np.ndarray, outgoing: np.ndarray) -> np.ndarray:
    # smooth over the whole circle to machine precision, so that its series may be compared with it
    lobe = np.exp(-8 * (1 - np.cos(incident + outgoing)))
    inside = np.exp(-12 * (1 - np.cos(incident))) * np.exp(-12 * (1 - np.cos(outgoing)))
    return lobe * inside * (1 + 0.3 * np.sin(incident))


def test_the_transfer_functions_series_is_the_transfer_function() -> None:
    angles = circle_angles(96)
    found = transfer_coefficients(transfer(angles[:, None], angles), 30, 30)
    some = np.linspace(-1, 1, 7)
    incident, outgoing = fourier_basis(some, 30).conj(), fourier_basis(some, 30)  # equation 17
    values = np.einsum("lp,li,po->io", found, incident, outgoing)
    assert_allclose(values, transfer(some[:, None], some), rtol=0, atol=1e-8)


def test_a_reciprocal_transfer_function_has_symmetric_coefficients() -> None:
    angles = circle_angles(64)
    samples = transfer(angles[:, None], angles)
    found = transfer_coefficients(samples + samples.T, 12, 12)
    assert_allclose(found, found[::-1, ::-1].T, rtol=0, atol=1e-14)  # rho_lp = rho_(-p)(-l)


def test_convolution_equals_the_reflection_integral() -> None:
    angles = circle_angles(96)
    coefficients = reflect_flat(
        fourier_coefficients(light(angles), 30), transfer_coefficients(transfer(angles[:, None], angles), 30, 30)
    )
    normals, outgoing = np.linspace(-3, 3, 9), np.linspace(-1.2, 1.2, 7)
    direct = reflect_flat_directly(light, transfer, normals, outgoing)
    assert_allclose(light_field(coefficients, normals, outgoing), direct, rtol=0, atol=1e-7)


def test_a_clamped_transfer_function_to_its_truncation() -> None:
    # the light ends at degree 5, so no more of the incidence is needed, whatever the kink at the horizon
    angles = circle_angles(4096)
    samples = np.maximum(np.cos(angles), 0)[:, None] * np.ones(4)
    rho = fourier_coefficients(samples[:, 0], 5)
    field = reflect_flat(fourier_coefficients(light(angles), 5), rho[::-1])  # F_l^* of incidence: degree -l
    direct = reflect_flat_directly(light, lambda i, o: np.cos(i) + 0 * o, np.linspace(-3, 3, 9), [0.0])[:, 0]
    assert_allclose(fourier_series(field, np.linspace(-3, 3, 9)), direct, rtol=0, atol=1e-6)


def test_a_fixed_outgoing_angle() -> None:
    # equation 22: B_l(theta_o) = sqrt(2 pi) L_l rho_l(theta_o)
    angles, outgoing = circle_angles(96), np.array([-0.5, 0.2])
    rho = fourier_coefficients(transfer(angles[:, None], outgoing), 30)[::-1]
    field = reflect_flat(fourier_coefficients(light(angles), 30), rho)
    normals = np.linspace(-2, 2, 5)
    direct = reflect_flat_directly(light, transfer, normals, outgoing)
    assert_allclose(fourier_series(field, normals), direct, rtol=0, atol=1e-7)


def test_global_coordinates_give_the_same() -> None:
    # equation 7 integrates over global angles and turns the material instead of the light
    normal, outgoing = 0.9, 0.3
    value = quad(lambda a: float(light(a) * transfer(a - normal, outgoing)), normal - np.pi / 2, normal + np.pi / 2)[0]
    assert_allclose(reflect_flat_directly(light, transfer, normal, outgoing), [[value]], rtol=1e-9)


def test_errors() -> None:
    with pytest.raises(HarmonicFaceError, match=r"samples: expected \(incidence, exitance\)"):
        transfer_coefficients(np.ones(8), 2, 2)
    with pytest.raises(HarmonicFaceError, match=r"transfer: expected the light's \(3,\) degrees first"):
        reflect_flat(np.ones(3), np.ones(5))
    with pytest.raises(HarmonicFaceError, match="coefficients: expected B_lp"):
        light_field(np.ones(3), 0.0, 0.0)
    with pytest.raises(HarmonicFaceError, match="nodes: expected an integer of at least 1"):
        reflect_flat_directly(light, transfer, 0.0, 0.0, nodes=0)
    with pytest.raises(HarmonicFaceError, match="light: expected finite numbers"):
        reflect_flat_directly(lambda angle: angle * np.nan, transfer, 0.0, 0.0)
    with pytest.raises(HarmonicFaceError, match="transfer: expected finite numbers"):
        reflect_flat_directly(light, lambda incident, outgoing: incident * np.inf + outgoing, 0.0, 0.1)
