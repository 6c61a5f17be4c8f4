"""Searcher: who finds the people nearest to a photograph without reading everybody; here, among people in memory."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from harmonicface.gallery.enrolled.rows import RowBlock
from harmonicface.gallery.search import cascade
from harmonicface.gallery.search.cascade import FURTHEST, Found
from harmonicface.gallery.search.crowd import crowd
from harmonicface.gallery.search.index import Index
from harmonicface.gallery.search.pixels import Pixels
from harmonicface.gallery.search.sketch import Sketch

Units = NDArray[np.float64]


class Searcher(Protocol):
    """What `Shelf` is for files on this machine, and `SharedShelf` for those of a cluster."""

    def search(self, unit: Units, top: int | None = 1, distance: float = FURTHEST) -> Found:
        """Find the people nearest to a photograph (p,) of unit length."""
        ...

    def search_many(self, units: Units, top: int | None = 1, distance: float = FURTHEST) -> list[Found]:
        """Find the people nearest to each of several photographs (q, p)."""
        ...


class SearcherInMemory:
    """People in memory who all have sketches.

    Parameters
    ----------
    rows
        Everybody's.
    sketches
        Of each.
    index
        In which they were made.
    """

    def __init__(self, rows: RowBlock, sketches: Sequence[Sketch], index: Index) -> None:
        self._basis = index.basis
        self._companies = crowd(sketches, index.stops)
        self._pixels = Pixels(rows.rows, np.array([one.defect for one in sketches]), rows.array.shape[1])

    def search(self, unit: Units, top: int | None = 1, distance: float = FURTHEST) -> Found:
        """Find the people nearest to a photograph (p,) of unit length."""
        return cascade.search(self._companies, self._pixels, self._basis, unit, top, distance)

    def search_many(self, units: Units, top: int | None = 1, distance: float = FURTHEST) -> list[Found]:
        """Find the people nearest to each of several photographs (q, p)."""
        return cascade.search_many(self._companies, self._pixels, self._basis, units, top, distance)
