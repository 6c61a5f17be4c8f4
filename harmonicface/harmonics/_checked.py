"""Checks that the converters between conventions share."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import order_of


def coefficients(value: ArrayLike, name: str = "coefficients") -> tuple[Floats, int]:
    """Return finite coefficients and their order."""
    given = np.atleast_1d(_validate.finite(value, name))
    return given, order_of(len(given))


def numbers(value: ArrayLike, name: str) -> NDArray[Any]:
    """Return real or complex numbers as an array."""
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "biufc":
            raise TypeError
    except (TypeError, ValueError):  # ragged lists among them
        raise HarmonicFaceError(f"{name}: expected complex numbers, got {_validate.describe(value)}") from None
    return array


def nothing_outside(given: NDArray[Any], first: Any, rest: Any, where: str) -> None:
    """Refuse numbers where there is no harmonic, which a conversion would lose."""
    outside = given.copy()
    outside[(first, *rest) if isinstance(rest, tuple) else (first, rest)] = 0
    if outside.any():
        raise HarmonicFaceError(f"coefficients: expected zeros for {where}, got {np.abs(outside).max():.4g}")
