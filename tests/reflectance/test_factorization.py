"""Factorization of light fields: both come back, and what cannot is named."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.complex import to_complex
from harmonicface.harmonics.indexing import degrees
from harmonicface.reflectance.brdf import Lambertian, Microfacet, Phong, Ward
from harmonicface.reflectance.brdf_coefficients import isotropic_coefficients
from harmonicface.reflectance.evaluation import evaluate
from harmonicface.reflectance.factorization import Factorization, factor_light_field
from harmonicface.reflectance.lightfield import light_field
from harmonicface.reflectance.lightfield_projection import project_light_field


def some_light(order: int, seed: int = 0) -> np.ndarray:
    light = np.random.default_rng(seed).normal(size=(order + 1) ** 2) / (1 + degrees(order))
    light[0] = 2 + abs(light[0])
    return light


def scaled(found: Factorization, light: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return light and BRDF on the scale of the true light's constant part."""
    factor = light[0] / found.light[0]
    return found.light * factor, found.brdf / factor


@pytest.mark.parametrize("brdf", [Phong(20), Phong(200), Microfacet(0.3), Microfacet(0.1), Ward(0.4, 0.4)])
@pytest.mark.parametrize("order", [0, 1, 4, 12])
def test_light_and_brdf_come_back(brdf, order: int) -> None:
    light, table = some_light(order), isotropic_coefficients(brdf, order)
    found = factor_light_field(light_field(light, table))
    assert_allclose(found.light[0], 1 / math.sqrt(4 * math.pi), rtol=1e-14)
    again, material = scaled(found, light)
    assert_allclose(again, light, rtol=0, atol=1e-11)
    assert_allclose(material, table, rtol=0, atol=1e-11)
    assert not found.ill_posed
    assert found.light_known.all()
    assert found.brdf_known[:, :, 0].all()
    assert found.residual < 1e-12


@given(st.integers(0, 10**6), st.floats(5.0, 300.0), st.floats(1e-3, 1e3))
@settings(max_examples=25, deadline=None)
def test_any_light_any_lobe_any_scale(seed: int, shininess: float, scale: float) -> None:
    light, table = some_light(5, seed), isotropic_coefficients(Phong(shininess), 5)
    field = light_field(light, table)
    found, other = factor_light_field(field), factor_light_field(scale * field)
    again, material = scaled(found, light)
    assert np.linalg.norm(again - light) < 1e-6 * np.linalg.norm(light)
    assert np.linalg.norm(material - table) < 1e-6 * np.linalg.norm(table)
    assert_allclose(other.light, found.light, rtol=0, atol=1e-9)
    assert_allclose(other.brdf, scale * found.brdf, rtol=0, atol=1e-9 * scale * np.abs(found.brdf).max())


def test_the_papers_closed_form() -> None:
    # section 5.1.3 with p = q = 0, where no rho_l00 vanishes
    light, table = some_light(3), isotropic_coefficients(Phong(20), 3)
    field = light_field(light, table)
    found = factor_light_field(field)
    lengths = np.sqrt(4 * np.pi / (2 * np.arange(4) + 1))
    expected = field[:, 0, 0] / (lengths * field[0, :, 0])[degrees(3)]
    assert_allclose(to_complex(found.light), expected, rtol=0, atol=1e-12)


def test_coefficients_that_vanish_at_p_0_are_tied_through_others() -> None:
    # the paper's closed form divides by rho_300 = 0 here
    table = isotropic_coefficients(Phong(20), 4)
    table[3, 0] = table[0, 3] = 0
    light = some_light(4)
    again, material = scaled(factor_light_field(light_field(light, table)), light)
    assert_allclose(again, light, rtol=0, atol=1e-11)
    assert_allclose(material, table, rtol=0, atol=1e-11)


def test_negative_coefficients_keep_their_signs() -> None:
    rng = np.random.default_rng(5)
    table = rng.normal(size=(5, 5, 5))
    table += table.transpose(1, 0, 2)
    for mode in range(5):
        table[:mode, :, mode] = table[:, :mode, mode] = 0
    light = some_light(4) * rng.choice([-1, 1], 25)
    again, material = scaled(factor_light_field(light_field(light, table)), light)
    assert_allclose(again, light, rtol=0, atol=1e-10)
    assert_allclose(material, table, rtol=0, atol=1e-10)


def test_a_light_field_given_by_its_values() -> None:
    light, table = some_light(3), isotropic_coefficients(Microfacet(0.3), 3)
    field = project_light_field(lambda normals, outgoing: evaluate(light, table, normals, outgoing), 3)
    again, material = scaled(factor_light_field(field), light)
    assert_allclose(again, light, rtol=0, atol=1e-10)
    assert_allclose(material, table, rtol=0, atol=1e-10)


def test_noise_is_carried_over_and_not_blown_up() -> None:
    light, table = some_light(4), isotropic_coefficients(Phong(20), 4)
    field = light_field(light, table)
    noise = 1e-4 * np.abs(field).max()
    found = factor_light_field(field + noise * to_complex(np.random.default_rng(6).normal(size=field.shape)), 6e-4)
    again, material = scaled(found, light)
    assert np.linalg.norm(again - light) < 2e-3 * np.linalg.norm(light)
    assert np.linalg.norm(material - table) < 2e-3 * np.linalg.norm(table)
    assert 1e-5 < found.residual < 3e-3


