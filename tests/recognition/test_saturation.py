"""Which pixels are burnt out."""

from __future__ import annotations

import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.saturation import burnt_out


def test_one_brightest_pixel_and_darkness_are_not_burnt_out() -> None:
    assert not burnt_out(np.linspace(0, 1, 100).reshape(10, 10)).any()
    assert not burnt_out(np.zeros((10, 10))).any()
    few_levels = np.random.default_rng(0).integers(0, 6, (64, 64))  # an unlit photograph
    few_levels[0, :3] = 6
    assert not burnt_out(few_levels).any()


def test_only_what_the_mask_shows_can_be_burnt_out() -> None:
    photo = np.linspace(0, 1, 100).reshape(10, 10)
    photo[5:] = 1
    assert burnt_out(photo).sum() == 50
    mask = np.arange(10)[:, None] * np.ones(10) < 5
    assert not burnt_out(photo, mask).any()


def test_what_is_no_photograph() -> None:
    with pytest.raises(HarmonicFaceError, match=r"photo: expected shape \(h, w\), got"):
        burnt_out(np.zeros(4))
