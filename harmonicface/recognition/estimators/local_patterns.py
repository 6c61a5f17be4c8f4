"""Histograms of local binary patterns, by OpenCV."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.estimators.base import Codes, FaceClassifier
from harmonicface.recognition.estimators.image_table import as_images
from harmonicface.recognition.opencv import eight_bits

LEAST = 10  # pixels a side: one a cell, and the border that patterns of radius 1 lose


class LocalBinaryPatterns(FaceClassifier):
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
        images = self._images(pixels)
        if min(images.shape[1:]) < LEAST:
            expected = f"at least {LEAST} x {LEAST} pixels for 8 x 8 cells"
            raise HarmonicFaceError(f"image_shape: expected {expected}, got {images.shape[1:]}")
        self._model = cv2.face.LBPHFaceRecognizer.create()
        self._model.train(list(images), codes.astype(np.int32))

    def _distances(self, pixels: Floats) -> Floats:
        return np.array([self._to_people(image) for image in self._images(pixels)])

    def _to_people(self, image: Any) -> Floats:
        """Return the distance to the nearest photograph of each person, (c,)."""
        collector = cv2.face.StandardCollector.create()
        self._model.predict_collect(image, collector)
        distances = np.full(len(self.classes_), np.inf)
        for code, distance in collector.getResults():
            distances[code] = min(distances[code], distance)
        return distances

    def _images(self, pixels: Floats) -> Any:
        """Return the photographs as OpenCV takes them."""
        return eight_bits(as_images(pixels, self.image_shape).astype(np.float32), "photographs")
