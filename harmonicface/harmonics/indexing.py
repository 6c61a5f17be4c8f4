"""Where a harmonic is stored: degree l and mode m at l * (l + 1) + m."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from harmonicface import _memory, _validate
from harmonicface.errors import HarmonicFaceError


def count(order: int) -> int:
    """Return how many harmonics there are up to and including an order: (order + 1)^2.

    Examples
    --------
    >>> count(2)
    9
    """
    return (_validate.at_least(order, 0, "order") + 1) ** 2


def order_of(size: int) -> int:
    """Return the order of a vector of `size` harmonic coefficients.

    Raises
    ------
    HarmonicFaceError
        The size is no integer that is a square number: 1, 4, 9, 16, ...

    Examples
    --------
    >>> order_of(9)
    2
    """
    whole = isinstance(size, (int, np.integer)) and not isinstance(size, bool)
    root = math.isqrt(max(size, 0)) if whole else 0
    if root < 1 or root * root != size:
        raise HarmonicFaceError(f"coefficients: expected (order + 1)^2 of them (1, 4, 9, 16, ...), got {size!r}")
    return root - 1


def index(degree: int, mode: int) -> int:
    """Return where the harmonic of degree l and mode m is stored.

    Raises
    ------
    HarmonicFaceError
        The degree is no integer of at least 0, the mode none between -l and l.

    Examples
    --------
    >>> index(2, -2), index(2, 0), index(2, 2)
    (4, 6, 8)
    """
    if abs(_validate.at_least(mode, -_validate.at_least(degree, 0, "degree"), "mode")) > degree:
        raise HarmonicFaceError(f"mode: expected an integer from {-degree} to {degree}, got {mode}")
    return degree * (degree + 1) + mode


def degrees(order: int) -> NDArray[np.intp]:
    """Return the degree l of each stored harmonic, ((order + 1)^2,).

    Raises
    ------
    HarmonicFaceError
        A negative order, one that needs more memory than there is.

    Examples
    --------
    >>> degrees(2)
    array([0, 1, 1, 1, 2, 2, 2, 2, 2])
    """
    _memory.require(8 * count(order), f"degrees of the harmonics of order {order}")
    modes = 2 * np.arange(int(order) + 1) + 1
    return np.repeat(np.arange(len(modes)), modes)


def modes(order: int) -> NDArray[np.intp]:
    """Return the mode m of each stored harmonic, ((order + 1)^2,).

    Raises
    ------
    HarmonicFaceError
        A negative order, one that needs more memory than there is.

    Examples
    --------
    >>> modes(2)
    array([ 0, -1,  0,  1, -2, -1,  0,  1,  2])
    """
    _memory.require(24 * count(order), f"modes of the harmonics of order {order}")
    degree = degrees(order)
    return np.asarray(np.arange(len(degree)) - degree * (degree + 1))
