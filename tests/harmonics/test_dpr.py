"""DPR's nine numbers: the shading that its published formula gives is the irradiance that ours gives."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.dpr import from_dpr, to_dpr


def dpr_shading(numbers: np.ndarray, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Their shading, at normals with x right, y away from the camera, z up."""
    basis = [
        0.5 * np.ones_like(x),
        np.sqrt(3) / 2 * y * 2 / 3,
        np.sqrt(3) / 2 * z * 2 / 3,
        np.sqrt(3) / 2 * x * 2 / 3,
        np.sqrt(15) / 2 * y * x / 4,
        np.sqrt(15) / 2 * y * z / 4,
        np.sqrt(5) / 4 * (3 * z**2 - 1) / 4,
        np.sqrt(15) / 2 * x * z / 4,
        np.sqrt(15) / 4 * (x**2 - y**2) / 4,
    ]
    return np.sqrt(np.pi) * np.tensordot(numbers, basis, (0, 0))


def test_their_shading_is_our_irradiance(random_directions) -> None:
    normals = random_directions(50)
    numbers = np.random.default_rng(0).normal(size=9)
    theirs = dpr_shading(numbers, normals[:, 0], -normals[:, 2], normals[:, 1])
    filtered = np.repeat([np.pi, 2 * np.pi / 3, np.pi / 4], [1, 3, 5])
    ours = (filtered * from_dpr(numbers)) @ real_harmonics(normals, 2)
    assert_allclose(ours, theirs, rtol=0, atol=1e-13)


def test_light_toward_their_camera_is_light_from_ours() -> None:
    frontal = from_dpr([1, -0.6, 0, 0.2, 0, 0, 0, 0, 0])  # -y of theirs is +z of ours
    assert_allclose(frontal[:4], [1, 0, 0.6, 0.2], rtol=0, atol=1e-15)


@pytest.mark.parametrize("channels", [(), (3,)])
def test_there_and_back(channels: tuple[int, ...]) -> None:
    numbers = np.random.default_rng(1).normal(size=(9, *channels))
    assert_allclose(to_dpr(from_dpr(numbers)), numbers, rtol=0, atol=1e-14)


@pytest.mark.parametrize("bad", [np.ones(4), np.ones(16), [np.nan] * 9, "light"])
def test_not_nine_numbers(bad: object) -> None:
    for function in (from_dpr, to_dpr):
        with pytest.raises(HarmonicFaceError, match="coefficients: expected"):
            function(bad)
