"""Nearest photograph: each person is as far as the nearest of her photographs, as features."""

from __future__ import annotations

import numpy as np
from scipy.spatial.distance import cdist

from harmonicface._validate import Floats
from harmonicface.recognition.estimators.base import Codes, FaceClassifier


class NearestPhotograph(FaceClassifier):
    """A method that compares features of photographs by their Euclidean distance.

    A subclass learns the features in `_learn`, which ends with `_keep`, and computes those of a query in `_features`.
    """

    def _features(self, pixels: Floats) -> Floats:
        """Return the features (n, k) of checked photographs (n, p)."""
        raise NotImplementedError

    def _keep(self, features: Floats, codes: Codes) -> None:
        """Keep the features of all training photographs, person by person."""
        order = np.argsort(codes, kind="stable")
        self.features_ = np.ascontiguousarray(features[order])
        self.starts_ = np.searchsorted(codes[order], np.arange(len(self.classes_)))

    def _distances(self, pixels: Floats) -> Floats:
        return self._to_people(cdist(self._features(pixels), self.features_))

    def _to_people(self, distances: Floats) -> Floats:
        """Return the smallest of the distances to the photographs (n, m) of each person, (n, c)."""
        return np.asarray(np.minimum.reduceat(distances, self.starts_, axis=1))


def unit_contrast(pixels: Floats) -> Floats:
    """Return photographs (n, p) at mean 0 and length 1, apart from brightness and contrast; 0 where there is none.

    Examples
    --------
    >>> unit_contrast(np.array([[1.0, 3.0, 2.0], [5.0, 5.0, 5.0]])).round(4)
    array([[-0.7071,  0.7071,  0.    ],
           [ 0.    ,  0.    ,  0.    ]])
    """
    lowest, highest = pixels.min(axis=1, keepdims=True), pixels.max(axis=1, keepdims=True)
    contrast = highest / 2 - lowest / 2  # halves, so that the largest numbers have a difference
    flat = contrast == 0
    scaled = (pixels / 2 - lowest / 2) / np.where(flat, 1, contrast)  # faint contrast keeps its digits
    scaled -= scaled.mean(axis=1, keepdims=True, dtype=np.float64).astype(pixels.dtype)
    lengths = np.linalg.norm(scaled, axis=1, keepdims=True)
    return np.asarray(np.where(flat, 0, scaled / np.where(flat, 1, lengths)), pixels.dtype)
