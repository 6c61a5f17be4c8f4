"""Who is nearest: a fast product over everybody, then exact distances for those who may be among the first."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface.gallery.rows import StackedRows

# Closeness |Q y|^2 is summed in float32; whoever is within this of the last place is examined too.
ROUNDING = 1e-5


def rank(rows: StackedRows, unit: NDArray[np.float64], good: NDArray[np.bool_], top: int) -> list[tuple[float, int]]:
    """Return the `top` smallest distances and whose they are, nearest first; ties go to who was enrolled first.

    Parameters
    ----------
    rows
        Everybody's orthonormal rows over p pixels.
    unit
        The good pixels of a photograph, of unit length.
    good
        (p,) booleans: which pixels these are. With bad pixels among them, every person is projected by herself.
    top
        How many, at least 1.
    """
    closeness = rows.closeness(unit) if good.all() else _masked_closeness(rows, unit, good)
    last = np.partition(closeness, -top)[-top] if top < len(closeness) else -np.inf
    candidates = np.flatnonzero(closeness >= last - ROUNDING)
    exact = [(_distance(rows, int(index), unit, good), int(index)) for index in candidates]
    return sorted(exact)[:top]


def _masked_closeness(rows: StackedRows, unit: NDArray[np.float64], good: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return |Q_i y|^2 of everybody, with Q_i orthonormal over the good pixels alone."""
    return np.array([1 - _distance(rows, index, unit, good) ** 2 for index in range(len(rows))])


def _distance(rows: StackedRows, index: int, unit: NDArray[np.float64], good: NDArray[np.bool_]) -> float:
    """Return the distance of one person; who has nothing behind the mask explains nothing."""
    subspace = rows.subspace(index)
    if good.all():
        return subspace.distance(unit)
    return subspace.restrict(good).distance(unit) if subspace.rows[:, good].any() else 1.0
