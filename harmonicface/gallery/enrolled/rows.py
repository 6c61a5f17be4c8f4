"""The rows of many people, stacked, so that closeness to all of them is one product."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface.recognition.subspace import Subspace

Rows = NDArray[np.float32]
Coefficients = NDArray[np.float64]


class RowBlock:
    """Orthonormal rows of people one after the other.

    Parameters
    ----------
    array
        (r, p) rows of everybody, float32.
    starts
        (n + 1,) the first row of each person, and the number of rows.
    """

    def __init__(self, array: Rows, starts: NDArray[np.intp]) -> None:
        self._array, self._starts = array, starts

    def __len__(self) -> int:
        return len(self._starts) - 1

    @property
    def array(self) -> Rows:
        """All rows."""
        return self._array[: self._starts[-1]]

    def rows(self, index: int) -> Rows:
        """Return the rows of one person, without copying them."""
        return self._array[self._starts[index] : self._starts[index + 1]]

    def split(self, array: NDArray[Any]) -> list[NDArray[Any]]:
        """Return an array that has an entry for each row, person by person, without copying it."""
        return [array[first:last] for first, last in pairwise(self._starts.tolist())]

    def products(self, unit: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return the product of every row with a photograph, (r,)."""
        return np.asarray(self.array @ unit.astype(np.float32))

    def closeness(self, unit: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return |Q_i y|^2 of a unit photograph y for everybody, (n,), by one product over all rows."""
        products = self.products(unit)
        return np.add.reduceat(np.square(products, out=products), self._starts[:-1])

    def displaced_closeness(self, units: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the largest |Q_i y|^2 of some unit photographs y, (s, p), for everybody, by one pass over all rows."""
        products = self.array @ units.T
        np.square(products, out=products)
        return np.asarray(np.add.reduceat(products, self._starts[:-1], axis=0).max(axis=1))


class StackedRows(RowBlock):
    """Rows of people in one contiguous array that grows and shrinks.

    The array doubles when it is full, so that n people cost O(n) copies. Memory: 4 bytes a pixel and row, and up to
    as much again in reserve.

    Parameters
    ----------
    array
        (r, p) rows of everybody.
    to_coefficients
        For each person the (r, k) matrix of her `Subspace`.
    """

    def __init__(self, array: Rows, to_coefficients: Iterable[Coefficients] = ()) -> None:
        self._to_coefficients = list(to_coefficients)
        super().__init__(array, np.cumsum([0, *(len(matrix) for matrix in self._to_coefficients)]))

    @property
    def to_coefficients(self) -> Sequence[Coefficients]:
        """The (r, k) matrix of each person."""
        return self._to_coefficients

    def subspace(self, index: int) -> Subspace:
        """Return the Subspace of one person, without copying her rows."""
        return Subspace(self.rows(index), self._to_coefficients[index])

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
