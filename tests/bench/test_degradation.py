"""What is done to photographs is what its name says."""

from __future__ import annotations

import numpy as np
import pytest

import harmonicface as hf
from harmonicface.bench.degradation import at_resolution, blurred, compressed, moved, noisy, with_gamma

FACE = hf.photograph(hf.render(hf.synthetic_person(0, 64), hf.lights.directional([1, 1, 2])), 0)


def test_noise_has_its_deviation_and_stays_in_range() -> None:
    grey = np.full((200, 200), 0.5, np.float32)
    found = noisy(grey, 0.01, 3)
    assert found.dtype == np.float32
    assert found.std() == pytest.approx(0.01, rel=0.02)
    assert found.mean() == pytest.approx(0.5, abs=2e-4)
    np.testing.assert_array_equal(found, noisy(grey, 0.01, 3))
    assert not np.array_equal(found, noisy(grey, 0.01, 4))
    white = noisy(np.ones((9, 9), np.float32), 0.1, 0)
    assert white.max() == 1 and white.min() < 1


def test_lower_quality_is_farther_away() -> None:
    errors = [float(np.square(compressed(FACE, quality) - FACE).mean()) for quality in (95, 50, 10)]
    assert errors[0] < errors[1] < errors[2] < 0.01
    assert compressed(FACE, 100).dtype == np.float32


def test_a_shift_goes_right_and_down() -> None:
    found = moved(FACE, right=3, down=2)
    np.testing.assert_allclose(found[2:, 3:], FACE[:-2, :-3], atol=1e-6)
    np.testing.assert_array_equal(moved(FACE), FACE)


def test_a_turn_goes_clockwise_about_the_middle() -> None:
    np.testing.assert_allclose(moved(FACE, degrees=90), np.rot90(FACE, -1), atol=1e-4)


def test_a_scale_enlarges_about_the_middle() -> None:
    x = np.arange(33, dtype=np.float32) - 16
    ramp = np.tile(x, (33, 1))
    np.testing.assert_allclose(moved(ramp, scale=2), ramp / 2, atol=1e-4)


def test_a_blur_is_a_gaussian() -> None:
    dot = np.zeros((41, 41), np.float32)
    dot[20, 20] = 1
    found = blurred(dot, 2.0)
    x = np.arange(41) - 20
    assert found.sum() == pytest.approx(1, abs=1e-4)
    assert (found.sum(axis=0) @ x**2) == pytest.approx(4, rel=0.03)
    assert blurred(FACE, 0) is FACE


def test_resolution_takes_detail_away_and_keeps_the_mean() -> None:
    board = (np.indices((64, 64)).sum(axis=0) % 2).astype(np.float32)
    np.testing.assert_allclose(at_resolution(board, 32), 0.5, atol=0.01)
    assert at_resolution(FACE, 64) is FACE
    small = at_resolution(FACE, 16)
    assert small.shape == FACE.shape
    assert small.mean() == pytest.approx(FACE.mean(), abs=0.01)
    assert (small.min(), small.max()) >= (0, 0) and small.max() <= 1


def test_gamma_is_a_power_in_eight_bits() -> None:
    found = with_gamma(FACE, 2.2)
    assert np.abs(found - FACE**2.2).max() <= 0.5 / 255 + 1e-6
    np.testing.assert_allclose(found * 255, np.rint(found * 255), atol=1e-4)


def test_no_such_quality() -> None:
    with pytest.raises(hf.HarmonicFaceError, match="jpeg: expected a quality from 1 to 100, got 101"):
        compressed(FACE, 101)
