"""Fresnel's factor against its limits, its two polarizations, and another renderer."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.reflectance.fresnel import fresnel

COSINES = np.linspace(0, 1, 101)


@pytest.mark.parametrize("index", [1.001, 1.4, 1.5, 2.4, 100])
def test_against_the_two_polarizations(index: float) -> None:
    inside = np.sqrt(1 - (1 - COSINES**2) / index**2)  # Snell
    senkrecht = (COSINES - index * inside) / (COSINES + index * inside)
    parallel = (index * COSINES - inside) / (index * COSINES + inside)
    assert_allclose(fresnel(COSINES, index), (senkrecht**2 + parallel**2) / 2, rtol=1e-9)


def test_limits() -> None:
    assert_allclose(fresnel([0.0, 1.0], 1.4), [1, (0.4 / 2.4) ** 2], rtol=1e-14)
    assert (np.diff(fresnel(COSINES, 1.4)) < 0).all()
    assert fresnel(np.ones(2, np.float32), 1.4).dtype == np.float32
    assert_allclose(fresnel([-0.1, 1.0000001], 1.4), fresnel([0.0, 1.0], 1.4), rtol=1e-15)  # rounding of a cosine


def test_against_mitsuba() -> None:
    mitsuba = pytest.importorskip("mitsuba")
    mitsuba.set_variant("scalar_rgb")
    expected = [mitsuba.fresnel(float(cosine), 1.4)[0] for cosine in COSINES]
    assert_allclose(fresnel(COSINES, 1.4), expected, rtol=2e-5)


@pytest.mark.parametrize("index", [1.0, 0.5, 100.1, 0, -1, np.nan, np.inf, None, "glass", True])
def test_what_is_no_index(index: float) -> None:
    with pytest.raises(hf.HarmonicFaceError, match="refractive_index: expected a"):
        fresnel([1.0], index)


def test_what_is_no_cosine() -> None:
    with pytest.raises(hf.HarmonicFaceError, match="cosines: expected finite numbers"):
        fresnel([np.nan], 1.4)
