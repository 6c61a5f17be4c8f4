"""The sRGB curve: published points, its inverse, and the linear piece."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from skimage.color import rgb2xyz

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.transfer import linear_to_srgb, srgb_to_linear


def test_it_agrees_with_scikit_image():
    values = np.linspace(0, 1, 100)
    luminance = rgb2xyz(np.repeat(values[:, None], 3, axis=1))[:, 1]
    np.testing.assert_allclose(srgb_to_linear(values), luminance, atol=1e-6)


@given(st.floats(0, 4))
def test_there_and_back(value):
    assert linear_to_srgb(srgb_to_linear(value)) == pytest.approx(value, abs=1e-7)


def test_float32_stays_float32():
    assert srgb_to_linear(np.ones(3, dtype=np.float32)).dtype == np.float32
    assert linear_to_srgb(np.ones(3, dtype=np.float32)).dtype == np.float32


@pytest.mark.parametrize("curve", [srgb_to_linear, linear_to_srgb])
def test_bad_values_are_refused(curve):
    with pytest.raises(HarmonicFaceError, match=r"values: expected at least 0, got -0\.1"):
        curve([0.5, -0.1])
    with pytest.raises(HarmonicFaceError, match="values: expected finite"):
        curve([np.nan])
