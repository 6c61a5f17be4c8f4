"""Who is nearest: a fast product over everybody, then exact distances for those who may be among the first."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from harmonicface.gallery.frame import Frame
from harmonicface.gallery.rows import StackedRows
from harmonicface.recognition.subspace import unit_photo

# Closeness |Q y|^2 is summed in float32; whoever is within this of the last place is examined too.
ROUNDING = 1e-5
# Through a mask it is divided by the eigenvalues of Q Q^T over the good pixels, which magnify the rounding.
MASKED_ROUNDING = 1e-3
SMALLEST_EIGENVALUE = 0.05
DISPLACEMENTS = (-1 / 12, -1 / 24, 0.0, 1 / 24, 1 / 12)  # of the height, across and down


def rank(rows: StackedRows, unit: NDArray[np.float64], good: NDArray[np.bool_], top: int) -> list[tuple[float, int]]:
    """Return the `top` smallest distances and whose they are, nearest first; ties go to who was enrolled first.

    Parameters
    ----------
    rows
        Everybody's orthonormal rows over p pixels.
    unit
        The good pixels of a photograph, of unit length.
    good
        (p,) booleans: which pixels these are.
    top
        How many, at least 1.
    """
    whole = bool(good.all())
    closeness = rows.closeness(unit) if whole else _masked_closeness(rows, unit, good)
    last = np.partition(closeness, -top)[-top] if top < len(closeness) else -np.inf
    candidates = np.flatnonzero(closeness >= last - (ROUNDING if whole else MASKED_ROUNDING))
    exact = [(_distance(rows, int(index), unit, good), int(index)) for index in candidates]
    return sorted(exact)[:top]


def shortlist(rows: StackedRows, pixels: NDArray[np.float64], good: NDArray[np.bool_], count: int) -> NDArray[np.intp]:
    """Return the `count` people nearest to a photograph, in the order of enrolment; the first ones if it is dark.

    Parameters
    ----------
    rows
        Everybody's orthonormal rows over p pixels.
    pixels
        The good pixels of a photograph.
    good
        (p,) booleans: which pixels these are.
    count
        How many, at least 1.
    """
    if count >= len(rows) or not pixels.any():
        return np.arange(min(count, len(rows)))
    unit = unit_photo(pixels, len(pixels))
    closeness = rows.closeness(unit) if good.all() else _masked_closeness(rows, unit, good)
    return np.sort(np.argpartition(closeness, -count)[-count:])


def displaced_shortlist(
    rows: StackedRows, frame: Frame, pixels: NDArray[np.float64], good: NDArray[np.bool_], count: int
) -> NDArray[np.intp]:
    """Return the `count` people nearest to a photograph that may show them displaced by up to a twelfth of its height.

    Parameters
    ----------
    rows, count
        As for `shortlist`.
    frame
        The gallery's.
    pixels, good
        (p,) of a photograph that is not dark, and which are good.
    """
    if count >= len(rows):
        return np.arange(len(rows))
    steps = [round(part * frame.shape[0]) for part in DISPLACEMENTS]
    units = []
    for right, down in product(steps, steps):
        moved, known = frame.moved(pixels, good, (right, down))
        length = float(np.linalg.norm(moved[known]))
        if length > 0:
            units.append((moved * known / length).astype(np.float32))
    closeness = rows.displaced_closeness(np.stack(units))
    return np.sort(np.argpartition(closeness, -count)[-count:])


def _masked_closeness(rows: StackedRows, unit: NDArray[np.float64], good: NDArray[np.bool_]) -> NDArray[np.float64]:
    r"""Return how much of a photograph everybody explains over the good pixels g: b^T G^{-1} b.

    b = Q_g y and G = Q_g Q_g^T = I - Q_b Q_b^T, from the bad pixels alone. Where they leave G nearly singular, the
    person is examined exactly.
    """
    photo = np.zeros(len(good))
    photo[good] = unit
    bad = rows.array[:, ~good].astype(np.float64)
    closeness = np.empty(len(rows))
    for index, (part, hidden) in enumerate(zip(rows.split(rows.products(photo)), rows.split(bad), strict=True)):
        values, vectors = np.linalg.eigh(np.eye(len(part)) - hidden @ hidden.T)
        if values[0] > SMALLEST_EIGENVALUE:
            closeness[index] = (np.square(part @ vectors) / values).sum()
        else:
            closeness[index] = 1 - _distance(rows, index, unit, good) ** 2
    return closeness


def _distance(rows: StackedRows, index: int, unit: NDArray[np.float64], good: NDArray[np.bool_]) -> float:
    """Return the distance of one person; who has nothing behind the mask explains nothing."""
    subspace = rows.subspace(index)
    if good.all():
        return subspace.distance(unit)
    return subspace.restrict(good).distance(unit) if subspace.rows[:, good].any() else 1.0
