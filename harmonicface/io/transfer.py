"""Transfer: the curve between stored sRGB values and linear light."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError


def srgb_to_linear(values: ArrayLike) -> Floats:
    """Decode sRGB values to linear light.

    v / 12.92 up to 0.04045, above it ((v + 0.055) / 1.055) ** 2.4 (IEC 61966-2-1).

    Parameters
    ----------
    values
        Finite numbers of any shape, 0 to 1 (above 1 the curve goes on).

    Returns
    -------
    array
        The same shape, 0 to 1; float32 stays float32, the rest is float64.

    Raises
    ------
    HarmonicFaceError
        NaN or a negative value.

    Examples
    --------
    >>> srgb_to_linear([0.0, 0.5, 1.0]).round(4)
    array([0.   , 0.214, 1.   ])
    """
    array = _not_negative(values)
    curve = ((array + 0.055) / 1.055) ** 2.4
    return np.where(array <= 0.04045, array / 12.92, curve).astype(array.dtype, copy=False)


def linear_to_srgb(values: ArrayLike) -> Floats:
    """Encode linear light as sRGB values, the inverse of `srgb_to_linear`.

    Parameters
    ----------
    values
        Finite numbers of any shape, 0 to 1 (above 1 the curve goes on).

    Returns
    -------
    array
        The same shape, 0 to 1; float32 stays float32, the rest is float64.

    Raises
    ------
    HarmonicFaceError
        NaN or a negative value.

    Examples
    --------
    >>> linear_to_srgb([0.0, 0.2140411, 1.0]).round(4)
    array([0. , 0.5, 1. ])
    """
    array = _not_negative(values)
    curve = 1.055 * array ** (1 / 2.4) - 0.055
    return np.where(array <= 0.04045 / 12.92, array * 12.92, curve).astype(array.dtype, copy=False)


def _not_negative(values: ArrayLike) -> Floats:
    array = _validate.finite(values, "values")
    if array.size and array.min() < 0:
        raise HarmonicFaceError(f"values: expected at least 0, got {array.min():.4g}")
    return array
