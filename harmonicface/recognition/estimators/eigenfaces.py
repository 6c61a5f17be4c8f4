"""Eigenfaces: the nearest training photograph in the span of the principal components."""

from __future__ import annotations

import numpy as np
from sklearn.decomposition import PCA

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.estimators.base import Codes
from harmonicface.recognition.estimators.nearest import NearestPhotograph, unit_contrast


class Eigenfaces(NearestPhotograph):
    """Nearest photograph by its principal components (Turk & Pentland 1991).

    Parameters
    ----------
    drop_first
        Leave out so many of the largest components, which hold the light more than the face; Belhumeur, Hespanha &
        Kriegman (1997) leave out three.
    n_components
        How many components to compute, at most one less than photographs; all of them by default.
    contrast
        Compare photographs at mean 0 and length 1, as Georghiades, Belhumeur & Kriegman (2001) did.

    Raises
    ------
    HarmonicFaceError
        Parameters out of range, too few photographs for the components.

    Examples
    --------
    >>> photographs = np.random.default_rng(0).uniform(0, 1, (6, 64))
    >>> people = ["ada", "ada", "ada", "bob", "bob", "bob"]
    >>> [str(name) for name in Eigenfaces(drop_first=1).fit(photographs, people).predict(photographs[2:4])]
    ['ada', 'bob']
    """

    _least_features = 2

    def __init__(self, drop_first: int = 0, n_components: int | None = None, contrast: bool = True) -> None:
        self.drop_first = drop_first
        self.n_components = n_components
        self.contrast = contrast

    def _learn(self, pixels: Floats, codes: Codes) -> None:
        dropped = _validate.at_least(self.drop_first, 0, "drop_first")
        most = min(len(pixels) - 1, pixels.shape[1])  # the last of n components is made of rounding errors
        wanted = most if self.n_components is None else _validate.at_least(self.n_components, 1, "n_components")
        if not dropped < min(wanted, most):
            count, size = pixels.shape
            expected = f"enough photographs for {dropped + 1} principal components"
            raise HarmonicFaceError(f"photographs: expected {expected}, got n_samples={count}, n_features={size}")
        seen = self._seen(pixels)
        components = PCA(min(wanted, most), svd_solver="full").fit(seen)
        self.mean_, self.components_ = components.mean_, components.components_[dropped:]
        self._keep(self._features(pixels), codes)

    def _features(self, pixels: Floats) -> Floats:
        seen = self._seen(pixels).astype(self.components_.dtype, copy=False)
        return np.asarray((seen - self.mean_) @ self.components_.T)

    def _seen(self, pixels: Floats) -> Floats:
        """Return photographs as they are compared."""
        return unit_contrast(pixels) if self.contrast else pixels
