"""Hard photographs: what they are said to be."""

from __future__ import annotations

import numpy as np
import pytest

from harmonicface.bench.stability.hard_photographs import COUNT, NOISE, HardCase, hard_cases, lamps

CASES = {case.name: case for case in hard_cases(20)}


@pytest.mark.parametrize("name", CASES)
def test_shapes_agree(name: str) -> None:
    case = CASES[name]
    assert case.images.shape == (len(case.lights), *case.mask.shape)
    assert case.normals.shape == (case.mask.sum(), 3)
    lengths = np.linalg.norm(case.normals, axis=1)
    assert np.allclose(lengths[np.isfinite(lengths)], 1)


def test_the_usual_photographs_are_lambert_s() -> None:
    case = CASES["nothing hard"]
    shading = np.maximum(case.lights @ case.normals.T, 0)
    seen = case.images[:, case.mask]
    albedo = (seen * shading).sum(axis=0) / (shading**2).sum(axis=0)
    assert set(albedo.round(1)) <= {0.5, 0.6, 0.7, 0.8}
    assert np.abs(seen - albedo * shading).std() < 1.5 * NOISE


@pytest.mark.parametrize(
    ("name", "values"), [("all lamps in a plane with the camera", 2), ("one lamp for all photographs", 1)]
)
def test_lamps_span_what_they_are_said_to(name: str, values: int) -> None:
    assert np.linalg.matrix_rank(CASES[name].lights) == values


def test_lamps_stay_within_their_angle() -> None:
    assert np.degrees(np.arccos(lamps(200, 5)[:, 2])).max() <= 5


def share_dark(case: HardCase) -> float:
    return float((case.images[:, case.mask] < 0.04).mean())


def test_shades_and_saturation() -> None:
    assert share_dark(CASES["no shadows at all"]) < 0.01
    assert 0.4 < share_dark(CASES["half the pixels in cast shadow"]) < 0.65
    for name in ("saturated highlights", "broad saturated highlights"):
        assert (CASES[name].images == 1).mean() > 0.005


def test_brightness_spans_a_hundred() -> None:
    brightness = CASES["lamps of 1 : 100, told"].known["intensities"]
    assert brightness.max() / brightness.min() == pytest.approx(100) and len(brightness) == COUNT
