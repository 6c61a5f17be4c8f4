"""Grey beside colour: values of pixels with and without channels in one formula."""

from __future__ import annotations

import numpy as np

from harmonicface._validate import Floats


def colourwise(operation: np.ufunc, one: Floats, other: Floats) -> Floats:
    """Return a ufunc of (p,) or (p, 3) values and (p,) or (p, 3) values; what is grey is the same in each colour.

    Examples
    --------
    >>> colourwise(np.multiply, np.array([0.5, 1.0]), np.array([[1.0, 2.0, 3.0], [0.0, 0.0, 1.0]]))
    array([[0.5, 1. , 1.5],
           [0. , 0. , 1. ]])
    """
    if one.ndim != other.ndim:
        one, other = (array if array.ndim == 2 else array[:, None] for array in (one, other))
    return np.asarray(operation(one, other))
