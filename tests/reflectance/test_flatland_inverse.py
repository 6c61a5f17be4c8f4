"""Flatland backwards: round trips, what is hidden, and both factors from one light field."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from harmonicface.errors import HarmonicFaceError
from harmonicface.reflectance.flatland import reflect_flat, transfer_coefficients
from harmonicface.reflectance.flatland_inverse import factorize_flat, flat_light, flat_transfer
from harmonicface.reflectance.flatland_materials import flat_directional, flat_lambertian, flat_uniform
from harmonicface.reflectance.flatland_series import circle_angles, fourier_coefficients

ROOT = np.sqrt(2 * np.pi)


def random_series(random: np.random.Generator, *shape: int) -> np.ndarray:
    return random.normal(size=shape) + 1j * random.normal(size=shape)


def reciprocal(random: np.random.Generator, order: int) -> np.ndarray:
    matrix = random_series(random, 2 * order + 1, 2 * order + 1)
    return (matrix + matrix[::-1, ::-1].T) / 2


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 8), st.integers(0, 2**32 - 1))
def test_light_and_material_come_back(order: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    light, transfer = random_series(random, 2 * order + 1), random_series(random, 2 * order + 1, 4)
    field = reflect_flat(light, transfer)
    assert_allclose(flat_light(field, transfer).filled(np.nan), light, rtol=1e-10)
    assert_allclose(flat_transfer(field, light).filled(np.nan), transfer, rtol=1e-10)


def test_a_matte_surface_hides_odd_degrees_of_the_light() -> None:
    light = random_series(np.random.default_rng(0), 13)
    rho = flat_lambertian(6) / ROOT
    found = flat_light(reflect_flat(light, rho), rho)
    hidden = [degree for degree in range(-6, 7) if abs(degree) > 1 and degree % 2]
    assert_array_equal(np.flatnonzero(np.ma.getmaskarray(found)) - 6, hidden)
    assert_allclose(found.compressed(), light[~np.ma.getmaskarray(found)], rtol=1e-12)


def test_light_from_all_outgoing_degrees_by_least_squares() -> None:
    random = np.random.default_rng(1)
    transfer, field = random_series(random, 3, 50), random_series(random, 3, 50)
    expected = [np.linalg.lstsq(ROOT * t[:, None], b, rcond=None)[0][0] for t, b in zip(transfer, field, strict=True)]
    assert_allclose(flat_light(field, transfer).filled(np.nan), expected, rtol=1e-12)


def test_a_lamp_tells_all_of_a_material_and_uniform_light_one_row() -> None:
    rho = reciprocal(np.random.default_rng(2), 4)
    lamp, sky = flat_directional(0.3, 4), flat_uniform(4)
    assert_allclose(flat_transfer(reflect_flat(lamp, rho), lamp).filled(np.nan), rho, rtol=1e-12)
    found = flat_transfer(reflect_flat(sky, rho), sky)
    assert_array_equal(np.flatnonzero(~np.ma.getmaskarray(found)[:, 0]), [4])
    assert_allclose(found[4].filled(np.nan), rho[4], rtol=1e-12)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 8), st.integers(0, 2**32 - 1))
def test_both_factors_come_back_up_to_scale(order: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    light, rho = random_series(random, 2 * order + 1), reciprocal(random, order)
    factors = factorize_flat(reflect_flat(light, rho))
    scale = light[order] * ROOT
    assert factors.lost == ()
    assert_allclose(factors.light.filled(np.nan), light / scale, rtol=1e-6, atol=1e-9)
    assert_allclose(factors.transfer.filled(np.nan), rho * scale, rtol=1e-6, atol=1e-9)


def test_a_real_gloss_under_a_real_light() -> None:
    angles = circle_angles(128)
    inside = np.where(np.abs(angles) < np.pi / 2, np.cos(angles), 0)
    samples = np.exp(-((angles[:, None] + angles) ** 2)) * inside[:, None] * inside
    rho = transfer_coefficients(samples, 8, 8)
    light = fourier_coefficients(1 + 0.5 * np.cos(angles - 1) + np.exp(np.sin(3 * angles + 0.5)), 8)
    factors = factorize_flat(reflect_flat(light, rho), 1e-10)
    assert_allclose(factors.light * light[8] * ROOT, light, rtol=0, atol=1e-9 * np.abs(light).max())


def test_with_noise_to_the_noise() -> None:
    random = np.random.default_rng(3)
    light, rho = random_series(random, 11), reciprocal(random, 5)
    field = reflect_flat(light, rho)
    noisy = field + 1e-4 * np.abs(field).max() * random_series(random, 11, 11)
    factors = factorize_flat(noisy, 1e-3)
    found = factors.light * light[5] * ROOT
    assert np.abs(found - light).max() < 5e-3 * np.abs(light).max()
    material = factors.transfer.filled(np.nan)
    assert_allclose(material, material[::-1, ::-1].T, rtol=1e-14)  # reciprocal, though the noise is not
    assert np.abs(material / (light[5] * ROOT) - rho).max() < 5e-3 * np.abs(rho).max()


def test_a_degree_that_the_light_lacks_is_known_to_be_dark() -> None:
    random = np.random.default_rng(4)
    light, rho = random_series(random, 7), reciprocal(random, 3)
    light[[1, 5]] = 0  # degrees -2 and 2
    factors = factorize_flat(reflect_flat(light, rho))
    assert factors.lost == () and not np.ma.getmaskarray(factors.light).any()
    assert_allclose(factors.light * light[3] * ROOT, light, rtol=0, atol=1e-9)
    # of the material only what neither incidence nor exitance of degree 2 could tell is hidden
    hidden = np.argwhere(np.ma.getmaskarray(factors.transfer))
    assert_array_equal(hidden, [[1, 1], [1, 5], [5, 1], [5, 5]])
    shown = ~np.ma.getmaskarray(factors.transfer)
    assert_allclose(factors.transfer.data[shown], (rho * light[3] * ROOT)[shown], rtol=0, atol=1e-9)


def test_a_degree_that_the_material_lacks_is_lost() -> None:
    random = np.random.default_rng(5)
    light, rho = random_series(random, 7), reciprocal(random, 3)
    rho[[0, 6]] = 0
    rho[:, [0, 6]] = 0
    factors = factorize_flat(reflect_flat(light, rho))
    assert factors.lost == (3,)
    assert_array_equal(np.flatnonzero(np.ma.getmaskarray(factors.light)), [0, 6])


def test_uniform_light_and_its_mirror() -> None:
    # only B_0p is there: the light's other degrees are seen to be dark, the material's to be hidden
    rho = reciprocal(np.random.default_rng(6), 2)
    factors = factorize_flat(reflect_flat(flat_uniform(2), rho))
    assert_allclose(factors.light.filled(np.nan), flat_uniform(2), rtol=0, atol=1e-14)
    assert_allclose(factors.transfer[2].filled(np.nan), rho[2], rtol=1e-12)
    assert_allclose(factors.transfer[:, 2].filled(np.nan), rho[:, 2], rtol=1e-12)  # reciprocity doubles what is known
    assert np.ma.getmaskarray(factors.transfer).sum() == 16


def test_errors() -> None:
    with pytest.raises(HarmonicFaceError, match=r"reflected: expected the transfer's shape \(3,\)"):
        flat_light(np.ones(5), np.ones(3))
    with pytest.raises(HarmonicFaceError, match="light: expected 5 degrees"):
        flat_transfer(np.ones(5), np.ones(3))
    with pytest.raises(HarmonicFaceError, match=r"reflected: expected 2 order \+ 1 degrees"):
        flat_transfer(np.ones(4), np.ones(4))
    with pytest.raises(HarmonicFaceError, match="reflected: expected as many degrees l as p"):
        factorize_flat(np.ones((3, 5)))
    with pytest.raises(HarmonicFaceError, match="reflected: expected a degree l = 0 that is not nothing"):
        factorize_flat(np.zeros((3, 3)))
    with pytest.raises(HarmonicFaceError, match="reflected: expected finite numbers"):
        factorize_flat(np.full((3, 3), np.nan))
    with pytest.raises(HarmonicFaceError, match="tolerance: expected a number from 0 to 1"):
        factorize_flat(np.ones((3, 3)), 3)
