"""Products of many rows with photographs; with one photograph, without waiting for another thread."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Kind = TypeVar("Kind", np.float32, np.float64)


def products(rows: NDArray[Kind], photographs: NDArray[Kind]) -> NDArray[Kind]:
    """Return rows times photographs, summed in any order.

    Rows that one photograph is asked of are read once, which one thread does as fast as two; a matrix product would
    divide them all the same, and wait for its other threads where the processor is busy.

    Parameters
    ----------
    rows
        (..., c).
    photographs
        (c, q).

    Returns
    -------
    numpy.ndarray
        (..., q).

    Examples
    --------
    >>> products(np.ones((2, 3)), np.array([[1.0], [2.0], [3.0]]))
    array([[6.],
           [6.]])
    """
    if photographs.shape[1] == 1:
        found: NDArray[Any] = np.einsum("...c,c->...", rows, photographs[:, 0])[..., None]
        return found
    flat = rows.reshape(-1, rows.shape[-1]) @ photographs
    return flat.reshape(*rows.shape[:-1], photographs.shape[1])
