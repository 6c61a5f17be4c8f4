"""Methods that know a person's shape: they take Surfaces, or photographs under known lights, which give Surfaces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.estimators.base import Codes, FaceClassifier
from harmonicface.recognition.estimators.image_table import as_images
from harmonicface.recognition.estimators.projection import NearestSubspace, orthonormal
from harmonicface.stereo.known.calibrated import calibrated_stereo
from harmonicface.stereo.reconstruction import reconstruct
from harmonicface.stereo.registration import register
from harmonicface.surfaces.surface import Surface


class SurfaceClassifier(FaceClassifier):
    """A method that makes a person's pictures from her Surface; a subclass compares with them.

    Parameters
    ----------
    image_shape
        (h, w) of the photographs, which are the rows of a table; needed to learn from photographs.
    registration
        Register a person's training photographs to each other before photometric stereo (`register`): people move.
    """

    _needs_depth = False

    def __init__(self, image_shape: tuple[int, int] | None = None, registration: bool = False) -> None:
        self.image_shape = image_shape
        self.registration = registration

    def fit(self, X: ArrayLike, y: ArrayLike, lights: ArrayLike | None = None) -> Self:
        """Learn people from photographs under known lights, by photometric stereo.

        Parameters
        ----------
        X
            (n, h * w) linear grey intensities, 0 to 1, at least three a person.
        y
            (n,) who is in each.
        lights
            (n, 3) directions to the light of each (x right, y up, z toward the camera), times its brightness. In a
            pipeline or a search they are routed here after `set_fit_request(lights=True)`.

        Raises
        ------
        HarmonicFaceError
            Tables of other shapes, NaN, no `image_shape` or no `lights`, what photometric stereo refuses.
        """
        pixels, codes = self._training(X, y)
        if lights is None:
            self._learn(pixels, codes)
            return self
        images = as_images(pixels, self.image_shape)
        towards = _validate.vectors(lights, "lights")
        if towards.shape != (len(images), 3):
            raise HarmonicFaceError(f"lights: expected shape ({len(images)}, 3), got {towards.shape}")
        people = range(len(self.classes_))
        self._enroll([self._surface(images[codes == code], towards[codes == code]) for code in people])
        return self

    @classmethod
    def from_surfaces(cls, names: Sequence[str], surfaces: Sequence[Surface], **parameters: Any) -> Self:
        """Return a classifier that has learned people from their Surfaces.

        Parameters
        ----------
        names
            A different one for each person.
        surfaces
            As many, all of one shape.
        parameters
            Those of the class, but for `image_shape`, which the Surfaces tell.

        Raises
        ------
        HarmonicFaceError
            Nobody, names that repeat, another number of Surfaces, Surfaces of different shapes.
        """
        if len(names) == 0 or len(set(names)) != len(names) or len(names) != len(surfaces):
            expected = "one name for each of at least one Surface, all different"
            raise HarmonicFaceError(f"names: expected {expected}, got {len(names)} for {len(surfaces)}")
        shapes = {surface.shape for surface in surfaces}
        if len(shapes) > 1:
            raise HarmonicFaceError(f"surfaces: expected one shape, got {sorted(shapes)}")
        height, width = shapes.pop()
        classifier = cls(image_shape=(height, width), **parameters)
        classifier.classes_, order = np.unique(np.asarray(names), return_index=True)
        classifier.n_features_in_ = height * width
        classifier._enroll([surfaces[index] for index in order])
        return classifier

    def _learn(self, pixels: Floats, codes: Codes) -> None:
        """Refuse photographs without lights."""
        raise HarmonicFaceError("lights: expected directions to the light of each photograph, got none")

    def _enroll(self, surfaces: Sequence[Surface]) -> None:
        """Learn from everybody's Surface."""
        raise NotImplementedError

    def _pictures(self, surface: Surface) -> Floats:
        """Return the pictures that make hers up, (k, p) over the masked pixels."""
        raise NotImplementedError

    def _placed(self, surface: Surface) -> Floats:
        """Return her pictures at all pixels, (k, h * w), 0 outside her mask."""
        pictures = self._pictures(surface)
        placed = np.zeros((len(pictures), surface.mask.size), np.float32)
        placed[:, surface.mask.ravel()] = pictures
        return placed

    def _surface(self, images: Floats, lights: Floats) -> Surface:
        """Return the Surface that a person's photographs give."""
        if self._needs_depth:
            return reconstruct(images, lights, registered=not self.registration)
        still = register(images).photographs if self.registration else images
        return calibrated_stereo(still, lights).surface


class SurfaceSubspace(SurfaceClassifier, NearestSubspace):
    """Nearest span of pictures that are made from Surfaces."""

    def _enroll(self, surfaces: Sequence[Surface]) -> None:
        self._stack([orthonormal(self._placed(surface)) for surface in surfaces])
