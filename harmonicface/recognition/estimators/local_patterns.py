"""Histograms of local binary patterns, by OpenCV."""

from __future__ import annotations

import cv2
import numpy as np
from sklearn.metrics.pairwise import additive_chi2_kernel

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.estimators.base import Codes
from harmonicface.recognition.estimators.image_table import as_images
from harmonicface.recognition.estimators.nearest import NearestPhotograph
from harmonicface.recognition.opencv import eight_bits

LEAST = 10  # pixels a side: one a cell, and the border that patterns of radius 1 lose


class LocalBinaryPatterns(NearestPhotograph):
    """Nearest photograph by histograms of local binary patterns (Ahonen, Hadid & Pietikainen 2006), by `cv2.face`.

    Radius 1, 8 neighbours, 8 x 8 cells, the defaults of OpenCV; its distance is chi-square, summed over the cells.

    Parameters
    ----------
    image_shape
        (h, w) of the photographs, which are the rows of a table: intensities of 0 to 1, rounded to 8 bits.

    Raises
    ------
    HarmonicFaceError
        Fewer than 10 x 10 pixels, intensities outside 0 to 1.

    Examples
    --------
    >>> photographs = np.random.default_rng(0).uniform(0, 1, (6, 1024))
    >>> people = ["ada", "ada", "ada", "bob", "bob", "bob"]
    >>> str(LocalBinaryPatterns((32, 32)).fit(photographs, people).predict(photographs[5:])[0])
    'bob'
    """

    def __init__(self, image_shape: tuple[int, int] | None = None) -> None:
        self.image_shape = image_shape

    def _learn(self, pixels: Floats, codes: Codes) -> None:
        self._keep(self._features(pixels), codes)

    def _features(self, pixels: Floats) -> Floats:
        """Return the histograms of all cells, (n, 16384), as OpenCV keeps those of photographs that it learns."""
        images = eight_bits(as_images(pixels, self.image_shape).astype(np.float32, copy=False), "photographs")
        if min(images.shape[1:]) < LEAST:
            expected = f"at least {LEAST} x {LEAST} pixels for 8 x 8 cells"
            raise HarmonicFaceError(f"image_shape: expected {expected}, got {images.shape[1:]}")
        model = cv2.face.LBPHFaceRecognizer.create()
        model.train(list(images), np.zeros(len(images), np.int32))
        return np.concatenate(model.getHistograms())

    def _distances(self, pixels: Floats) -> Floats:
        # the kernel is minus half of OpenCV's distance
        return self._to_people(-2 * additive_chi2_kernel(self._features(pixels), self.features_))
