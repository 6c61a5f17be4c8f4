from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harmonicface.datasets.diligent import LUMINANCE, load_diligent
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.semi_calibrated import FEWEST, semi_calibrated


def scene(count: int = 12, pixels: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """Directions (n, 3) and albedo times normal (p, 3)."""
    generator = np.random.default_rng(0)
    lamps = generator.normal(size=(count, 3)) * [0.6, 0.6, 0.1] + [0, 0, 1]
    normals = generator.normal(size=(pixels, 3)) * [0.5, 0.5, 0.1] + [0, 0, 1]
    normals *= generator.uniform(0.2, 1, (pixels, 1)) / np.linalg.norm(normals, axis=1, keepdims=True)
    return lamps / np.linalg.norm(lamps, axis=1, keepdims=True), normals


@pytest.mark.parametrize("count", [FEWEST, 7, 40])
def test_brightness_from_one_to_a_hundred_is_exact(count: int) -> None:
    lamps, scaled = scene(count)
    scaled = scaled[(lamps @ scaled.T > 0).all(axis=0)]
    brightness = np.geomspace(1, 100, count)
    found = semi_calibrated(brightness[:, None] * (lamps @ scaled.T), lamps)
    assert_allclose(found.values, brightness / np.median(brightness), rtol=1e-3)
    assert found.error.max() < 1e-3


def test_shadows_and_highlights_change_little() -> None:
    lamps, scaled = scene(30, 1500)
    images = np.maximum(lamps @ scaled.T, 0)
    generator = np.random.default_rng(1)
    images[generator.random(images.shape) < 0.1] *= 0.1
    images[generator.random(images.shape) < 0.05] += 1.0
    brightness = generator.uniform(0.3, 3, 30)
    found = semi_calibrated(brightness[:, None] * images, lamps)
    assert_allclose(found.values, brightness / np.median(brightness), rtol=0.05)


def test_the_standard_error_is_that_of_noise() -> None:
    lamps, scaled = scene(10, 300)
    clean = lamps @ scaled.T
    scaled = scaled[(clean > 0.1).all(axis=0)]
    generator = np.random.default_rng(2)
    ratios, stated = [], []
    for _ in range(20):
        found = semi_calibrated(lamps @ scaled.T + 0.01 * generator.normal(size=(10, len(scaled))), lamps)
        ratios.append(np.log(found.values))
        stated.append(found.error)
    assert 0.5 < np.std(ratios, axis=0).mean() / np.mean(stated) < 3


def test_what_saturates_is_not_used() -> None:
    lamps, scaled = scene(12, 600)
    images = np.maximum(lamps @ scaled.T, 0)
    brightness = np.linspace(1, 2, 12)
    burnt = np.minimum(brightness[:, None] * images, 0.9)
    found = semi_calibrated(burnt, lamps, burnt < 0.9)
    every = semi_calibrated(burnt, lamps)
    true = brightness / np.median(brightness)
    assert np.abs(found.values / true - 1).mean() < 0.5 * np.abs(every.values / true - 1).mean()


def test_what_cannot_be_told_is_refused() -> None:
    lamps, scaled = scene(12)
    images = np.maximum(lamps @ scaled.T, 0.01)
    with pytest.raises(HarmonicFaceError, match="at least 4"):
        semi_calibrated(images[:3], lamps[:3])
    with pytest.raises(HarmonicFaceError, match=r"shape \(12, 3\), got \(11, 3\)"):
        semi_calibrated(images, lamps[1:])
    with pytest.raises(HarmonicFaceError, match="a black image 4"):
        semi_calibrated(np.where(np.arange(12)[:, None] == 4, 0, images), lamps)
    with pytest.raises(HarmonicFaceError, match="any brightness explains"):
        semi_calibrated(np.outer(lamps @ [0.1, 0.2, 1.0], np.linspace(0.2, 0.9, 300)), lamps)  # a plane
    with pytest.raises(HarmonicFaceError, match="seed"):
        semi_calibrated(images, lamps, seed=-1)


@pytest.mark.data
def test_the_lamps_of_a_real_object(data_dir: Path) -> None:
    cat = load_diligent(data_dir / "diligent" / "catPNG")
    found = semi_calibrated(cat.grey(divided=False), cat.directions, ~cat.saturated())
    ratio = np.log(found.values / (cat.intensities @ LUMINANCE))
    assert np.std(ratio) < 0.05  # intensities themselves differ by a factor of six
