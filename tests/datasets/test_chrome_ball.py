from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.testing import assert_allclose

from harmonicface.datasets.chrome_ball import load_chrome_ball, mask_in
from harmonicface.errors import HarmonicFaceError

SPOTS = [(40, 60), (55, 35), (30, 52)]  # row and column


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Photographs of a chrome ball of radius 40 at (50, 48), a pixel's highlight in each, and its mask."""
    rows, columns = np.mgrid[:100, :110] + 0.5
    ball = np.hypot(columns - 50, rows - 48) < 40
    cv2.imwrite(str(tmp_path / "chrome.mask.png"), np.where(ball, 255, 0).astype(np.uint8))
    for number, (row, column) in enumerate(SPOTS):
        photo = np.where(ball, 10, 40).astype(np.uint8)
        photo[row, column] = 255
        cv2.imwrite(str(tmp_path / f"chrome.{number}.png"), np.repeat(photo[..., None], 3, axis=2))
    return tmp_path


def expected() -> np.ndarray:
    x = np.array([(column + 0.5 - 50) / 40 for _, column in SPOTS])
    y = np.array([(48 - row - 0.5) / 40 for row, _ in SPOTS])
    z = np.sqrt(1 - x**2 - y**2)
    return np.stack([2 * z * x, 2 * z * y, 2 * z**2 - 1], axis=1)


def test_a_folder_with_a_mask(folder: Path) -> None:
    assert_allclose(load_chrome_ball(folder), expected(), atol=0.01)


def test_a_circle_in_place_of_the_mask(folder: Path) -> None:
    assert_allclose(load_chrome_ball(folder, (50, 48, 40)), expected(), atol=1e-3)
    files = [folder / "chrome.1.png", folder / "chrome.0.png"]
    assert_allclose(load_chrome_ball(files, (50, 48, 40)), expected()[[1, 0]], atol=1e-3)


def test_refuses_a_ball_that_nobody_shows(folder: Path) -> None:
    with pytest.raises(HarmonicFaceError, match="expected a picture of the ball's mask, or a circle, got neither"):
        load_chrome_ball([folder / "chrome.1.png"])
    (folder / "another mask.png").write_bytes((folder / "chrome.mask.png").read_bytes())
    assert mask_in(folder) is None
    with pytest.raises(HarmonicFaceError, match="got neither"):
        load_chrome_ball(folder)


def test_says_which_photograph_has_no_highlight(folder: Path) -> None:
    cv2.imwrite(str(folder / "chrome.2.png"), np.full((100, 110), 10, np.uint8))
    with pytest.raises(HarmonicFaceError, match=r"chrome.2.png: ball: expected a lamp's highlight, got"):
        load_chrome_ball(folder)
