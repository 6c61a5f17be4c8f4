"""Correlation: the nearest training photograph, apart from brightness and contrast."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.estimators.nearest import unit_contrast
from harmonicface.recognition.photographs import one_photo, stacked


class Correlation:
    """Nearest photograph by normalized correlation (Brunelli & Poggio 1993; Belhumeur et al. 1997).

    Photographs x and y are compared by `(x - mean x) . (y - mean y) / (|x - mean x| |y - mean y|)`. The training
    photographs are kept as unit vectors of mean zero, so that a query costs one matrix product.

    Examples
    --------
    >>> random = np.random.default_rng(0)
    >>> ada, bob = random.uniform(0, 1, (2, 3, 8, 8))
    >>> correlation = Correlation()
    >>> correlation.enroll([ada, bob])
    >>> correlation.nearest(0.1 + 0.5 * bob[2])
    1
    """

    def __init__(self) -> None:
        self._rows: NDArray[np.float32] | None = None
        self._people = np.zeros(0, np.int32)
        self._shape: tuple[int, int] | None = None
        self._count = 0

    def enroll(self, photographs: Sequence[ArrayLike]) -> None:
        """Learn all people at once; the person of `photographs[i]` is i.

        Parameters
        ----------
        photographs
            For each person, (n_i, h, w) linear grey intensities.

        Raises
        ------
        HarmonicFaceError
            Nobody, unequal shapes, NaN, a photograph without contrast.
        """
        given = stacked(photographs)
        rows = np.stack([_unit(image, "photographs") for image in given.images])
        self._rows, self._people, self._count = rows, given.people, given.count
        self._shape = given.images.shape[1], given.images.shape[2]

    def nearest(self, photo: ArrayLike) -> int:
        """Return the person whose photograph correlates best with a photo of shape (h, w).

        Raises
        ------
        HarmonicFaceError
            Nobody is enrolled, another shape, NaN, a photo without contrast.
        """
        query = _unit(one_photo(photo, self._shape), "photo")
        assert self._rows is not None
        return int(self._people[(self._rows @ query).argmax()])

    @property
    def bytes_per_person(self) -> int:
        """Bytes of what is kept, over the number of people."""
        return 0 if self._rows is None else self._rows.nbytes // self._count


def _unit(image: NDArray[np.float32], name: str) -> NDArray[np.float32]:
    """Return the pixels as a float32 vector of mean zero and length one."""
    pixels = unit_contrast(image.reshape(1, -1).astype(np.float64))[0]
    if not pixels.any():
        raise HarmonicFaceError(f"{name}: expected an image with contrast, got one of {image.min():.4g} everywhere")
    return np.asarray(pixels, np.float32)
