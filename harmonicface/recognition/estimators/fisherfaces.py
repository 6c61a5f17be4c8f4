"""Fisherfaces: the nearest training photograph after linear discriminant analysis."""

from __future__ import annotations

import numpy as np
from sklearn.decomposition import PCA
from sklearn.discriminant_analysis import LinearDiscriminantAnalysis

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.estimators.base import Codes
from harmonicface.recognition.estimators.nearest import NearestPhotograph, unit_contrast

ROUNDING = 1e-10  # of the largest singular value: components below it are none


class Fisherfaces(NearestPhotograph):
    """Nearest photograph along the directions that tell people apart best (Belhumeur, Hespanha & Kriegman 1997).

    n photographs of c people are reduced to their n - c largest principal components, in which the scatter within
    people can be inverted, and to at most c - 1 discriminants. These are unit vectors, as in
    OpenCV: at equal scatter within people, as in scikit-learn's transform, those that scatter least drown the others.

    Parameters
    ----------
    contrast
        Compare photographs at mean 0 and length 1, as the paper did.

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

    _least_features = 2

    def __init__(self, contrast: bool = True) -> None:
        self.contrast = contrast

    @property
    def _telling_from_few(self) -> bool:
        """Two features without their mean are one."""
        return not self.contrast

    def _learn(self, pixels: Floats, codes: Codes) -> None:
        people, count = len(self.classes_), len(pixels)
        if people < 2 or people == count:
            expected = "at least two classes, and two photographs of one of them"
            raise HarmonicFaceError(f"photographs: expected {expected}, got n_samples={count} of {people} class(es)")
        exact = self._seen(pixels).astype(np.float64)  # what scatters little within people counts most
        reduced = PCA(min(count - people, pixels.shape[1]), svd_solver="full").fit(exact)
        varied = reduced.singular_values_ > ROUNDING * reduced.singular_values_[0]
        components = reduced.components_[varied]
        kept = _discriminants((exact - reduced.mean_) @ components.T, codes)
        kept /= np.linalg.norm(kept, axis=0)
        self.projection_ = np.ascontiguousarray((components.T @ kept).astype(pixels.dtype))
        self.mean_ = reduced.mean_.astype(pixels.dtype)
        self._keep(self._features(pixels), codes)

    def _features(self, pixels: Floats) -> Floats:
        seen = self._seen(pixels).astype(self.projection_.dtype, copy=False)
        return np.asarray((seen - self.mean_) @ self.projection_)

    def _seen(self, pixels: Floats) -> Floats:
        """Return photographs as they are compared."""
        return unit_contrast(pixels) if self.contrast else pixels


def _discriminants(small: Floats, codes: Codes) -> Floats:
    """Return the directions (k, d) that tell people apart best; all where photographs or means do not differ."""
    counts = np.bincount(codes)
    means = np.stack([np.bincount(codes, column) / counts for column in small.T], axis=-1)
    if min(np.abs(small - means[codes]).max(), np.ptp(means, axis=0).max()) <= ROUNDING * np.abs(small).max():
        return np.eye(small.shape[1])
    scalings = LinearDiscriminantAnalysis().fit(small, codes).scalings_
    return np.asarray(scalings[:, : len(counts) - 1])
