"""A person as the span of her photographs, whatever they show."""

from __future__ import annotations

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.recognition.estimators.base import Codes
from harmonicface.recognition.estimators.projection import NearestSubspace, orthonormal


class PhotographSubspace(NearestSubspace):
    """Nearest span of the largest principal directions of a person's photographs, about 0 and not about their mean.

    Three suffice where there is no shadow (Shashua 1997), nine for all distant light on a convex matte surface (Basri
    & Jacobs 2003).

    Parameters
    ----------
    n_components
        Dimensions of a person's subspace at most; as many as her photographs have, if fewer.

    Examples
    --------
    >>> import numpy as np
    >>> lights, ada, bob = np.random.default_rng(0).normal(size=(3, 8, 64))
    >>> photographs = np.concatenate([lights[:, :3] @ ada[:3], lights[:, 3:6] @ bob[:3]])
    >>> classifier = PhotographSubspace(3).fit(photographs, ["ada"] * 8 + ["bob"] * 8)
    >>> str(classifier.predict(ada[:1] - 2 * ada[1:2])[0])
    'ada'
    """

    def __init__(self, n_components: int = 9) -> None:
        self.n_components = n_components

    def _learn(self, pixels: Floats, codes: Codes) -> None:
        most = _validate.at_least(self.n_components, 1, "n_components")
        self._stack([orthonormal(pixels[codes == code], most) for code in range(len(self.classes_))])
