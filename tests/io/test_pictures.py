from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harmonicface.io.pictures import signed_colours, to_display

EVERYWHERE = np.ones((1, 5), np.bool_)


def test_a_linear_picture_is_encoded_as_screens_expect() -> None:
    shown = to_display(np.array([[0.0, 0.5, 1.0, 2.0, 4.0]]), scale=2.0)
    # 0, then the sRGB curve at a quarter and at a half, then white and what is brighter than white
    expected = [0, 1.055 * 0.25 ** (1 / 2.4) - 0.055, 1.055 * 0.5 ** (1 / 2.4) - 0.055, 1, 1]
    assert_allclose(shown, [expected], rtol=0, atol=1e-6)


def test_the_brightest_hundredth_of_the_lit_pixels_is_white() -> None:
    picture = np.concatenate([np.zeros(5000), np.linspace(0.01, 3, 1000)])[None]
    shown = to_display(picture)
    assert_allclose((shown > 1 - 1e-6).sum(), 10, atol=1)
    assert shown[0, :5000].max() == 0


def test_darkness_is_black() -> None:
    assert not to_display(np.zeros((2, 3, 3))).any()


def test_red_adds_and_blue_takes_away() -> None:
    colours = signed_colours(np.array([[-3.0, -1.0, 0.0, 1.0, 3.0]]), EVERYWHERE, scale=1.0)
    red, blue = colours[0, :, 0], colours[0, :, 2]
    assert colours.shape == (1, 5, 3)
    assert blue[0] - red[0] > 0.2
    assert red[4] - blue[4] > 0.2
    assert_allclose(colours[0, 2], 1, atol=0.04)
    assert_allclose(colours[0, 0], colours[0, 1])  # beyond the scale nothing changes
    assert_allclose(colours[0, 3], colours[0, 4])


def test_the_scale_is_that_of_the_mask_and_the_rest_is_grey() -> None:
    picture, mask = np.array([[-1.0, 0.5, 100.0]]), np.array([[True, True, False]])
    colours = signed_colours(picture, mask)
    assert_allclose(colours[0, 2], 0.93)
    assert_allclose(colours[:, :2], signed_colours(picture, mask, scale=np.quantile([1.0, 0.5], 0.99))[:, :2])


@pytest.mark.parametrize("scale", [None, 0.0])
def test_nothing_is_white(scale: float | None) -> None:
    assert_allclose(signed_colours(np.zeros((1, 5)), EVERYWHERE, scale), 1, atol=0.04)
