"""Tan & Triggs: photographs freed of most of the light, then compared by local patterns or by correlation."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.estimators.base import Codes, FaceClassifier
from harmonicface.recognition.estimators.correlation import Correlation
from harmonicface.recognition.estimators.image_table import as_images
from harmonicface.recognition.estimators.local_patterns import LocalBinaryPatterns

GAMMA, INNER, OUTER, ALPHA, LARGEST = 0.2, 1.0, 2.0, 0.1, 10.0  # the paper's


class TanTriggs(FaceClassifier):
    """Nearest photograph after the preprocessing of Tan & Triggs (2010; see `without_light`).

    Parameters
    ----------
    image_shape
        (h, w) of the photographs, which are the rows of a table: intensities of at least 0.
    compare
        "patterns" (histograms of local binary patterns) or "correlation".

    Raises
    ------
    HarmonicFaceError
        Another comparison, negative intensities.

    Examples
    --------
    >>> photographs = np.random.default_rng(0).uniform(0, 1, (6, 1024))
    >>> people = ["ada", "ada", "ada", "bob", "bob", "bob"]
    >>> str(TanTriggs((32, 32)).fit(photographs, people).predict(photographs[5:] / 5)[0])
    'bob'
    """

    def __init__(self, image_shape: tuple[int, int] | None = None, compare: str = "patterns") -> None:
        self.image_shape = image_shape
        self.compare = compare

    def _learn(self, pixels: Floats, codes: Codes) -> None:
        if self.compare not in ("patterns", "correlation"):
            raise HarmonicFaceError(f'compare: expected "patterns" or "correlation", got {self.compare!r}')
        method = LocalBinaryPatterns(self.image_shape) if self.compare == "patterns" else Correlation()
        self.comparison_ = method.fit(self._prepared(pixels), self.classes_[codes])

    def _distances(self, pixels: Floats) -> Floats:
        return self.comparison_.predict_distances(self._prepared(pixels))

    def _prepared(self, pixels: Floats) -> Floats:
        """Return photographs without most of the light, from 0 to 1."""
        images = [without_light(image) for image in as_images(pixels, self.image_shape)]
        return np.stack(images).reshape(len(pixels), -1) / np.float32(2 * LARGEST) + np.float32(0.5)


def without_light(photo: ArrayLike) -> NDArray[np.float32]:
    r"""Return a photograph without most of what light did to it (Tan & Triggs, TIP 2010, section 2).

    A gamma curve of 0.2, the difference of Gaussians of 1 and 2 pixels, and equal contrast:

    .. math:: I \leftarrow \frac{I}{(\mathrm{mean} |I|^a)^{1/a}}, \quad
              I \leftarrow \frac{I}{(\mathrm{mean} \min(\tau, |I|)^a)^{1/a}}, \quad I \leftarrow \tau \tanh(I / \tau)

    with a = 0.1 and tau = 10.

    Parameters
    ----------
    photo
        (h, w) linear intensities of at least 0.

    Returns
    -------
    array
        (h, w) float32 from -10 to 10; 0 where the photograph is the same everywhere.

    Raises
    ------
    HarmonicFaceError
        Another shape, NaN, negative intensities.

    Examples
    --------
    >>> photo = np.random.default_rng(0).uniform(0, 1, (16, 16))
    >>> bool(np.allclose(without_light(photo), without_light(photo / 4), atol=1e-4))
    True
    """
    image = _validate.image(photo, "photo")
    if image.ndim != 2 or image.min() < 0:
        raise HarmonicFaceError(f"photo: expected (h, w) of at least 0, got {image.shape} from {image.min():.4g}")
    curved = np.ascontiguousarray(image**GAMMA, np.float32)
    narrow, wide = (cv2.GaussianBlur(curved, (0, 0), scale, borderType=cv2.BORDER_REFLECT) for scale in (INNER, OUTER))
    detail = narrow - wide
    strength = float(np.mean(np.abs(detail) ** ALPHA) ** (1 / ALPHA))
    if strength <= np.finfo(np.float32).tiny:
        return np.zeros_like(detail)
    detail /= strength
    detail /= float(np.mean(np.minimum(LARGEST, np.abs(detail)) ** ALPHA) ** (1 / ALPHA))
    return np.asarray(LARGEST * np.tanh(detail / LARGEST), np.float32)
