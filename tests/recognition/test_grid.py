"""The grid: sizes, averages, and masks that draw no edge."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.recognition.grid import blurred, filled, grid, on_grid


def test_sizes() -> None:
    assert [grid(shape) for shape in ((192, 168), (480, 640), (96, 84), (64, 64), (24, 100))] == [
        (96, 84),
        (96, 128),
        (96, 84),
        (64, 64),
        (24, 100),
    ]


@pytest.mark.parametrize("shape", [(23, 64), (64, 23), (960, 200), (0, 5)])
def test_too_small(shape: tuple[int, int]) -> None:
    with pytest.raises(hf.HarmonicFaceError, match="photo: expected at least 24 pixels a side"):
        grid(shape)


def test_areas_are_averaged_at_any_brightness() -> None:
    photo = np.random.default_rng(0).uniform(0, 1, (192, 192))
    expected = photo.reshape(96, 2, 96, 2).mean(axis=(1, 3)) / photo.max()
    for scale in (1e-200, 1, 1e29):
        assert_allclose(on_grid(scale * photo).light, expected, atol=1e-6)


def test_a_mask_draws_no_edge() -> None:
    mask = np.ones((48, 48), np.bool_)
    mask[:, 30:] = False
    photo = np.where(mask, 0.5, 40.0)
    found = on_grid(photo, mask)
    assert_allclose(found.light, 1, atol=1e-4)
    assert found.seen is not None and (found.seen == mask).all()
    assert on_grid(photo, np.ones_like(mask)).seen is None


def test_filling_is_linear() -> None:
    rng = np.random.default_rng(1)
    cover = (rng.uniform(size=(32, 32)) > 0.4).astype(np.float32)
    one, other = rng.normal(size=(2, 32, 32)).astype(np.float32) * cover
    assert_allclose(filled(2 * one - other, cover), 2 * filled(one, cover) - filled(other, cover), atol=1e-4)


def test_a_blur_keeps_what_is_constant() -> None:
    assert_allclose(blurred(np.full((30, 30), 0.7, np.float32), 3.0), 0.7, rtol=1e-6)


@pytest.mark.parametrize(
    ("photo", "mask", "message"),
    [
        (np.ones((30, 30, 3)), None, r"photo: expected shape \(h, w\), got an array of shape \(30, 30, 3\)"),
        (np.full((30, 30), np.nan), None, "photo: expected finite numbers"),
        (np.ones((30, 30)), np.ones((30, 31), np.bool_), "mask: expected a boolean mask"),
    ],
)
def test_bad_input(photo: np.ndarray, mask: np.ndarray | None, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        on_grid(photo, mask)
