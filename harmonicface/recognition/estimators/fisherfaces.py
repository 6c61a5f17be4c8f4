"""Fisherfaces: the nearest training photograph after linear discriminant analysis."""

from __future__ import annotations

import numpy as np
from sklearn.decomposition import PCA
from sklearn.discriminant_analysis import LinearDiscriminantAnalysis

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.estimators.base import Codes
from harmonicface.recognition.estimators.nearest import NearestPhotograph


class Fisherfaces(NearestPhotograph):
    """Nearest photograph along the directions that tell people apart best (Belhumeur, Hespanha & Kriegman 1997).

    n photographs of c people are reduced to their n - c largest principal components, in which the scatter within
    people can be inverted, and to at most c - 1 discriminants.

    Raises
    ------
    HarmonicFaceError
        Fewer than two people, or one photograph a person.

    Examples
    --------
    >>> photographs = np.random.default_rng(0).uniform(0, 1, (6, 64))
    >>> people = ["ada", "ada", "ada", "bob", "bob", "bob"]
    >>> [str(name) for name in Fisherfaces().fit(photographs, people).predict(photographs[2:4])]
    ['ada', 'bob']
    """

    _telling_from_few = True

    def _learn(self, pixels: Floats, codes: Codes) -> None:
        people, count = len(self.classes_), len(pixels)
        if people < 2 or people == count:
            expected = "at least two classes, and two photographs of one of them"
            raise HarmonicFaceError(f"photographs: expected {expected}, got n_samples={count} of {people} class(es)")
        exact = pixels.astype(np.float64)  # what scatters little within people counts most
        reduced = PCA(min(count - people, pixels.shape[1]), svd_solver="full").fit(exact)
        small = reduced.transform(exact)
        discriminants = LinearDiscriminantAnalysis().fit(small, codes)
        kept = discriminants.scalings_[:, : min(people - 1, discriminants.scalings_.shape[1])]
        self.projection_ = np.ascontiguousarray((reduced.components_.T @ kept).astype(pixels.dtype))
        self.mean_ = reduced.mean_.astype(pixels.dtype)
        self._keep(self._features(pixels), codes)

    def _features(self, pixels: Floats) -> Floats:
        return np.asarray((pixels - self.mean_) @ self.projection_)
