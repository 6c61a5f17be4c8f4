"""Tone mapping: its equation by hand, and its bounds."""

from __future__ import annotations

import numpy as np
import pytest

import harmonicface as hf
from harmonicface.io.tone import tone_mapped
from harmonicface.io.transfer import linear_to_srgb


def test_the_equation_by_hand() -> None:
    picture = np.array([[1.0, 4.0], [16.0, 0.0]])  # the geometric mean of what is lit is 4
    scaled = 0.36 / 4 * picture
    expected = scaled * (1 + scaled / 2.0**2) / (1 + scaled)
    np.testing.assert_allclose(tone_mapped(picture, key=0.36, white=2.0), linear_to_srgb(expected), rtol=1e-14)


def test_the_brightest_pixel_is_white_and_darkness_stays_dark() -> None:
    picture = np.random.default_rng(0).gamma(0.1, 100.0, (20, 30, 3)).astype(np.float32) + np.float32(1e-5)
    picture[0, 0] = 1e5
    shown = tone_mapped(picture)
    assert shown.dtype == np.float32
    assert shown.min() >= 0
    assert shown[0, 0] == pytest.approx(1, abs=1e-6)
    assert not tone_mapped(np.zeros((2, 3, 3))).any()


def test_colours_keep_their_ratios_and_exposure_does_not_matter() -> None:
    picture = np.array([[[0.1, 0.2, 0.05], [0.4, 0.1, 0.2]]])
    np.testing.assert_allclose(tone_mapped(picture), tone_mapped(1000 * picture), rtol=1e-12)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: tone_mapped([[-1.0]]), "radiance: expected at least 0, got -1"),
        (lambda: tone_mapped([[np.nan]]), "radiance: expected finite numbers"),
        (lambda: tone_mapped([[1.0]], key=0), "key: expected a finite number above 0"),
        (lambda: tone_mapped([[1.0]], white=0), "white: expected a finite number above 0"),
    ],
)
def test_what_cannot_be_mapped(call, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        call()