def test_a_matte_surface_is_ill_posed_at_odd_degrees() -> None:
    light, table = some_light(6), isotropic_coefficients(Lambertian(), 6)
    field = light_field(light, table)
    with pytest.raises(HarmonicFaceError, match=r"light field: ill-posed at l = 3, 5: the light field has no part"):
        factor_light_field(field)
    found = factor_light_field(field, allow_ill_posed=True)
    assert list(found.ill_posed) == [3, 5]
    again, material = scaled(found, light)
    assert list(np.unique(degrees(6)[~found.light_known])) == [3, 5]
    assert_allclose(again[found.light_known], light[found.light_known], rtol=0, atol=1e-11)
    assert not again[~found.light_known].any()
    assert_allclose(material[found.brdf_known], table[found.brdf_known], rtol=0, atol=1e-11)
    assert not found.brdf_known[3, 5].any()
    assert found.brdf_known[3, 4, 0]  # known to be 0, from rho_43q


def test_light_without_a_degree() -> None:
    light, table = some_light(4), isotropic_coefficients(Phong(20), 4)
    light[degrees(4) == 2] = 0
    field = light_field(light, table)
    with pytest.raises(HarmonicFaceError, match="ill-posed at l = 2: the light has no part of this degree"):
        factor_light_field(field)
    found = factor_light_field(field, allow_ill_posed=True)
    again, material = scaled(found, light)
    assert found.light_known.all()  # zero, since the material would have answered
    assert_allclose(again, light, rtol=0, atol=1e-11)
    assert not found.brdf_known[2, 2].any()
    assert found.brdf_known[2, 3, 1]  # from rho_321
    expected = np.where(found.brdf_known, table, 0)
    assert_allclose(material, expected, rtol=0, atol=1e-11)


def test_a_mirror_has_a_scale_at_every_degree() -> None:
    # (-1)^q delta_lp: reciprocity compares nothing, as associativity says
    table = np.zeros((4, 4, 4))
    for degree in range(4):
        table[degree, degree, : degree + 1] = (-1.0) ** np.arange(degree + 1)
    with pytest.raises(HarmonicFaceError, match="ill-posed at l = 1, 2, 3: no coefficient rho_lpq ties its scale"):
        factor_light_field(light_field(some_light(3), table))


def test_degrees_beyond_the_outgoing_order_are_not_tied() -> None:
    light, table = some_light(4), isotropic_coefficients(Phong(20), 4, 2)
    found = factor_light_field(light_field(light, table), allow_ill_posed=True)
    assert list(found.ill_posed) == [3, 4]
    again, material = scaled(found, light)
    assert_allclose(again[:9], light[:9], rtol=0, atol=1e-11)
    assert_allclose(material[:3], table[:3], rtol=0, atol=1e-11)
    assert not found.brdf_known[3:].any()
    less = factor_light_field(light_field(light[:9], isotropic_coefficients(Phong(20), 4)))
    assert_allclose(scaled(less, light)[0], light[:9], rtol=0, atol=1e-11)
    more = factor_light_field(light_field(light[:9], isotropic_coefficients(Phong(20), 2, 4)))
    assert_allclose(scaled(more, light)[0], light[:9], rtol=0, atol=1e-11)


GOOD = light_field(some_light(2), isotropic_coefficients(Phong(20), 2))


@pytest.mark.parametrize(
    ("field", "message"),
    [
        (GOOD * np.nan, r"light field: expected finite coefficients \(lm, p, q\)"),
        (GOOD[:, :, 0], r"light field: expected finite coefficients \(lm, p, q\)"),
        ("light", "light field: expected complex numbers, got str"),
        (GOOD[:, :, :2], r"light field: expected 3 modes q, got shape \(9, 3, 2\)"),
        (GOOD[:5], "coefficients: expected .order . 1..2 of them"),
        (0 * GOOD, "light field: expected one that is not dark, got zeros"),
        (1j * GOOD, "coefficients: expected those of a real function"),
        (
            GOOD * np.where(degrees(2) > 0, 1, 0)[:, None, None],
            "light field: ill-posed at l = 0: expected a light with a constant part",
        ),
        (
            light_field(some_light(2), isotropic_coefficients(Phong(20), 2, form="transfer")),
            "light field: expected that of one light and one reciprocal isotropic BRDF, .* off by 0.00",
        ),
        (
            GOOD + light_field(some_light(2, 1), isotropic_coefficients(Phong(2), 2)),
            "light field: expected that of one light and one reciprocal isotropic BRDF",
        ),
    ],
)
def test_bad_input(field, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message) as raised:
        factor_light_field(field)
    assert "\n" not in str(raised.value)


def test_a_tolerance_that_is_no_fraction() -> None:
    with pytest.raises(HarmonicFaceError, match="tolerance: expected a number from 0 to 1, got 2"):
        factor_light_field(GOOD, tolerance=2)


def test_a_ragged_light_field() -> None:
    with pytest.raises(HarmonicFaceError, match="light field: expected complex numbers, got list"):
        factor_light_field([[[1.0]], [[1.0, 2.0]]])


@pytest.mark.parametrize("unit", [1e-250, 1e250])
def test_the_unit_of_a_light_field_does_not_matter(unit: float) -> None:
    field = light_field(some_light(2), isotropic_coefficients(Phong(20), order=2))
    usual, found = factor_light_field(field), factor_light_field(unit * field)
    assert_allclose(found.light, usual.light, rtol=1e-12, atol=1e-15)
    assert_allclose(found.brdf / unit, usual.brdf, rtol=1e-12, atol=1e-15)
