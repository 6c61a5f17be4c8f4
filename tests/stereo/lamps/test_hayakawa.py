"""Robust factorization into three: exact where nothing disturbs, shadows and highlights left out."""

import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.lamps.hayakawa import check_span, equalized, lights_of, linear_factors, middle_ranks
from harmonicface.stereo.lamps.matte_refinement import refined
from tests.stereo.lamp_scenes import angles, bumpy_ball, lamps


def best_linear(found, truth):
    """Turn normals into the true frame by the best matrix."""
    return found @ np.linalg.lstsq(found, truth, rcond=None)[0]


def test_shadows_and_highlights_do_not_bend_the_factors():
    normals, _ = bumpy_ball()
    images = np.maximum(lamps(40) @ normals.T, 0)
    random = np.random.default_rng(1)
    images[random.random(images.shape) < 0.1] *= 0.2
    images[random.random(images.shape) < 0.1] += 0.8
    right = np.linalg.svd(images, full_matrices=False)[2]
    plain = angles(best_linear(right[:3].T, normals), normals).mean()
    found = linear_factors(images)
    trimmed = angles(best_linear(found.scaled, normals), normals).mean()
    better = refined(images, found.lights, found.scaled, found.weights)
    robust = angles(best_linear(better.scaled, normals), normals).mean()
    assert robust < 0.5 * trimmed < 0.5 * plain


def test_saturated_observations_are_not_used():
    normals, _ = bumpy_ball()
    found = linear_factors(lamps(20) @ normals.T, 0.8)
    assert not (found.weights[(lamps(20) @ normals.T) >= 0.8]).any()


def test_few_photographs_keep_six_ranks():
    assert middle_ranks(np.random.default_rng(0).random((7, 5))).sum(axis=0).min() == 6


def test_lights_of_known_normals_are_exact():
    normals, truth = bumpy_ball()[0], lamps(5)
    images = truth @ normals.T
    assert np.allclose(lights_of(images, normals, np.ones_like(images)), truth)


def test_equalized_undoes_brightness():
    normals, _ = bumpy_ball()
    images = np.maximum(lamps(12) @ normals.T, 0)
    same, brightness = equalized(images * np.geomspace(1, 100, 12)[:, None])
    assert np.allclose(same, equalized(images)[0])
    assert np.allclose(brightness, equalized(images)[1] * np.geomspace(1, 100, 12))


@pytest.mark.parametrize("shape", [(2, 50), (5, 2)])
def test_too_little_is_refused(shape):
    with pytest.raises(HarmonicFaceError, match="at least 3"):
        linear_factors(np.ones(shape))


def test_mixtures_of_two_lamps_are_refused():
    normals, _ = bumpy_ball()
    mixtures = np.random.default_rng(0).uniform(0.2, 1, (8, 2)) @ lamps(2)
    with pytest.raises(HarmonicFaceError, match="mixtures of two"):
        linear_factors(mixtures @ normals.T)


def test_black_photograph_is_refused():
    images = np.ones((4, 30))
    images[2] = 0
    with pytest.raises(HarmonicFaceError, match="image 2 without"):
        equalized(images)


def test_lamps_in_a_plane_or_near_one_another_are_refused():
    normals, truth = bumpy_ball()[0], lamps(20)
    check_span(truth, normals)
    coplanar = truth * [1, 0.05, 1]
    for lights in (coplanar, lamps(20, widest=5), np.tile(truth[:1], (20, 1))):
        with pytest.raises(HarmonicFaceError, match="near one another or near one plane"):
            check_span(lights, normals)


def test_the_factors_of_exact_photographs_are_exact():
    random = np.random.default_rng(6)
    photographs = random.uniform(0.2, 1, (8, 3)) @ random.uniform(0.2, 1, (3, 50))
    found = linear_factors(photographs)
    assert np.abs(found.lights @ found.scaled.T - photographs).max() < 1e-12


def test_a_lamp_that_reaches_two_pixels_has_the_shortest_vector_that_explains_them():
    scaled = np.array([[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0]])
    found = lights_of(np.array([[3.0, 4.0, 5.0]]), scaled, np.array([[1.0, 1.0, 0.0]]))
    assert np.allclose(found, [[3.0, 2.0, 0.0]], atol=1e-14)
