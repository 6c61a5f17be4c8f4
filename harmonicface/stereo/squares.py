"""Squares of pixels that become one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats


def square_sums(pictures: Floats | NDArray[np.bool_], side: int) -> Floats:
    """Return the sums over squares of pixels; of booleans, how many are true. What fills no square is left out.

    Parameters
    ----------
    pictures
        (..., h, w).
    side
        Of a square in pixels, at least 1.

    Returns
    -------
    array
        (..., h // side, w // side).

    Examples
    --------
    >>> square_sums(np.arange(10.0).reshape(2, 5), 2)
    array([[12., 20.]])
    """
    height, width = pictures.shape[-2] // side, pictures.shape[-1] // side
    whole = pictures[..., : height * side, : width * side]
    return np.asarray(whole.reshape(*whole.shape[:-2], height, side, width, side).sum(axis=(-3, -1)))
