"""Checks of what filters are given: how high an order, which numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics import _checked

HIGHEST_ORDER = 1_000_000  # eight megabytes a filter, and far beyond any light that was ever measured


def filter_order(order: int) -> int:
    """Return the order of a filter, refused where its array would fill the memory."""
    if _validate.at_least(order, 0, "order") > HIGHEST_ORDER:
        raise HarmonicFaceError(f"order: expected at most {HIGHEST_ORDER}, got {order}")
    return int(order)


def at_least_zero(value: float, name: str) -> float:
    """Return a finite number that is not negative."""
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise HarmonicFaceError(f"{name}: expected a number of at least 0, got {_validate.describe(value)}")
    if not 0 <= value < np.inf:
        raise HarmonicFaceError(f"{name}: expected a finite number of at least 0, got {value}")
    try:
        return float(value)
    except OverflowError:  # an integer beyond the largest float
        raise HarmonicFaceError(f"{name}: expected a finite number of at least 0, got infinity") from None


def roughness_of(value: float, name: str = "roughness", unit: str = "radians") -> float:
    """Return a roughness, within what floats can square."""
    width = _validate.positive(value, name)
    if not 1e-100 <= width <= 100:
        raise HarmonicFaceError(f"{name}: expected {unit} from 1e-100 to 100, got {width}")
    return width


def filter_values(values: ArrayLike, name: str = "filter") -> Floats:
    """Return one finite number a degree, (order + 1,)."""
    array = _validate.finite(values, name)
    if array.ndim != 1 or array.size == 0:
        raise HarmonicFaceError(f"{name}: expected one number a degree, got {_validate.describe(array)}")
    return array


def numbers(value: ArrayLike, name: str) -> NDArray[Any]:
    """Return a finite array of real or complex numbers."""
    array = _checked.numbers(value, name)
    if array.dtype.kind != "c":
        return _validate.finite(value, name)
    if not np.isfinite(array).all():
        raise HarmonicFaceError(f"{name}: expected finite numbers, got NaN or infinite in {_validate.describe(array)}")
    return array
