"""Each cue finds a known relief where it may, and says when it cannot; pooling weighs them."""

import numpy as np

from harmonicface.stereo.lamps.bas_relief_cues import (
    ALBEDO_BIAS,
    Cue,
    equal_albedo,
    equal_lamps,
    highlights,
    matrix_of,
    pooled,
    usual,
)
from tests.stereo.lamp_scenes import bumpy_ball, lamps

NORMALS, MASK = bumpy_ball()
RELIEF = np.array([0.1, -0.15, 0.2])
TWISTED = NORMALS @ np.linalg.inv(matrix_of(RELIEF)).T  # the cue should answer with the relief
LIGHTS = lamps(40)


def test_equal_albedo_finds_the_relief_of_a_matte_thing():
    found = equal_albedo(TWISTED, MASK)
    assert np.allclose(found.relief + np.array([0, 0, ALBEDO_BIAS]), RELIEF, atol=0.02)


def test_patches_of_albedo_are_outvoted_and_widen_the_error():
    patches = np.where(np.add.outer(np.arange(48) // 8, np.arange(48) // 8) % 2, 0.3, 1.0)[MASK]
    found = equal_albedo(TWISTED * patches[:, None], MASK)
    assert np.abs(found.relief - RELIEF)[:2].max() < 0.15
    assert (found.deviations >= equal_albedo(TWISTED, MASK).deviations - 0.01).all()


def test_black_pixels_are_no_neighbours():
    scaled = TWISTED.copy()
    scaled[::7] = 0
    assert np.isfinite(equal_albedo(scaled, MASK).relief).all()


def gloss(sharpness: float) -> np.ndarray:
    """Return matte photographs with lobes about the bisector of lamp and camera."""
    bisectors = LIGHTS + np.array([0, 0, 1])
    bisectors /= np.linalg.norm(bisectors, axis=1, keepdims=True)
    return np.maximum(LIGHTS @ NORMALS.T, 0) + 0.5 * np.maximum(bisectors @ NORMALS.T, 0) ** sharpness


def test_highlights_find_the_relief_of_a_glossy_thing():
    seen_lights = LIGHTS @ matrix_of(RELIEF)
    found = highlights(gloss(60), seen_lights, TWISTED, RELIEF + np.array([0.1, -0.1, 0.15]))
    assert np.abs(found.relief - RELIEF).max() < 0.12
    assert found.deviations.max() < 0.2


def test_highlights_of_a_matte_thing_say_that_they_do_not_know():
    noise = np.random.default_rng(0).normal(0, 0.002, (40, len(NORMALS)))
    found = highlights(LIGHTS @ NORMALS.T + noise, LIGHTS, NORMALS, np.zeros(3))
    assert found.deviations.min() > 0.5


def test_highlights_of_too_few_observations_say_nothing():
    found = highlights(LIGHTS[:4] @ NORMALS[:5].T, LIGHTS[:4], NORMALS[:5], np.zeros(3))
    assert found.deviations.min() == 1e3


def test_equal_lamps_are_noticed_and_unequal_ones_are_not():
    found = equal_lamps(LIGHTS @ matrix_of(RELIEF))
    assert np.allclose(found.relief, RELIEF, atol=1e-3)
    random = np.random.default_rng(0)
    assert equal_lamps(LIGHTS * np.exp(random.normal(0, 0.5, (40, 1)))) is None
    assert equal_lamps(LIGHTS[:6]) is None


def test_contradiction_widens_the_error():
    agreeing = [Cue("a", np.zeros(3), np.full(3, 0.1)), Cue("b", np.zeros(3), np.full(3, 0.1))]
    other = [agreeing[0], Cue("b", np.full(3, 1.0), np.full(3, 0.1))]
    assert np.allclose(pooled(agreeing).deviations, 0.1 / np.sqrt(2))
    assert np.allclose(pooled(other).relief, 0.5) and (pooled(other).deviations > 0.4).all()


def test_what_is_usual_is_weak():
    sure = Cue("sure", RELIEF, np.full(3, 0.02))
    assert np.allclose(pooled([usual(), sure]).relief, RELIEF, atol=0.01)
