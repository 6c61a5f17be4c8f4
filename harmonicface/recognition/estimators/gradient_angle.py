"""Gradient angle: in which direction the brightness rises at each pixel, which light changes little."""

from __future__ import annotations

import cv2
import numpy as np

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.recognition.estimators.base import Codes
from harmonicface.recognition.estimators.image_table import as_images
from harmonicface.recognition.estimators.nearest import NearestPhotograph


class GradientAngle(NearestPhotograph):
    r"""Nearest photograph by the directions of its gradients (Chen, Belhumeur & Jacobs, CVPR 2000).

    .. math:: d = \sqrt{\tfrac12 \left(1 - \tfrac1p \sum_x \cos(\theta(x) - \theta'(x))\right)}

    The angle of the gradient keeps its place where light changes its length; the paper's joint density of two gradients
    is largest where the angles agree. Where a photograph has no gradient, no angle agrees.

    Parameters
    ----------
    image_shape
        (h, w) of the photographs, which are the rows of a table.
    scale
        Standard deviation, in pixels, of the Gaussian before the derivatives.

    Examples
    --------
    >>> photographs = np.random.default_rng(0).uniform(0, 1, (2, 64))
    >>> classifier = GradientAngle((8, 8)).fit(photographs, ["ada", "bob"])
    >>> str(classifier.predict(photographs[1:] ** 0.5)[0])
    'bob'
    """

    def __init__(self, image_shape: tuple[int, int] | None = None, scale: float = 1.0) -> None:
        self.image_shape = image_shape
        self.scale = scale

    def _learn(self, pixels: Floats, codes: Codes) -> None:
        self._keep(self._features(pixels), codes)

    def _features(self, pixels: Floats) -> Floats:
        """Return cosine and sine of the angle at each pixel, (n, 2 h w), over the square root of their number."""
        scale = _validate.positive(self.scale, "scale")
        images = as_images(pixels, self.image_shape)
        features = np.empty((len(images), 2, *images.shape[1:]), np.float32)
        for image, (right, down) in zip(images, features, strict=True):
            smooth = cv2.GaussianBlur(np.ascontiguousarray(image), (0, 0), scale, borderType=cv2.BORDER_REFLECT)
            right[:], down[:] = _rises(smooth, 1), _rises(smooth, 0)
            length = np.hypot(right, down)
            length[length == 0] = 1
            right /= length
            down /= length
        return features.reshape(len(images), -1) / np.float32(np.sqrt(pixels.shape[1]))

    def _distances(self, pixels: Floats) -> Floats:
        agreement = self._features(pixels) @ self.features_.T
        return self._to_people(np.sqrt(np.clip(0.5 - agreement / 2, 0, 1)))


def _rises(image: Floats, axis: int) -> Floats:
    """Return the derivative by central differences, one-sided at the border."""
    return np.asarray(np.gradient(image, axis=axis)) if image.shape[axis] > 1 else np.zeros_like(image)
