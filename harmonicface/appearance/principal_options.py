"""Options of principal components: how many, and by how much each pixel counts."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces.surface import Surface

Array = NDArray[np.float64]

NO_DIFFERENCE = "pictures: expected some that differ where pixels count, got none"


def pixel_weights(surface: Surface, weights: ArrayLike | None) -> Array:
    """Return by how much each masked pixel counts, (p,).

    Raises
    ------
    HarmonicFaceError
        Another shape, negative weights, NaN in the mask, nothing but 0.
    """
    if weights is None:
        return np.ones(int(surface.mask.sum()))
    array = _validate.floats(weights, "weights")
    if array.shape != surface.shape:
        raise HarmonicFaceError(f"weights: expected shape {surface.shape}, got {_validate.describe(array)}")
    found = _validate.finite(array[surface.mask], "weights").astype(np.float64)
    if found.min() < 0 or not found.any():
        expected = "at least 0, and more in a pixel of the mask"
        raise HarmonicFaceError(f"weights: expected {expected}, got {found.min():.4g} to {found.max():.4g}")
    return found


def checked_count(value: int | float) -> int | float:
    """Return a count of components of at least 1, or a share above 0 and below 1.

    Raises
    ------
    HarmonicFaceError
        Another number.
    """
    if isinstance(value, (float, np.floating)):
        if not 0 < value < 1:
            raise HarmonicFaceError(
                f"n_components: expected a count of at least 1 or a share above 0 and below 1, got {value}"
            )
        return float(value)
    return _validate.at_least(value, 1, "n_components")


def kept_components(values: Array, total: float, wanted: int | float, rounding: float) -> int:
    """Return how many components to keep: those wanted, as far as rounding can tell them from nothing.

    Parameters
    ----------
    values
        (r,) eigenvalues, largest first.
    total
        The variance of which a wanted share is one.
    wanted
        A count or a share.
    rounding
        Of the largest eigenvalue: what is not above it may be rounding alone.

    Raises
    ------
    HarmonicFaceError
        No eigenvalue above 0, a share that all components together do not explain.
    """
    if not values[0] > 0:
        raise HarmonicFaceError(NO_DIFFERENCE)
    known = int((values > values[0] * rounding).sum())
    if isinstance(wanted, int):
        return min(wanted, known)
    explained = values[:known].cumsum() / total
    if explained[-1] < wanted:
        reached = f"at most {explained[-1]:.4f}, which all components of this order explain"
        raise HarmonicFaceError(f"n_components: expected a share of {reached}, got {wanted}")
    return int(np.searchsorted(explained, wanted)) + 1
