"""Gathered: the rows of chosen people, taken from the arrays of several files when they are asked for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.intp]


class Gathered:
    """Blocks of as many rows each, of people one after the other, that stay where they are.

    Parameters
    ----------
    arrays
        (rows, *shape) each, of any float type; memory maps are read where people are asked for.
    starts
        For each array the first row of each person in it, (n,).
    rank
        How many rows each person has.
    dtype
        What rows become when they are read.
    """

    def __init__(
        self, arrays: Sequence[NDArray[Any]], starts: Sequence[Indices], rank: int, dtype: str = "float32"
    ) -> None:
        self._arrays, self._starts, self._rank = tuple(arrays), tuple(starts), rank
        self._first = np.cumsum([0, *(len(some) for some in starts)])
        self._dtype = np.dtype(dtype)
        self._people = int(self._first[-1])
        self.shape = (self._people, rank, *arrays[0].shape[1:])

    def __len__(self) -> int:
        return self._people

    def __getitem__(self, chosen: Indices | slice) -> NDArray[Any]:
        """Return (n, rank, *shape) rows of chosen people, who are asked for in rising order."""
        if isinstance(chosen, slice):
            chosen = np.arange(self._people)[chosen]
        edges = np.searchsorted(chosen, self._first)
        parts = [
            self._taken(number, chosen[edges[number] : edges[number + 1]] - self._first[number])
            for number in np.flatnonzero(np.diff(edges)).tolist()
        ]
        if len(parts) == 1:
            return parts[0]
        return np.concatenate(parts) if parts else np.empty((0, *self.shape[1:]), self._dtype)

    def _taken(self, number: int, chosen: Indices) -> NDArray[Any]:
        """Return rows of people of one array; of neighbours, what is there already."""
        starts, array = self._starts[number][chosen], self._arrays[number]
        if starts[-1] - starts[0] == self._rank * (len(starts) - 1):
            taken = array[starts[0] : starts[-1] + self._rank].reshape(len(chosen), *self.shape[1:])
        else:
            taken = array[starts[:, None] + np.arange(self._rank)]
        return np.asarray(taken, self._dtype)
