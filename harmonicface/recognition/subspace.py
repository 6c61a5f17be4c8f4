"""Subspace: the orthonormal rows that span a person's pictures, and how far a photograph is from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError

ROUNDINGS = 8  # operations behind each number of a harmonic image


@dataclass(frozen=True, eq=False)
class Subspace:
    """The span of a few pictures, as orthonormal rows; made by `Subspace.of`.

    Parameters
    ----------
    rows
        (r, p) orthonormal rows, float32.
    to_coefficients
        (r, k): `(rows @ photo) @ to_coefficients` combine the k pictures to the best explanation of the photograph,
        of least norm where the pictures depend on each other. For harmonic images they are the light.
    """

    rows: NDArray[np.float32]
    to_coefficients: NDArray[np.float64]

    @classmethod
    def of(cls, images: ArrayLike, most: int | None = None) -> Subspace:
        """Orthonormalize pictures, revealing their rank.

        The pictures are factored as images^T = Q R, then R = U s V^T. Rounding each number of the pictures moves s by
        at most eps |images|_F <= eps sqrt(k) s_1; directions within a few times that are not part of the span, so
        dependent pictures (a wall has one normal) give fewer rows.

        Parameters
        ----------
        images
            (k, p) pictures as rows, of any scale, not all 0.
        most
            Keep at most so many rows, at least 1: those of the largest singular values.

        Returns
        -------
        Subspace

        Raises
        ------
        HarmonicFaceError
            Not a (k, p) array, NaN or infinity, all 0 or nearly (1e-308); `most` below 1.

        Examples
        --------
        >>> Subspace.of([[3.0, 0.0, 0.0], [0.0, 2.0, 0.0], [3.0, 2.0, 0.0]]).rank
        2
        """
        pictures = _validate.finite(images, "images")
        limit = pictures.size if most is None else _validate.at_least(most, 1, "most")
        if pictures.ndim != 2 or pictures.size == 0:
            raise HarmonicFaceError(f"images: expected shape (k, p), got {_validate.describe(pictures)}")
        scale = float(np.abs(pictures).max())
        if scale == 0:
            raise HarmonicFaceError(f"images: expected a picture with something in it, got {len(pictures)} of zeros")
        rounding = ROUNDINGS * np.finfo(pictures.dtype).eps * np.sqrt(len(pictures))
        columns = pictures.T.astype(np.float64) / scale
        q, r = scipy.linalg.qr(columns, mode="economic", overwrite_a=True, check_finite=False)
        u, values, vt = scipy.linalg.svd(r, full_matrices=False, check_finite=False)
        rank = min(int((values > values[0] * rounding).sum()), limit)
        rows = np.ascontiguousarray((q @ u[:, :rank]).T, dtype=np.float32)
        with np.errstate(over="ignore"):
            to_coefficients = vt[:rank] / (values[:rank, None] * scale)
        if not np.isfinite(to_coefficients).all():
            raise HarmonicFaceError(f"images: expected brighter pictures, got values of at most {scale:.4g}")
        # contiguous, as it comes back from a file: the order in memory decides the last bit of a product
        return cls(rows, np.ascontiguousarray(to_coefficients))

    @property
    def rank(self) -> int:
        """How many independent pictures there are."""
        return len(self.rows)

    @property
    def condition(self) -> float:
        """By how much more noise is amplified in the worst determined coefficient than in the best, at least 1."""
        return float(np.linalg.cond(self.to_coefficients))

    def distance(self, photo: ArrayLike) -> float:
        r"""Return the sine of the angle between photo and subspace: \sqrt{1 - |Q y|^2 / |y|^2}, 0 to 1.

        It is computed from the residual, so that a small distance keeps its digits.

        Parameters
        ----------
        photo
            (p,) pixels, not all 0.

        Raises
        ------
        HarmonicFaceError
            Another count of pixels, NaN or infinity, all 0.

        Examples
        --------
        >>> Subspace.of([[1.0, 0.0]]).distance([1.0, 1.0]).__round__(6)
        0.707107
        """
        unit = unit_photo(photo, self.rows.shape[1])
        return min(1.0, float(np.linalg.norm(unit - self.nearest(unit))))

    def nearest(self, photo: ArrayLike) -> NDArray[np.float64]:
        """Return the picture of the span that is nearest to the photograph, (p,).

        It projects twice: the second pass takes out of the residual what rounded rows leave of the span in it.

        Raises
        ------
        HarmonicFaceError
            Another count of pixels, NaN or infinity.
        """
        pixels = _pixels(photo, self.rows.shape[1])
        rows = self.rows.astype(np.float64)  # once, rather than in each product
        first = (rows @ pixels) @ rows
        return np.asarray(first + (rows @ (pixels - first)) @ rows)

    def coefficients(self, photo: ArrayLike) -> NDArray[np.float64]:
        """Return how the k pictures combine to the photograph best, (k,).

        Raises
        ------
        HarmonicFaceError
            Another count of pixels, NaN or infinity; pictures so dark that no number is large enough.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            found = np.asarray((self.rows @ _pixels(photo, self.rows.shape[1])) @ self.to_coefficients)
        if not np.isfinite(found).all():
            raise HarmonicFaceError(
                "photo: expected one that the pictures can make, got coefficients beyond any number"
            )
        return found

    def restrict(self, good: NDArray[np.bool_]) -> Subspace:
        """Return the span of the same pictures seen through a mask, for a photograph of which some pixels are bad.

        Parameters
        ----------
        good
            (p,) booleans, true where the photograph is good.

        Raises
        ------
        HarmonicFaceError
            Not one boolean a pixel; nothing of the pictures is left behind the mask.
        """
        shape = (self.rows.shape[1],)
        if np.shape(good) != shape or np.asarray(good).dtype != np.bool_:
            raise HarmonicFaceError(f"good: expected booleans of shape {shape}, got {_validate.describe(good)}")
        seen = Subspace.of(self.rows[:, good])
        return Subspace(seen.rows, seen.to_coefficients @ self.to_coefficients)


def unit_photo(photo: ArrayLike, pixels: int) -> NDArray[np.float64]:
    """Return the pixels of a photograph scaled to unit length, safely for any brightness.

    Raises
    ------
    HarmonicFaceError
        Another count of pixels than expected, NaN or infinity, all 0.
    """
    flat = _pixels(photo, pixels)
    largest = float(np.abs(flat).max())
    if largest == 0:
        raise HarmonicFaceError(f"photo: expected some light in it, got {pixels} pixels that are all 0")
    scaled = flat / largest
    return np.asarray(scaled / np.linalg.norm(scaled))


def _pixels(photo: ArrayLike, pixels: int) -> NDArray[np.float64]:
    """Return the finite pixels of a photograph in float64."""
    flat = _validate.finite(photo, "photo")
    if flat.shape != (pixels,):
        raise HarmonicFaceError(f"photo: expected {pixels} pixels, got {_validate.describe(flat)}")
    return flat.astype(np.float64)
