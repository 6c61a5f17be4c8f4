from __future__ import annotations

import numpy as np
from numpy.testing import assert_array_equal

from harmonicface.stereo.bright_part import bright_part

ROWS, COLUMNS = np.mgrid[:60, :80]
DISC = np.hypot(ROWS - 30, COLUMNS - 40) < 20


def picture() -> np.ndarray:
    random = np.random.default_rng(0)
    shown = np.where(DISC, 0.5, 0.02) * random.uniform(0.7, 1.3, DISC.shape)
    shown[28:32, 38:42] = 0.01  # a dark spot within it
    shown[5:8, 5:8] = 0.6  # something else
    return shown


def test_the_disc_without_specks_and_holes() -> None:
    found = bright_part(picture())
    assert found is not None
    share = (found & DISC).sum() / (found | DISC).sum()
    assert share > 0.97 and found[30, 40] and not found[6, 6]


def test_brightness_has_no_unit() -> None:
    assert_array_equal(bright_part(picture()), bright_part(1000 * picture()))


def test_no_dark_background() -> None:
    random = np.random.default_rng(0)
    assert bright_part(random.uniform(0.4, 0.6, (40, 40))) is None
    assert bright_part(np.where(ROWS < 30, 0.5, 0.3)) is None  # a grey background is none
    assert bright_part(np.zeros((20, 20))) is None


def test_specks_alone_are_nothing() -> None:
    shown = np.zeros((50, 50))
    shown[::10, ::10] = 1
    assert bright_part(shown) is None
