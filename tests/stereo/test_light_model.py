"""Which light model explains photographs to their noise."""

from __future__ import annotations

import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.stereo.factors import leading_factors
from harmonicface.stereo.light_model import choose_light_model, photograph_noise

MASK = np.ones((40, 40), bool)
NOISE = 0.01


def photographs(order, count=20, noise=NOISE, lamps=False):
    """Return photographs of a ball's front under light of an order, or under lamps with shadows."""
    y, x = np.mgrid[0.7:-0.7:40j, -0.7:0.7:40j]
    normals = np.stack([x, y, np.sqrt(1 - x**2 - y**2)], axis=-1).reshape(-1, 3)
    rng = np.random.default_rng(3)
    if lamps:
        directions = rng.normal(size=(count, 3)) * [1, 1, 0.5]
        lit = np.maximum(directions / np.linalg.norm(directions, axis=1, keepdims=True) @ normals.T, 0)
    else:
        harmonics = real_harmonics(normals, 2)[[3, 1, 2]] if order is None else real_harmonics(normals, order)
        light = rng.normal(size=(count, len(harmonics)))
        if order is not None:
            light[:, 0] += 15  # a sky: nothing is black
        lit = light @ harmonics
    return lit + noise * rng.normal(size=lit.shape)


@pytest.mark.parametrize(("order", "model"), [(None, "linear3"), (1, "ambient4"), (2, "harmonic9")])
def test_smallest_model_that_leaves_noise(order, model):
    found = choose_light_model(photographs(order), MASK)
    assert found.model == model
    assert 0.8 * NOISE < found.noise < 1.25 * NOISE
    assert "the noise is" in found.reason


def test_more_noise_hides_the_smaller_parts():
    assert choose_light_model(photographs(2, noise=0.01), MASK).model == "harmonic9"
    assert choose_light_model(photographs(2), MASK, noise=10.0).model == "linear3"


def test_noise_is_found_under_smooth_shading():
    pixels = photographs(2, noise=0.03)
    assert photograph_noise(pixels, leading_factors(pixels, 12), MASK) == pytest.approx(0.03, rel=0.1)


def test_noise_of_pixels_without_neighbours_is_the_residual():
    pixels = photographs(2)[:, :2]
    factors = leading_factors(pixels, 1)
    assert photograph_noise(pixels, factors, np.ones((2, 1), bool)) == factors.residual(1)


def test_black_shadows_are_those_of_lamps():
    found = choose_light_model(photographs(None, lamps=True), MASK)
    assert found.model == "linear3" and "are black" in found.reason


def test_what_no_model_explains_takes_the_largest_there_are_photographs_for():
    shades = photographs(4, 30)
    found = choose_light_model(shades, MASK)
    assert found.model == "harmonic9" and found.reason.startswith("no model explains")
    few = choose_light_model(shades[:8], MASK)
    assert few.model == "ambient4" and "need more than 8 photographs" in few.reason


@pytest.mark.parametrize(
    ("pixels", "noise", "message"),
    [
        (np.ones((2, 1600)), None, "expected at least 3 photographs of the 1600 pixels"),
        (np.ones((5, 1599)), None, "expected at least 3 photographs of the 1600 pixels"),
        (np.ones(1600), None, "expected at least 3 photographs"),
        (np.ones((5, 1600)), 0.0, "noise: expected a finite number above 0"),
        (np.full((5, 1600), np.nan), None, "photographs: expected finite intensities"),
    ],
)
def test_refusals(pixels, noise, message):
    with pytest.raises(HarmonicFaceError, match=message):
        choose_light_model(pixels, MASK, noise)
