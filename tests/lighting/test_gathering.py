"""Fewer lamps in place of many: nothing is lost, and what looks at them sees the same."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.lighting.gathering import gathered

RNG = np.random.default_rng(0)
TOWARDS = RNG.normal(size=(50_000, 3))
TOWARDS /= np.linalg.norm(TOWARDS, axis=1, keepdims=True)
STRENGTHS = RNG.uniform(size=(50_000, 3)) ** 8  # few are bright


@pytest.mark.parametrize("strengths", [STRENGTHS, STRENGTHS[:, 0]], ids=["colour", "grey"])
@pytest.mark.parametrize("angle", [0.03, 0.1, 0.5])
def test_nothing_is_lost(strengths: np.ndarray, angle: float) -> None:
    towards, merged = gathered(TOWARDS, strengths, angle)
    assert len(towards) == len(merged) <= 1.2 * 4 * np.pi / angle**2 + 20
    assert_allclose(merged.sum(axis=0), strengths.sum(axis=0), rtol=1e-12)
    assert_allclose(np.linalg.norm(towards, axis=1), 1, rtol=1e-12)
    assert merged.min() >= 0


@pytest.mark.parametrize("angle", [0.05, 0.1, 0.2])
def test_each_lamp_is_near_its_patch(angle: float) -> None:
    """Every lamp's light comes within a patch's reach of where it was."""
    few = RNG.choice(len(TOWARDS), 200, replace=False)
    strengths = np.zeros(len(TOWARDS))
    strengths[few] = 1
    towards, merged = gathered(TOWARDS, strengths, angle)
    nearest = np.arccos(np.clip((TOWARDS[few] @ towards.T).max(axis=1), -1, 1))
    assert nearest.max() < 2 * angle
    assert len(merged) <= 200


@pytest.mark.parametrize("sigma", [0.1, 0.3])
def test_the_error_of_a_kernel_is_as_told(sigma: float) -> None:
    angle = sigma / 4
    looking = TOWARDS[:50]
    kernels = []
    for towards, strengths in ((TOWARDS, STRENGTHS[:, 0]), gathered(TOWARDS, STRENGTHS[:, 0], angle)):
        kernels.append(np.exp((looking @ towards.T - 1) / sigma**2) @ strengths)
    assert np.sqrt(np.mean((kernels[1] / kernels[0] - 1) ** 2)) < (angle / sigma) ** 2 / 12


def test_few_lamps_stay_as_they_are() -> None:
    towards, strengths = gathered(TOWARDS[:20], STRENGTHS[:20], 0.1)
    assert_allclose(towards, TOWARDS[:20], rtol=0)
    assert_allclose(strengths, STRENGTHS[:20], rtol=0)


def test_darkness() -> None:
    towards, strengths = gathered(TOWARDS, np.zeros(len(TOWARDS)), 0.5)
    assert towards.shape == (0, 3)
    assert strengths.shape == (0,)


@pytest.mark.parametrize(
    ("directions", "strengths", "angle", "message"),
    [
        ([[0, 0, 2.0]], [1.0], 0.1, "directions: expected unit vectors"),
        ([[0, 0, 1.0]], [1.0, 2.0], 0.1, "strengths: expected one or three a direction, got .2,. for .1,."),
        ([0, 0, 1.0], [1.0], 0.1, "strengths: expected one or three a direction"),
        ([[0, 0, 1.0]], [np.nan], 0.1, "strengths: expected finite numbers"),
        ([[0, 0, 1.0]], [1.0], 0, "angle: expected a finite number above 0"),
    ],
)
def test_what_cannot_be_gathered(directions: object, strengths: object, angle: float, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        gathered(directions, strengths, angle)  # type: ignore[arg-type]
