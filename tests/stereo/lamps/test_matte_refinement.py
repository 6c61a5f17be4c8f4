"""Refinement lowers its cost every round, keeps its frame, and leaves what is perfect alone."""

import numpy as np

from harmonicface.stereo.lamps.matte_refinement import refined
from tests.stereo.lamp_scenes import angles, bumpy_ball, lamps

NORMALS, _ = bumpy_ball(32)
LIGHTS = lamps(20)
IMAGES = np.maximum(LIGHTS @ NORMALS.T, 0)
ALL = np.ones_like(IMAGES)


def test_cost_never_rises_and_normals_come_nearer():
    random = np.random.default_rng(0)
    images = IMAGES + 0.5 * (random.random(IMAGES.shape) < 0.15)
    start = NORMALS + random.normal(0, 0.1, NORMALS.shape)
    found = refined(images, LIGHTS, start, ALL)
    assert (np.diff(found.costs) < 0).all() and len(found.costs) > 2
    assert angles(found.scaled, NORMALS).mean() < 0.3 * angles(start, NORMALS).mean()


def test_frame_of_the_start_is_kept():
    matrix = np.random.default_rng(1).normal(size=(3, 3))
    images = LIGHTS @ NORMALS.T + np.random.default_rng(2).normal(0, 0.01, IMAGES.shape)
    plain = refined(images, LIGHTS, NORMALS, ALL)
    turned = refined(images, LIGHTS @ np.linalg.inv(matrix), NORMALS @ matrix.T, ALL)
    assert np.allclose(turned.scaled, plain.scaled @ matrix.T, atol=1e-3)
    assert np.allclose(turned.lights @ matrix, plain.lights, atol=1e-3)


def test_perfect_start_stays():
    images = LIGHTS @ NORMALS.T
    found = refined(images, LIGHTS, NORMALS, ALL)
    assert np.allclose(found.scaled, NORMALS, atol=1e-6)


def test_observations_without_weight_count_for_nothing():
    images = LIGHTS @ NORMALS.T
    spoilt, weights = images.copy(), ALL.copy()
    spoilt[4], weights[4] = 7.0, 0.0
    weights[4, ::2] = 1.0
    spoilt[4, ::2] = images[4, ::2]
    assert np.allclose(refined(spoilt, LIGHTS, NORMALS, weights).scaled, NORMALS, atol=1e-6)
