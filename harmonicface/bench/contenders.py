"""The methods that are compared, each enrolled and asked in the same way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.disk.storage import DEFAULT_MODEL
from harmonicface.gallery.gallery import Gallery
from harmonicface.recognition.baselines import BASELINES, Baseline, baseline
from harmonicface.recognition.displaced import ShiftSearch
from harmonicface.recognition.models import SUBSPACE_MODELS, subspace_model
from harmonicface.surfaces.surface import Surface

SHADOWED = ("harmonic_shadowed", "harmonic_shadowed_fixed")  # they need depth, and photographs with cast shadows
NOT_HERE = (*SHADOWED, "nine_points_simulated")  # the last is no better than the nine images, from which it is made
METHODS = (*BASELINES, *(model for model in SUBSPACE_MODELS if model not in NOT_HERE), DEFAULT_MODEL)
EVERY_METHOD = (*METHODS, *SHADOWED)


@dataclass(frozen=True, eq=False)
class Person:
    """Somebody to enrol: photographs for the methods that learn from pictures, a Surface for the others.

    Parameters
    ----------
    name
        A different one for everybody.
    photographs
        (n, h, w) linear intensities, 0 to 1.
    known
        Her Surface, as photometric stereo finds it in them; None where it finds none.
    lights
        (n, 3) directions to the light of each photograph, where they are known.
    refusal
        Why there is no Surface.
    """

    name: str
    photographs: Floats
    known: Surface | None
    lights: Floats | None = None
    refusal: str = "expected photographs that give a Surface"

    @property
    def surface(self) -> Surface:
        """Her Surface.

        Raises
        ------
        HarmonicFaceError
            There is none.
        """
        if self.known is None:
            raise HarmonicFaceError(f"{self.name}: {self.refusal}")
        return self.known


class Contender(Protocol):
    """A method under comparison."""

    @property
    def bytes_per_person(self) -> float:
        """Memory that a person costs."""

    def enroll(self, people: Sequence[Person]) -> None:
        """Take people in, all at once."""

    def nearest(self, photo: Floats) -> int:
        """Return the index of the nearest person."""


class GalleryContender:
    """A model behind the public `Gallery`: timed as a user would call it."""

    def __init__(self, model: str) -> None:
        self.gallery = Gallery(model=model)
        self._index: dict[str, int] = {}

    @property
    def bytes_per_person(self) -> float:
        """Memory that a person costs."""
        return self.gallery.bytes_per_person

    def enroll(self, people: Sequence[Person]) -> None:
        """Enrol everybody: the default model by photographs with their lights, if there are any, others by Surface."""
        for index, person in enumerate(people):
            self._enroll(person)
            self._index[person.name] = index

    def distances(self, photo: Floats) -> NDArray[np.float64]:
        """Return how far everybody is, in the order of enrolment: minus the scores."""
        return -self.gallery.search_scores(photo).scores

    def nearest(self, photo: Floats) -> int:
        """Return the index of the first candidate."""
        return self._index[self.gallery.match(photo).candidates[0].name]

    def _enroll(self, person: Person) -> None:
        """Enrol one person by what the model can use."""
        if self.gallery.model != DEFAULT_MODEL or (person.known is not None and person.lights is None):
            self.gallery.enroll(person.name, person.surface)
        else:
            self._enroll_photographs(person)

    def _enroll_photographs(self, person: Person) -> None:
        """Enrol photographs with their lights, or without where they are too different to be registered."""
        if person.known is not None:
            try:
                self.gallery.enroll(person.name, person.photographs, person.lights)
            except HarmonicFaceError:
                pass
            else:
                return
        self.gallery.enroll(person.name, person.photographs)


class ShiftedContender:
    """A subspace model in a photograph that may be shifted a little: plain projection at the best shift."""

    def __init__(self, model: str) -> None:
        self.search = ShiftSearch()
        self.model = model

    @property
    def bytes_per_person(self) -> float:
        """Memory that a person costs."""
        return self.search.bytes_per_person

    def enroll(self, people: Sequence[Person]) -> None:
        """Enrol the Surface of everybody."""
        pictures_of = subspace_model(self.model)
        for person in people:
            surface = person.surface
            images = pictures_of(surface)
            pictures = np.zeros((len(images), *surface.shape), images.dtype)
            pictures[:, surface.mask] = images
            self.search.enroll(pictures)

    def nearest(self, photo: Floats) -> int:
        """Return the index of the person with the best score."""
        return int(self.search.match(photo).scores.argmin())


class PhotographContender:
    """A method that learns from photographs alone."""

    def __init__(self, baseline: Baseline) -> None:
        self.baseline = baseline

    @property
    def bytes_per_person(self) -> float:
        """Memory that a person costs."""
        return self.baseline.bytes_per_person

    def enroll(self, people: Sequence[Person]) -> None:
        """Enrol the photographs of everybody."""
        self.baseline.enroll([person.photographs for person in people])

    def nearest(self, photo: Floats) -> int:
        """Return the index of the nearest person."""
        return self.baseline.nearest(photo)


def contender(method: str) -> Contender:
    """Return a fresh contender of that name.

    Raises
    ------
    HarmonicFaceError
        There is no method of that name.
    """
    if method == "harmonic_shadowed":
        return ShiftedContender(method)
    if method == "harmonic_shadowed_fixed":
        return GalleryContender("harmonic_shadowed")
    if method == DEFAULT_MODEL or method in SUBSPACE_MODELS:
        return GalleryContender(method)
    if method in BASELINES:
        return PhotographContender(baseline(method))
    raise HarmonicFaceError(f"method: expected one of {', '.join(EVERY_METHOD)}, got {method!r}")
