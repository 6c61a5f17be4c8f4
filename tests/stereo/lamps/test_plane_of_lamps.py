"""Lamps in one plane are noticed although shadows make a third factor."""

import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.lamps.unknown_directions import unknown_directions
from harmonicface.stereo.lamps.unknown_lamps import unknown_lamps
from tests.stereo.lamp_scenes import bumpy_ball, lamps

NORMALS, MASK = bumpy_ball()


def photographs(lights: np.ndarray) -> np.ndarray:
    """Return noisy pictures with attached shadows."""
    noise = np.random.default_rng(0).normal(0, 0.003, (len(lights), len(NORMALS)))
    return np.maximum(lights @ NORMALS.T, 0) + noise


@pytest.mark.parametrize("solve", [unknown_lamps, unknown_directions])
@pytest.mark.parametrize("seed", [0, 3])
def test_a_plane_is_refused(solve, seed):
    coplanar = lamps(16, seed) * [1, 0, 1]
    coplanar /= np.linalg.norm(coplanar, axis=1, keepdims=True)
    with pytest.raises(HarmonicFaceError, match="one plane"):
        solve(photographs(coplanar), MASK)


@pytest.mark.parametrize("count", [5, 6, 16])
def test_others_are_not(count):
    assert len(unknown_lamps(photographs(lamps(count)), MASK, method="least_squares").lights) == count
