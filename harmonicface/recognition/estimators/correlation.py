"""Correlation: the nearest training photograph, apart from brightness and contrast."""

from __future__ import annotations

import numpy as np

from harmonicface._validate import Floats
from harmonicface.recognition.estimators.base import Codes
from harmonicface.recognition.estimators.nearest import NearestPhotograph, unit_contrast


class Correlation(NearestPhotograph):
    r"""Nearest photograph by normalized correlation (Brunelli & Poggio 1993; Belhumeur et al. 1997).

    .. math:: d = \sqrt{(1 - r) / 2}, \quad r = \frac{(x - \bar x) \cdot (y - \bar y)}{|x - \bar x| |y - \bar y|}

    0 for equal photographs, 0.71 for unrelated ones, 1 for opposite ones. Photographs without contrast correlate with
    nothing. All correlations are one matrix product.

    Examples
    --------
    >>> photographs = np.random.default_rng(0).uniform(0, 1, (6, 64))
    >>> people = ["ada", "ada", "ada", "bob", "bob", "bob"]
    >>> classifier = Correlation().fit(photographs, people)
    >>> str(classifier.predict(0.1 + 0.5 * photographs[3:4])[0])
    'bob'
    >>> classifier.predict_distances(photographs[3:4]).round(2)
    array([[0.63, 0.  ]])
    """

    _least_features = 2

    def _learn(self, pixels: Floats, codes: Codes) -> None:
        self._keep(unit_contrast(pixels), codes)

    def _distances(self, pixels: Floats) -> Floats:
        correlations = unit_contrast(pixels).astype(self.features_.dtype, copy=False) @ self.features_.T
        squared = 0.5 - correlations / 2
        rounding = 16 * np.finfo(squared.dtype).eps
        return self._to_people(np.sqrt(np.where(squared < rounding, 0, squared)))
