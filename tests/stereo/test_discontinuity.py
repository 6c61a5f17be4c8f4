from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.discontinuity import integrate_bilaterally
from harmonicface.stereo.integration import integrate_normals

Doubles = NDArray[np.float64]


def cut(size: int = 48) -> tuple[Doubles, Doubles]:
    """Normals and depth of a plate that is whole below and cut above, where its right half bends toward the camera."""
    rows, columns = np.mgrid[:size, :size].astype(float)
    up = np.maximum((size / 2 - 0.5 - rows) / size, 0)
    right = columns >= size / 2
    depth = np.where(right, 30 * up**1.5, 0.0)
    slope = np.where(right, 45 * np.sqrt(up) / size, 0.0)
    normals = np.stack([np.zeros_like(slope), -slope, np.ones_like(slope)], axis=2)
    return normals / np.linalg.norm(normals, axis=2, keepdims=True), depth


def error(found: Doubles, depth: Doubles) -> float:
    rest = found - depth
    return float(np.sqrt(np.mean((rest - np.median(rest)) ** 2)))


def test_a_cut_stays_a_cut() -> None:
    normals, depth = cut()
    smooth = error(integrate_normals(normals), depth)
    assert error(integrate_bilaterally(normals), depth) < 0.35 * smooth
    assert error(integrate_bilaterally(normals, sharpness=20), depth) < 0.06 * smooth


def test_what_is_whole_is_as_without_it() -> None:
    rows, columns = np.mgrid[:30, :30] - 14.5
    squared = rows**2 + columns**2
    inside = squared < 14**2
    z = np.sqrt(np.maximum(16**2 - squared, 1))
    normals = np.stack([columns, -rows, z], axis=2) / np.sqrt(squared + z**2)[..., None]
    found = integrate_bilaterally(normals, inside, pixel_size=0.5)
    assert_allclose(found[inside], integrate_normals(normals, inside, 0.5)[inside], atol=1e-6)
    assert np.isnan(found[~inside]).all()


def test_before_a_pinhole_a_wall_is_a_wall() -> None:
    wall = np.tile([0.0, 0.0, 1.0], (12, 15, 1))
    found = integrate_bilaterally(wall, intrinsics=(100, 100, 7, 6), distance=3.0)
    assert_allclose(found, -3, rtol=1e-9)


def test_a_cut_before_a_pinhole() -> None:
    normals, depth = cut()
    focal = 1e5
    found = integrate_bilaterally(normals, intrinsics=(focal, focal, 24, 24), distance=focal, sharpness=20)
    assert error(found, depth) < 0.06 * error(integrate_normals(normals), depth)


def test_one_column_has_no_sides() -> None:
    assert_allclose(integrate_bilaterally(np.tile([0.0, 0.6, 0.8], (4, 1, 1)))[:, 0], [-1.125, -0.375, 0.375, 1.125])


def test_refuses_what_is_no_sharpness() -> None:
    with pytest.raises(HarmonicFaceError, match="sharpness: expected a finite number above 0"):
        integrate_bilaterally(cut(8)[0], sharpness=0)
    with pytest.raises(HarmonicFaceError, match="pixel_size: expected a finite number above 0"):
        integrate_bilaterally(cut(8)[0], pixel_size=-1)
