"""Nine points of light: a person as the span of nine pictures of her, each under one lamp."""

from __future__ import annotations

from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import linear_sum_assignment

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.estimators.base import Codes
from harmonicface.recognition.estimators.from_surfaces import SurfaceSubspace
from harmonicface.recognition.estimators.projection import NearestSubspace, orthonormal
from harmonicface.recognition.nine_lights import nine_lights, nine_points
from harmonicface.surfaces.surface import Surface


class NinePointsReal(NearestSubspace):
    """Nearest span of a person's photographs under nine lamps (Lee, Ho & Kriegman 2005).

    With the lights of the photographs, those nearest to the nine published directions are taken, all different, so
    that the angles add up to least; without, all photographs are.

    Examples
    --------
    >>> ada, bob = np.random.default_rng(0).normal(size=(2, 9, 64))
    >>> classifier = NinePointsReal().fit(np.concatenate([ada, bob]), ["ada"] * 9 + ["bob"] * 9)
    >>> str(classifier.predict(bob[:1] - 2 * bob[1:2])[0])
    'bob'
    """

    def fit(self, X: ArrayLike, y: ArrayLike, lights: ArrayLike | None = None) -> Self:
        """Learn people from photographs.

        Parameters
        ----------
        X
            (n, p), one photograph a row.
        y
            (n,) who is in each.
        lights
            (n, 3) directions to the light of each; then each person needs at least nine photographs. In a pipeline
            or a search they are routed here after `set_fit_request(lights=True)`.

        Raises
        ------
        HarmonicFaceError
            Tables of other shapes, NaN, lights that are no directions, fewer than nine photographs to choose from.
        """
        pixels, codes = self._training(X, y)
        if lights is not None:
            chosen = self._chosen(_validate.directions(lights, "lights"), codes)
            pixels, codes = pixels[chosen], codes[chosen]
        self._learn(pixels, codes)
        return self

    def _learn(self, pixels: Floats, codes: Codes) -> None:
        self._stack([orthonormal(pixels[codes == code]) for code in range(len(self.classes_))])

    def _chosen(self, towards: Floats, codes: Codes) -> NDArray[np.intp]:
        """Return which photographs are nearest to the nine lamps."""
        if towards.shape != (len(codes), 3):
            raise HarmonicFaceError(f"lights: expected shape ({len(codes)}, 3), got {towards.shape}")
        own = [np.flatnonzero(codes == code) for code in range(len(self.classes_))]
        for name, photographs in zip(self.classes_, own, strict=True):
            if len(photographs) < len(nine_lights()):
                raise HarmonicFaceError(f"photographs: expected at least nine of {name}, got {len(photographs)}")
        return np.concatenate([photographs[nearest_to_nine(towards[photographs])] for photographs in own])


class NinePointsSimulated(SurfaceSubspace):
    """Nearest span of a Surface's pictures under nine lamps, attached shadows only (Lee, Ho & Kriegman 2005).

    Examples
    --------
    >>> import harmonicface as hf
    >>> people = {name: hf.synthetic_person(seed, size=32) for name, seed in (("ada", 0), ("bob", 1))}
    >>> classifier = NinePointsSimulated.from_surfaces(list(people), list(people.values()))
    >>> photo = hf.render(people["bob"], hf.lights.directional([1.0, 1.0, 1.0]))
    >>> str(classifier.predict(photo.reshape(1, -1))[0])
    'bob'
    """

    def _pictures(self, surface: Surface) -> Floats:
        return nine_points(surface)


def nearest_to_nine(lights: Floats) -> NDArray[np.intp]:
    """Return which of at least nine unit directions (n, 3) are nearest to the nine lamps, (9,), all different.

    Examples
    --------
    >>> nearest_to_nine(nine_lights()[::-1])
    array([8, 7, 6, 5, 4, 3, 2, 1, 0])
    """
    angles = np.arccos(np.clip(nine_lights() @ lights.T, -1, 1))
    return np.asarray(linear_sum_assignment(angles)[1], np.intp)
