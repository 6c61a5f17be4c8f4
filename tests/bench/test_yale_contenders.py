"""A method of the table is the classifier that it names."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import harmonicface as hf
from harmonicface.bench.contenders import GalleryContender, Person
from harmonicface.bench.yale_contenders import YALE_METHODS, ClassifierContender, ExemplarContender, yale_contender
from harmonicface.people.prior import synthetic_prior
from harmonicface.recognition.estimators.registry import ESTIMATORS, estimator

DIRECTIONS = [(0.1 * x, 0.1 * y, 1.0) for x in (-3, 0, 3) for y in (-3, 0, 3)]
FACES = list(hf.synthetic_people(3, 32, seed=1))
PEOPLE = [
    Person(
        name,  # not in the order of the alphabet
        np.stack([hf.photograph(hf.render(face, hf.lights.directional(towards)), 5) for towards in DIRECTIONS]),
        face,
        np.array(DIRECTIONS),
    )
    for name, face in zip(("zoe", "ada", "mia"), FACES, strict=True)
]


def test_every_name_of_the_registry_is_a_method() -> None:
    assert set(ESTIMATORS) < set(YALE_METHODS)
    assert len(set(YALE_METHODS)) == len(YALE_METHODS)
    assert {"default", "harmonic_shadowed_fixed"} < set(YALE_METHODS)


@pytest.mark.parametrize("name", YALE_METHODS)
def test_everybody_is_found_in_an_enrolled_photograph(name: str) -> None:
    method = ExemplarContender(synthetic_prior((48, 42), 20)) if name == "exemplar" else yale_contender(name)
    assert method.bytes_per_person == 0
    method.enroll(PEOPLE)
    assert [method.nearest(person.photographs[4]) for person in PEOPLE] == [0, 1, 2]


@pytest.mark.parametrize("name", ["correlation", "harmonic9"])
def test_distances_are_those_of_the_classifier_in_the_order_of_enrolment(name: str) -> None:
    method = yale_contender(name)
    assert isinstance(method, ClassifierContender)
    method.enroll(PEOPLE)
    photo = PEOPLE[2].photographs[0]
    table = np.concatenate([person.photographs.reshape(9, -1) for person in PEOPLE])
    if name == "correlation":
        judge = estimator(name).fit(table, np.repeat([2, 0, 1], 9))
    else:
        judge = type(estimator(name)).from_surfaces([2, 0, 1], FACES)  # type: ignore[attr-defined]
    expected = judge.predict_distances(photo.reshape(1, -1))[0]
    np.testing.assert_allclose(method.distances(photo), expected[[2, 0, 1]], rtol=1e-5)
    assert method.bytes_per_person > 1000


def test_the_default_is_what_a_gallery_does() -> None:
    method = yale_contender("default")
    assert isinstance(method, GalleryContender)
    method.enroll(PEOPLE)
    assert method.bytes_per_person >= 2 * 32 * 32
    photo = PEOPLE[1].photographs[3]
    assert method.distances(photo).argmin() == method.nearest(photo) == 1


def test_an_exemplar_is_one_photograph_the_most_frontal_one() -> None:
    assert isinstance(yale_contender("exemplar"), ExemplarContender)
    asked = PEOPLE[0].photographs[2]
    answers = []
    for people in (PEOPLE, [replace(person, photographs=person.photographs[4:5], lights=None) for person in PEOPLE]):
        method = ExemplarContender(synthetic_prior((48, 42), 20))
        method.enroll(people)
        answers.append(method.distances(asked))
    np.testing.assert_array_equal(*answers)


def test_lights_are_needed_for_nine_points() -> None:
    blind = [Person(person.name, person.photographs, None) for person in PEOPLE]
    with pytest.raises(hf.HarmonicFaceError, match="zoe: expected directions to the lights, got none"):
        yale_contender("nine_points_real").enroll(blind)
    with pytest.raises(hf.HarmonicFaceError, match="zoe: expected photographs that give a Surface"):
        yale_contender("harmonic9").enroll(blind)


def test_no_such_method() -> None:
    with pytest.raises(hf.HarmonicFaceError, match=r"method: expected one of correlation, .*, default, got 'magic'"):
        yale_contender("magic")
