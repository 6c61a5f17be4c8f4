"""Rank of kernels against matrices of known singular values, filters on the sphere and circulants."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.reflectance.filters import lambertian_filter
from harmonicface.reflectance.phong import phong_filter
from harmonicface.reflectance.rank import kernel_rank, sphere_kernel_rank


def multiplied(filter_: np.ndarray) -> np.ndarray:
    """Each |f_l|, 2l + 1 times, largest first."""
    return -np.sort(-np.repeat(np.abs(filter_), 2 * np.arange(len(filter_)) + 1))


def cosines(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return np.einsum("...i,...i->...", first, second)


def test_a_series_of_the_clamped_cosine_has_its_filter_as_singular_values() -> None:
    filter_ = lambertian_filter(8)
    series = (2 * np.arange(9) + 1) / (4 * np.pi) * filter_
    report = sphere_kernel_rank(lambda s, t: np.polynomial.legendre.legval(cosines(s, t), series), 8)
    expected = multiplied(filter_)
    assert_allclose(report.singular_values[:81], expected, rtol=0, atol=1e-13)
    assert report.rank == 1 + 3 + 5 + 9 + 13 + 17  # no odd degree above 1


def test_the_clamped_cosine_itself() -> None:
    report = sphere_kernel_rank(lambda s, t: np.maximum(cosines(s, t), 0), 15, tolerance=0.03)
    # the kink makes the quadrature inexact: to 3e-4 of the largest on this grid
    assert_allclose(report.singular_values[:18], multiplied(lambertian_filter(4))[:18], rtol=0, atol=5e-4 * math.pi)
    assert report.rank == 18 and abs(report.kept_condition - 24) < 2
    assert sphere_kernel_rank(lambda s, t: np.maximum(cosines(s, t), 0), 15, tolerance=0.1).rank == 9


def test_a_finer_grid_comes_nearer() -> None:
    errors = []
    for order in (6, 10, 16):
        values = sphere_kernel_rank(lambda s, t: np.maximum(cosines(s, t), 0), order).singular_values[:9]
        errors.append(np.abs(values - multiplied(lambertian_filter(2))).max())
    assert errors[2] < errors[1] < errors[0]


def test_a_smooth_lobe_over_the_whole_sphere() -> None:
    # ((1 + u) / 2)^6 is a polynomial of degree 6: exact, of rank (6 + 1)^2
    report = sphere_kernel_rank(lambda s, t: ((1 + cosines(s, t)) / 2) ** 6, 6, tolerance=1e-10)
    assert report.rank == 49
    nodes, weights = np.polynomial.legendre.leggauss(12)
    lobe = weights * ((1 + nodes) / 2) ** 6
    filter_ = [2 * np.pi * lobe @ np.polynomial.legendre.legval(nodes, np.eye(7)[degree]) for degree in range(7)]
    assert_allclose(report.singular_values[:49], multiplied(np.array(filter_)), rtol=0, atol=1e-13)


def test_a_glossy_kernel_is_better_conditioned_than_a_matte_one() -> None:
    matte, gloss = (
        sphere_kernel_rank(
            lambda s, t, f=filter_: np.polynomial.legendre.legval(cosines(s, t), (2 * np.arange(7) + 1) * f), 6, 0.05
        )
        for filter_ in (lambertian_filter(6), phong_filter(40, 6))
    )
    assert matte.rank == 9 and gloss.rank == 49


def test_weights_of_rows_that_are_no_directions() -> None:
    # nine harmonics seen by scattered normals: without weights the matrix's own singular values
    random = np.random.default_rng(0)
    normals = random.normal(size=(500, 3))
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    images = real_harmonics(normals, 3).T * lambertian_filter(3)[np.repeat(np.arange(4), [1, 3, 5, 7])]
    report = kernel_rank(images)
    assert report.rank == 9 and report.condition == math.inf
    assert_allclose(report.singular_values, np.sqrt(np.abs(np.linalg.eigvalsh(images.T @ images)))[::-1], atol=1e-5)
    halves = kernel_rank(np.repeat(images, 2, axis=0), row_weights=np.full(1000, 0.5))
    assert_allclose(halves.singular_values[:9], report.singular_values[:9], rtol=1e-12)


def test_a_known_matrix_real_and_complex() -> None:
    random = np.random.default_rng(1)
    left = np.linalg.qr(random.normal(size=(6, 6)) + 1j * random.normal(size=(6, 6)))[0]
    right = np.linalg.qr(random.normal(size=(4, 4)))[0]
    report = kernel_rank(left[:, :4] * [4.0, 2.0, 1.0, 1e-9] @ right)
    assert_allclose(report.singular_values, [4, 2, 1, 1e-9], rtol=1e-6)
    assert report.rank == 3 and report.kept_condition == pytest.approx(4) and report.condition == pytest.approx(4e9)
    assert str(report) == "rank 3 of 4 at tolerance 1e-06, condition 4e+09 (4 within the rank)"


def test_a_kernel_of_nothing() -> None:
    report = kernel_rank(np.zeros((3, 2)))
    assert report.rank == 0 and report.condition == math.inf and report.kept_condition == math.inf


def test_errors() -> None:
    with pytest.raises(HarmonicFaceError, match="kernel: expected a matrix"):
        kernel_rank([1.0, 2.0])
    with pytest.raises(HarmonicFaceError, match="kernel: expected finite numbers"):
        kernel_rank([[np.nan]])
    with pytest.raises(HarmonicFaceError, match="kernel: expected finite numbers"):
        kernel_rank([[np.inf + 1j]])
    with pytest.raises(HarmonicFaceError, match="tolerance: expected a number from 0 to 1, got 2"):
        kernel_rank(np.eye(2), tolerance=2)
    with pytest.raises(HarmonicFaceError, match="row_weights: expected 2 weights of at least 0"):
        kernel_rank(np.eye(2), row_weights=[1.0])
    with pytest.raises(HarmonicFaceError, match="column_weights: expected 2 weights of at least 0"):
        kernel_rank(np.eye(2), column_weights=[1.0, -1.0])
    with pytest.raises(HarmonicFaceError, match="order: expected an integer of at least 0"):
        sphere_kernel_rank(cosines, -1)
    with pytest.raises(HarmonicFaceError, match="order: expected a grid of at most 4096 directions, got 4186 at 45"):
        sphere_kernel_rank(cosines, 45)
    with pytest.raises(HarmonicFaceError, match=r"kernel: expected values of shape \(6, 6\)"):
        sphere_kernel_rank(lambda s, t: np.ones(3), 1)


def test_a_kernel_that_is_none() -> None:
    with pytest.raises(HarmonicFaceError, match="kernel: expected a function of two directions, got int 3"):
        sphere_kernel_rank(3, 2)
