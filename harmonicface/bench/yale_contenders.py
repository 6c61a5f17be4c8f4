"""The methods that are compared on real photographs: classifiers, each enrolled and asked in the same way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.bench.contenders import Contender, GalleryContender, Person, ShiftedContender
from harmonicface.errors import HarmonicFaceError
from harmonicface.people.prior import FacePrior
from harmonicface.recognition.estimators.base import FaceClassifier
from harmonicface.recognition.estimators.registry import ESTIMATORS, FROM_SURFACES, estimator
from harmonicface.recognition.patterns import Template, patterns, similarity

WITH_LIGHTS = ("nine_points_real",)  # of those that learn from photographs
NEEDING_DEPTH = ("harmonic_shadowed", "harmonic_shadowed_fixed", "cone_cast")
PLAIN = {"harmonic_shadowed_fixed": "harmonic_shadowed"}  # a method's name in the table, its classifier's
SEARCHING = "harmonic_shadowed"
ONE_PHOTOGRAPH = "exemplar"
OTHERS = (SEARCHING, *PLAIN, ONE_PHOTOGRAPH, "patterns", "default")  # that take more than a classifier's call
YALE_METHODS = (*(name for name in ESTIMATORS if name not in OTHERS), *OTHERS)


@runtime_checkable
class Scoring(Protocol):
    """A method that says how far everybody is, not only who is nearest."""

    def distances(self, photo: Floats) -> NDArray[np.float64]:
        """Return how far everybody is, in the order of enrolment, (n,)."""


class ClassifierContender:
    """A scikit-learn classifier of the package."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._classifier = self._new()
        self._order: NDArray[np.intp] = np.empty(0, np.intp)
        self._bytes = 0.0

    @property
    def bytes_per_person(self) -> float:
        """Memory that a person costs: of the arrays that were learned."""
        return self._bytes

    def enroll(self, people: Sequence[Person]) -> None:
        """Learn everybody from her Surface, or from her photographs if the method knows only these."""
        names = [person.name for person in people]
        if self._name in FROM_SURFACES:
            self._classifier = type(self._classifier).from_surfaces(names, [person.surface for person in people])
        else:
            self._fit(people)
        self._order = np.searchsorted(self._classifier.classes_, names)
        learned = (value for key, value in vars(self._classifier).items() if key.endswith("_"))
        self._bytes = sum(value.nbytes for value in learned if isinstance(value, np.ndarray)) / len(people)

    @property
    def kind(self) -> type[FaceClassifier]:
        """Which classifier it is."""
        return type(self._classifier)

    def distances(self, photo: Floats) -> NDArray[np.float64]:
        """Return how far everybody is, in the order of enrolment."""
        row = np.asarray(self._classifier.predict_distances(photo.reshape(1, -1))[0], np.float64)
        return np.asarray(row[self._order])

    def nearest(self, photo: Floats) -> int:
        """Return the index of the nearest person."""
        return int(self.distances(photo).argmin())

    def _new(self, shape: tuple[int, int] | None = None) -> FaceClassifier:
        return estimator(self._name, shape)

    def _fit(self, people: Sequence[Person]) -> None:
        """Learn from photographs as rows of a table."""
        stack = np.concatenate([person.photographs for person in people])
        self._classifier = self._new((stack.shape[1], stack.shape[2]))
        names = np.repeat([person.name for person in people], [len(person.photographs) for person in people])
        known: dict[str, Any] = {}
        if self._name in WITH_LIGHTS:
            known["lights"] = np.concatenate([_lights(person) for person in people])
        self._classifier.fit(stack.reshape(len(stack), -1), names, **known)


class ExemplarContender(ClassifierContender):
    """Nine harmonic images from one photograph a person, the most frontal one, by a prior of faces."""

    def __init__(self, prior: FacePrior | None = None) -> None:
        self._prior = prior
        super().__init__(ONE_PHOTOGRAPH)

    def enroll(self, people: Sequence[Person]) -> None:
        """Learn everybody from one photograph; its light is not told."""
        super().enroll([replace(person, photographs=_most_frontal(person)[None]) for person in people])

    def _new(self, shape: tuple[int, int] | None = None) -> FaceClassifier:
        return estimator(self._name, shape, prior=self._prior)


class PatternContender:
    """Local patterns alone, a part of the default model: the mean of those of each person's photographs."""

    def __init__(self) -> None:
        self._templates: list[Template] = []

    @property
    def bytes_per_person(self) -> float:
        """Memory that a person costs."""
        return sum(template.nbytes for template in self._templates) / max(len(self._templates), 1)

    def enroll(self, people: Sequence[Person]) -> None:
        """Enrol the photographs of everybody."""
        self._templates = [Template.of([patterns(photo) for photo in person.photographs]) for person in people]

    def distances(self, photo: Floats) -> NDArray[np.float64]:
        """Return how unlike everybody is: 1 minus the similarity."""
        return 1 - similarity(patterns(photo), self._templates).scores.astype(np.float64)

    def nearest(self, photo: Floats) -> int:
        """Return the index of the most similar person."""
        return int(self.distances(photo).argmin())


def yale_contender(method: str) -> Contender:
    """Return a fresh contender of that name.

    Raises
    ------
    HarmonicFaceError
        There is no method of that name.

    Examples
    --------
    >>> yale_contender("harmonic9").bytes_per_person
    0.0
    """
    if method == "default":
        return GalleryContender(method)
    if method == ONE_PHOTOGRAPH:
        return ExemplarContender()
    if method == "patterns":
        return PatternContender()
    if method == SEARCHING:
        return ShiftedContender(method)
    if method not in YALE_METHODS:
        raise HarmonicFaceError(f"method: expected one of {', '.join(YALE_METHODS)}, got {method!r}")
    return ClassifierContender(PLAIN.get(method, method))


def _most_frontal(person: Person) -> Floats:
    """Return the photograph under the most frontal light; the first where lights are not known."""
    if person.lights is None:
        return np.asarray(person.photographs[0])
    towards = person.lights[:, 2] / np.linalg.norm(person.lights, axis=1)
    return np.asarray(person.photographs[int(towards.argmax())])


def _lights(person: Person) -> Floats:
    """Return the directions of a person's lights."""
    if person.lights is None:
        raise HarmonicFaceError(f"{person.name}: expected directions to the lights, got none")
    return person.lights
