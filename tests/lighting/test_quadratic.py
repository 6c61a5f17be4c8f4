"""The quadratic form of irradiance: the paper's constants, and equality with the harmonic series."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import harmonicface as hf
from harmonicface.lighting import quadratic
from harmonicface.lighting.quadratic import expanded_irradiance, irradiance_matrix, quadratic_irradiance

RNG = np.random.default_rng(5)
NORMALS = RNG.normal(size=(7, 11, 3))
NORMALS /= np.linalg.norm(NORMALS, axis=-1, keepdims=True)


def test_the_constants_are_the_published_ones() -> None:
    constants = [quadratic.C1, quadratic.C2, quadratic.C3, quadratic.C4, quadratic.C5]
    assert_allclose(
        constants, [0.429043, 0.511664, 0.743125, 0.886227, 0.247708], rtol=0, atol=1.2e-6
    )  # c2, c3 end in 3, 4


@pytest.mark.parametrize("colours", [(), (3,)], ids=["grey", "colour"])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_both_forms_are_the_series(colours: tuple[int, ...], dtype: type) -> None:
    coefficients = RNG.normal(size=(9, *colours))
    normals = NORMALS.astype(dtype)
    expected = hf.HarmonicLight(coefficients).irradiance(NORMALS)
    for form in (quadratic_irradiance, expanded_irradiance):
        found = form(coefficients, normals)
        assert found.dtype == dtype
        assert_allclose(found, expected, rtol=0, atol=1e-5 if dtype is np.float32 else 1e-13)


def test_the_matrix_is_symmetric_and_one_a_colour() -> None:
    coefficients = RNG.normal(size=(9, 3))
    matrices = irradiance_matrix(coefficients)
    assert matrices.shape == (3, 4, 4)
    assert_array_equal(matrices, np.swapaxes(matrices, 1, 2))
    assert_allclose(matrices[1], irradiance_matrix(coefficients[:, 1]), rtol=1e-15)
    assert_allclose(np.trace(matrices[0][:2, :2]), 0, atol=1e-15)


@pytest.mark.parametrize(
    "form", [irradiance_matrix, lambda c: quadratic_irradiance(c, NORMALS), lambda c: expanded_irradiance(c, NORMALS)]
)
@pytest.mark.parametrize(
    ("coefficients", "message"),
    [
        (np.ones(4), r"coefficients: expected shape \(9,\) or \(9, 3\), got \(4,\)"),
        (np.full(9, np.nan), "coefficients: expected finite"),
    ],
)
def test_coefficients_that_are_not_nine(form, coefficients: np.ndarray, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        form(coefficients)


def test_normals_that_are_none() -> None:
    for form in (quadratic_irradiance, expanded_irradiance):
        with pytest.raises(hf.HarmonicFaceError, match="normals: expected unit vectors"):
            form(np.ones(9), [0.0, 0.0, 2.0])
