"""Harmonic exemplars: people known from one photograph each, under unknown light."""

from __future__ import annotations

import numpy as np

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.people.prior import FacePrior, synthetic_prior
from harmonicface.recognition import exemplar as from_one
from harmonicface.recognition.estimators.base import Codes
from harmonicface.recognition.estimators.image_table import as_images
from harmonicface.recognition.estimators.projection import NearestSubspace, orthonormal


class Exemplar(NearestSubspace):
    """Nearest span of nine harmonic images that one photograph and a prior of faces give (Zhang & Samaras 2006).

    Photographs are compared where everybody has a face. Of several photographs of a person, the one whose light
    explains it best is taken.

    Parameters
    ----------
    image_shape
        (h, w) of the photographs, which are the rows of a table.
    prior
        By default the built-in one, of synthetic people, which takes about 5 seconds to make once.

    Attributes
    ----------
    mask_
        (p,) booleans, the pixels that are compared.

    Examples
    --------
    >>> import harmonicface as hf
    >>> from harmonicface.people.prior import synthetic_prior
    >>> people = [hf.synthetic_person(seed, size=48) for seed in (0, 1)]
    >>> known = [hf.render(person, hf.lights.natural(3)).ravel() for person in people]
    >>> classifier = Exemplar((48, 48), synthetic_prior((48, 42), 20)).fit(known, ["ada", "bob"])
    >>> photo = hf.render(people[1], hf.lights.natural(4))
    >>> str(classifier.predict(photo.reshape(1, -1))[0])
    'bob'
    """

    def __init__(self, image_shape: tuple[int, int] | None = None, prior: FacePrior | None = None) -> None:
        self.image_shape = image_shape
        self.prior = prior

    def _learn(self, pixels: Floats, codes: Codes) -> None:
        images = as_images(pixels, self.image_shape)
        prior = self.prior or synthetic_prior()
        best: list[from_one.Exemplar] = []
        for code in range(len(self.classes_)):
            found = [from_one.exemplar(photo, prior) for photo in images[codes == code]]
            brightness = [float(photo.mean()) for photo in images[codes == code]]
            best.append(min(zip(found, brightness, strict=True), key=lambda pair: pair[0].noise / pair[1])[0])
        self.mask_ = np.all([one.surface.mask.ravel() for one in best], axis=0)
        if not self.mask_.any():
            raise HarmonicFaceError("photographs: expected faces that overlap, got some at different places")
        self._stack([orthonormal(one.images[:, self.mask_]) for one in best])

    def _distances(self, pixels: Floats) -> Floats:
        return super()._distances(pixels[:, self.mask_])
