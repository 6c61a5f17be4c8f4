"""Affinities: the same person under other light is more alike than another one under the same."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import nnls

from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.affinities import conic_affinity, gradient_affinity, pattern_affinity
from harmonicface.recognition.patterns import Template, patterns, similarity

SIZE = 48


@pytest.fixture(scope="module")
def images() -> np.ndarray:
    """Two people under three lights that shade them smoothly."""
    random = np.random.default_rng(0)
    people = random.uniform(0.2, 1, (2, SIZE, SIZE))
    across = np.linspace(0.1, 1, SIZE)
    lights = np.stack([np.tile(across, (SIZE, 1)), np.tile(across[::-1], (SIZE, 1)), np.tile(across, (SIZE, 1)).T])
    return (people[:, None] * lights).reshape(6, SIZE, SIZE)


SAME = np.kron(np.eye(2), np.ones((3, 3))).astype(bool) & ~np.eye(6, dtype=bool)
OTHERS = np.kron(1 - np.eye(2), np.ones((3, 3))).astype(bool)


@pytest.mark.parametrize("affinity", [pattern_affinity, gradient_affinity])
def test_people_are_more_alike_than_lights(affinity, images: np.ndarray) -> None:
    found = affinity(images)
    assert found[SAME].min() > found[OTHERS].max() + 0.1


@pytest.mark.parametrize("affinity", [pattern_affinity, gradient_affinity])
def test_symmetric_and_blind_to_brightness(affinity, images: np.ndarray) -> None:
    found = affinity(images)
    np.testing.assert_allclose(found, found.T, atol=1e-6)
    np.testing.assert_allclose(affinity(1000 * images), found, atol=1e-4)


def test_patterns_are_compared_as_templates_are(images: np.ndarray) -> None:
    templates = [Template.of([patterns(image)]) for image in images[1:]]
    expected = similarity(patterns(images[0]), templates, reach=2).scores
    np.testing.assert_allclose(pattern_affinity(images)[0, 1:], expected, atol=2e-3)


def test_a_small_shift_is_the_same_person(images: np.ndarray) -> None:
    moved = np.roll(images[0], (2, -1), axis=(0, 1))
    found = pattern_affinity(np.stack([images[0], moved, images[3]]))
    assert found[0, 1] > 0.7 > 0.4 > found[0, 2]


def test_darkness_and_walls_resemble_nobody(images: np.ndarray) -> None:
    found = pattern_affinity(np.stack([images[0], np.zeros((SIZE, SIZE)), np.ones((SIZE, SIZE))]))
    np.testing.assert_allclose(found, np.eye(3))
    assert not gradient_affinity(np.ones((2, SIZE, SIZE))).any()


def test_cone_is_scipy_s(images: np.ndarray) -> None:
    rows = images.reshape(6, -1)
    unit = rows / np.linalg.norm(rows, axis=1, keepdims=True)
    weights = np.zeros((6, 6))
    for i in range(6):
        others = np.arange(6) != i
        weights[i, others] = nnls(unit[others].T, unit[i])[0]
    np.testing.assert_allclose(conic_affinity(rows), (weights + weights.T) / 2, atol=5e-3)


def test_cone_of_a_combination() -> None:
    rays = np.random.default_rng(1).uniform(0, 1, (3, 40))
    mixed = 0.3 * rays[0] + 2 * rays[1]
    stranger = np.zeros(43)
    stranger[40:] = 1
    rows = np.concatenate([np.pad(np.stack([*rays, mixed]), ((0, 0), (0, 3))), stranger[None]])
    found = conic_affinity(rows)
    assert not found[4].any() and not found.diagonal().any()
    assert found[3, 0] > 0.02 and found[3, 1] > 0.3


def test_a_black_photograph_is_in_no_cone() -> None:
    rows = np.abs(np.random.default_rng(2).normal(size=(3, 20)))
    rows[1] = 0
    found = conic_affinity(rows)
    assert np.isfinite(found).all() and not found[1].any()


@pytest.mark.parametrize("affinity", [pattern_affinity, gradient_affinity])
def test_photographs_that_are_too_small(affinity) -> None:
    with pytest.raises(HarmonicFaceError, match="at least 24 pixels a side"):
        affinity(np.ones((2, 12, 12)))
