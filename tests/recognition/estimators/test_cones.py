"""Cones: distances against SciPy on all pixels, lamps that lie inside, extreme rays."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import nnls

import harmonicface as hf
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.recognition.estimators.cone import NearestCone
from harmonicface.recognition.estimators.harmonic import Harmonic9
from harmonicface.recognition.estimators.illumination_cone import (
    ConeAttached,
    ConeCast,
    extreme_directions,
    front_directions,
)
from harmonicface.recognition.estimators.nonnegative_light import HarmonicNonnegative
from harmonicface.recognition.models import harmonic9

NAMES = ["ada", "bob"]


@pytest.fixture(scope="module")
def people() -> list[hf.Surface]:
    return [hf.synthetic_person(seed, size=24) for seed in range(2)]


def photo(person: hf.Surface, direction: list[float], shadows: bool = False) -> np.ndarray:
    return hf.render(person, hf.lights.directional(direction), shadows=shadows).reshape(1, -1)


@pytest.mark.parametrize("make", [ConeAttached, ConeCast, HarmonicNonnegative])
def test_distances_are_scipys_on_all_pixels(make: type[NearestCone], people: list[hf.Surface]) -> None:
    classifier = make.from_surfaces(NAMES, people, directions=60)
    query = photo(people[1], [0.7, -0.4, 0.5]) + np.random.default_rng(0).normal(0, 0.05, (1, 24 * 24))
    for person, found in zip(people, classifier.predict_distances(query)[0], strict=True):
        expected = nnls(classifier._placed(person).T.astype(float), query[0])[1] / np.linalg.norm(query)
        assert found == pytest.approx(expected, abs=3e-4)


@pytest.mark.parametrize("make", [ConeAttached, ConeCast])
def test_two_lamps_of_the_cone_lie_in_it(make: type[NearestCone], people: list[hf.Surface]) -> None:
    classifier = make.from_surfaces(NAMES, people, directions=60)
    lamps = front_directions(60)
    shadows = make is ConeCast
    query = photo(people[1], lamps[10], shadows) + 0.5 * photo(people[1], lamps[20], shadows)
    distances = classifier.predict_distances(query)[0]
    assert distances[1] < 2e-3 < distances[0]


def test_a_negative_of_a_photograph_is_in_no_cone(people: list[hf.Surface]) -> None:
    query = -photo(people[1], [0.2, 0.1, 1.0])
    assert ConeAttached.from_surfaces(NAMES, people, directions=60).predict_distances(query).tolist() == [[1, 1]]
    assert Harmonic9.from_surfaces(NAMES, people).predict_distances(query)[0, 1] < 0.1


def test_nonnegative_light_explains_less_than_any_light(people: list[hf.Surface]) -> None:
    """Pictures under light of either sign are all explained by nine coefficients, but not by lamps."""
    queries = np.zeros((20, 24 * 24))
    queries[:, people[0].mask.ravel()] = np.random.default_rng(3).normal(size=(20, 9)) @ harmonic9(people[0])
    free = Harmonic9.from_surfaces(NAMES, people).predict_distances(queries)
    positive = HarmonicNonnegative.from_surfaces(NAMES, people).predict_distances(queries)
    assert free[:, 0].max() < 4e-3
    assert (positive[:, 0] > 0.05).sum() >= 10
    assert (positive >= free - 4e-3).all()


def test_the_pictures_of_nonnegative_light_are_those_of_lamps_by_harmonics(people: list[hf.Surface]) -> None:
    lamp = hf.lights.directional([0.6, 0.0, 0.8])
    expected = lamp.coefficients(2) @ harmonic9(people[0])
    found = real_harmonics(np.array([[0.6, 0.0, 0.8]]), 2).T @ harmonic9(people[0])
    np.testing.assert_allclose(found[0], expected, rtol=1e-4, atol=1e-5)


def test_extreme_rays_put_two_pixels_on_the_edge_of_the_shadow(people: list[hf.Surface]) -> None:
    lamps = extreme_directions(people[0], 20, seed=4)
    on_edge = np.abs(lamps @ people[0].pixel_normals.T.astype(float)) < 1e-6
    assert lamps.shape == (20, 3) and (on_edge.sum(axis=1) >= 2).all()
    np.testing.assert_allclose(np.linalg.norm(lamps, axis=1), 1)
    classifier = ConeAttached.from_surfaces(NAMES, people, rays="extreme", directions=200)
    assert classifier.predict(photo(people[1], [0.5, 0.5, 1.0]))[0] == "bob"


def test_lamps_behind_are_left_out() -> None:
    lamps = front_directions(400)
    assert 200 < len(lamps) < 300 and lamps[:, 2].min() >= -0.2


def test_bad_parameters_are_refused(people: list[hf.Surface]) -> None:
    with pytest.raises(HarmonicFaceError, match='rays: expected "sampled" or "extreme", got \'all\''):
        ConeAttached.from_surfaces(NAMES, people, rays="all")
    with pytest.raises(HarmonicFaceError, match="directions: expected an integer of at least 1"):
        ConeAttached.from_surfaces(NAMES, people, directions=0)
    with pytest.raises(HarmonicFaceError, match="random_state: expected an integer"):
        ConeAttached.from_surfaces(NAMES, people, rays="extreme", random_state=-1)


def test_a_wall_has_no_extreme_rays() -> None:
    wall = hf.Surface(np.tile([0.0, 0.0, 1.0], (4, 4, 1)), np.ones((4, 4)))
    with pytest.raises(HarmonicFaceError, match="normals that differ"):
        extreme_directions(wall, 10)


def test_cast_shadows_need_depth() -> None:
    wall = hf.Surface(np.tile([0.0, 0.0, 1.0], (4, 4, 1)), np.ones((4, 4)))
    with pytest.raises(HarmonicFaceError, match="expected a scene or depth"):
        ConeCast.from_surfaces(["wall"], [wall])
