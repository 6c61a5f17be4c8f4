from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harmonicface.io.colour import LUMINANCE, luminance


def test_the_weights_are_those_of_bt_709_and_white_is_one() -> None:
    assert luminance(np.eye(3)).tolist() == [0.2126, 0.7152, 0.0722]
    assert_allclose(LUMINANCE.sum(), 1, rtol=1e-15)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("shape", [(3,), (5, 3), (2, 4, 3)])
def test_any_shape_in_its_own_type(shape: tuple[int, ...], dtype: type) -> None:
    colours = np.random.default_rng(0).uniform(size=shape).astype(dtype)
    grey = luminance(colours)
    assert (grey.dtype, grey.shape) == (dtype, shape[:-1])
    expected = 0.2126 * colours[..., 0] + 0.7152 * colours[..., 1] + 0.0722 * colours[..., 2]
    assert_allclose(grey, expected, rtol=1e-6)
