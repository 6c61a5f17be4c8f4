"""OpenCV's own face recognizers behind the interface of the baselines: Eigenfaces, Fisherfaces, LBPH."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.photographs import Photographs, one_photo, stacked

Image8 = NDArray[np.uint8]
Predict = Callable[[Image8], int]


class _OpenCVRecognizer:
    """A recognizer of `cv2.face` with its default parameters, asked by its own `predict`."""

    def __init__(self) -> None:
        self._predict: Predict | None = None
        self._shape: tuple[int, int] | None = None
        self._bytes = 0

    def enroll(self, photographs: Sequence[ArrayLike]) -> None:
        """Learn all people at once; the person of `photographs[i]` is i.

        Parameters
        ----------
        photographs
            For each person, (n_i, h, w) linear grey intensities, 0 to 1. OpenCV gets them rounded to 8 bits.

        Raises
        ------
        HarmonicFaceError
            Nobody, unequal shapes, NaN, intensities outside 0..1, too few photographs for the method.
        """
        given = stacked(photographs)
        images = eight_bits(given.images, "photographs")
        model = self._create(given)
        model.train(list(images), given.people)
        self._predict, kept = self._use(model)
        self._bytes = sum(array.nbytes for array in kept) // given.count
        self._shape = images.shape[1], images.shape[2]

    def nearest(self, photo: ArrayLike) -> int:
        """Return the person that the recognizer predicts for a photo of shape (h, w), 0 to 1.

        Raises
        ------
        HarmonicFaceError
            Nobody is enrolled, another shape, NaN, intensities outside 0..1.
        """
        query = eight_bits(one_photo(photo, self._shape), "photo")
        assert self._predict is not None
        return self._predict(query)

    @property
    def bytes_per_person(self) -> int:
        """Bytes of the model's arrays, over the number of people."""
        return self._bytes

    def _create(self, given: Photographs) -> Any:
        """Return the recognizer, untrained, or refuse what it cannot learn from."""
        raise NotImplementedError

    def _use(self, model: Any) -> tuple[Predict, list[NDArray[Any]]]:
        """Return how to ask a trained model, and the arrays that it keeps."""
        kept = [model.getEigenVectors(), model.getMean(), *model.getProjections()]
        return (lambda photo: int(model.predict(photo)[0])), kept


class Eigenfaces(_OpenCVRecognizer):
    """Nearest photograph in the span of the principal components of all (Turk & Pentland 1991), by `cv2.face`.

    All n - 1 components that n photographs have are kept. (OpenCV would keep n by default; the last one is made of
    rounding errors and brings back what `drop_first` leaves out.)

    Parameters
    ----------
    drop_first
        Leave out so many of the largest components, which hold the light more than the face; Belhumeur, Hespanha &
        Kriegman (1997) leave out three. OpenCV has no such option: its own components and projections are used, and
        the nearest projection is found here.

    Raises
    ------
    HarmonicFaceError
        A negative `drop_first`.

    Examples
    --------
    >>> ada, bob = np.random.default_rng(0).uniform(0, 1, (2, 3, 8, 8))
    >>> eigenfaces = Eigenfaces(drop_first=1)
    >>> eigenfaces.enroll([ada, bob])
    >>> eigenfaces.nearest(bob[2])
    1
    """

    def __init__(self, drop_first: int = 0) -> None:
        super().__init__()
        if isinstance(drop_first, bool) or not isinstance(drop_first, int) or drop_first < 0:
            raise HarmonicFaceError(f"drop_first: expected an integer of at least 0, got {drop_first!r}")
        self._drop_first = drop_first

    def _create(self, given: Photographs) -> Any:
        count, height, width = given.images.shape
        components = min(count - 1, height * width)
        if components <= self._drop_first:
            expected = f"enough for {self._drop_first + 1} principal components"
            raise HarmonicFaceError(f"photographs: expected {expected}, got {count} of shape {(height, width)}")
        return cv2.face.EigenFaceRecognizer.create(components)

    def _use(self, model: Any) -> tuple[Predict, list[NDArray[Any]]]:
        if not self._drop_first:
            return super()._use(model)
        mean, people = model.getMean()[0], model.getLabels().ravel()
        components = np.ascontiguousarray(model.getEigenVectors()[:, self._drop_first :].T)
        projections = np.concatenate(model.getProjections())[:, self._drop_first :].copy()

        def predict(photo: Image8) -> int:
            difference = projections - components @ (photo.ravel() - mean)
            return int(people[np.einsum("nk,nk->n", difference, difference).argmin()])

        return predict, [mean, components, projections]


class Fisherfaces(_OpenCVRecognizer):
    """Nearest photograph after linear discriminant analysis (Belhumeur, Hespanha & Kriegman 1997), by `cv2.face`.

    All discriminants are kept, one less than people, the default of OpenCV.

    Examples
    --------
    >>> ada, bob = np.random.default_rng(0).uniform(0, 1, (2, 3, 8, 8))
    >>> fisherfaces = Fisherfaces()
    >>> fisherfaces.enroll([ada, bob])
    >>> fisherfaces.nearest(bob[2])
    1
    """

    def _create(self, given: Photographs) -> Any:
        if given.count < 2 or len(given.images) == given.count:
            expected = "at least two people, and two photographs of one of them"
            got = f"{len(given.images)} photographs of {given.count} people"
            raise HarmonicFaceError(f"photographs: expected {expected}, got {got}")
        return cv2.face.FisherFaceRecognizer.create()


class LocalBinaryPatterns(_OpenCVRecognizer):
    """Nearest photograph by histograms of local binary patterns (Ahonen, Hadid & Pietikainen 2006), by `cv2.face`.

    Radius 1, 8 neighbours, 8 x 8 cells, the defaults of OpenCV.

    Examples
    --------
    >>> ada, bob = np.random.default_rng(0).uniform(0, 1, (2, 3, 32, 32))
    >>> patterns = LocalBinaryPatterns()
    >>> patterns.enroll([ada, bob])
    >>> patterns.nearest(bob[2])
    1
    """

    def _create(self, given: Photographs) -> Any:
        least = 10  # one pixel a cell, and the border that patterns of radius 1 lose
        if min(given.images.shape[1:]) < least:
            raise HarmonicFaceError(
                f"photographs: expected at least {least} x {least} pixels for 8 x 8 cells, got {given.images.shape[1:]}"
            )
        return cv2.face.LBPHFaceRecognizer.create()

    def _use(self, model: Any) -> tuple[Predict, list[NDArray[Any]]]:
        return (lambda photo: int(model.predict(photo)[0])), list(model.getHistograms())


def eight_bits(images: NDArray[np.float32], name: str) -> NDArray[np.uint8]:
    """Return intensities of 0 to 1 rounded to 8 bits, the images that OpenCV's recognizers were made for.

    Raises
    ------
    HarmonicFaceError
        Intensities outside 0..1: clipping them would change the photograph.

    Examples
    --------
    >>> eight_bits(np.array([0, 0.5, 1], np.float32), "photo")
    array([  0, 128, 255], dtype=uint8)
    """
    lowest, highest = images.min(), images.max()
    if lowest < 0 or highest > 1:
        raise HarmonicFaceError(f"{name}: expected intensities from 0 to 1, got {lowest:.4g} to {highest:.4g}")
    return np.rint(images * 255).astype(np.uint8)
