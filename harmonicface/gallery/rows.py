"""The rows of all people, stacked in one contiguous array that grows and shrinks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface.recognition.subspace import Subspace

Rows = NDArray[np.float32]
Coefficients = NDArray[np.float64]


class StackedRows:
    """Orthonormal rows of people one after the other, (n, p) float32: closeness to all is one matrix product.

    The array doubles when it is full, so that n people cost O(n) copies. Memory: 4 bytes a pixel and row, and up to
    as much again in reserve.

    Parameters
    ----------
    array
        (n, p) rows of everybody.
    to_coefficients
        For each person the (r, k) matrix of her `Subspace`.
    """

    def __init__(self, array: Rows, to_coefficients: Iterable[Coefficients] = ()) -> None:
        self._array = array
        self._to_coefficients = list(to_coefficients)
        self._starts = np.cumsum([0, *(len(matrix) for matrix in self._to_coefficients)])

    def __len__(self) -> int:
        return len(self._to_coefficients)

    @property
    def array(self) -> Rows:
        """All rows, without the reserve."""
        return self._array[: self._starts[-1]]

    @property
    def to_coefficients(self) -> Sequence[Coefficients]:
        """The (r, k) matrix of each person."""
        return self._to_coefficients

    def subspace(self, index: int) -> Subspace:
        """Return the Subspace of one person, without copying her rows."""
        rows = self._array[self._starts[index] : self._starts[index + 1]]
        return Subspace(rows, self._to_coefficients[index])

    def append(self, subspace: Subspace) -> None:
        """Add a person."""
        used, needed = self._starts[-1], self._starts[-1] + subspace.rank
        if needed > len(self._array):
            larger = np.empty((max(needed, 2 * used), self._array.shape[1]), np.float32)
            larger[:used] = self.array
            self._array = larger
        self._array[used:needed] = subspace.rows
        self._to_coefficients.append(subspace.to_coefficients)
        self._starts = np.append(self._starts, needed)

    def remove(self, index: int) -> None:
        """Take a person out; those behind her move up."""
        first, last = self._starts[index], self._starts[index + 1]
        self._array = np.delete(self.array, np.s_[first:last], axis=0)
        del self._to_coefficients[index]
        self._starts = np.delete(self._starts, index + 1)
        self._starts[index + 1 :] -= last - first

    def split(self, array: NDArray[Any]) -> list[NDArray[Any]]:
        """Return an array that has an entry for each row, person by person, without copying it."""
        return np.split(array, self._starts[1:-1])

    def products(self, unit: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return the product of every row with a photograph, (n,)."""
        return np.asarray(self.array @ unit.astype(np.float32))

    def displaced_closeness(self, units: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the largest |Q_i y|^2 of some unit photographs y, (s, p), for everybody, by one pass over all rows."""
        products = self.array @ units.T
        np.square(products, out=products)
        return np.asarray(np.add.reduceat(products, self._starts[:-1], axis=0).max(axis=1))

    def closeness(self, unit: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return |Q_i y|^2 of a unit photograph y for everybody, by one product over all rows."""
        products = self.products(unit)
        return np.add.reduceat(np.square(products, out=products), self._starts[:-1])
