"""Crowd: everybody's sketches, stacked stage by stage so that a search reads them from one end to the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.search.gathered import Gathered
from harmonicface.gallery.search.products import products
from harmonicface.gallery.search.sketch import Sketch

Array = NDArray[np.float32]
Indices = NDArray[np.intp]
BLOCK = 1 << 22  # numbers that are looked at together, about what a processor's last cache holds


@dataclass(frozen=True, eq=False)
class Company:
    """People of the same number of rows; made by `crowd`, or by `packing.companies_of` from the arrays of files.

    Parameters
    ----------
    people
        (n,) their places in the order of enrolment.
    forms
        (k + 2, n) float32: the quadratic form of each, then its level and its doubt; the products with one photograph
        are twice as fast as with the people in rows.
    numbers
        For each stage (n, r, columns), float32 in memory, or wherever they are in files.
    levels, doubts
        (n, stages) float32: of each stage.
    stops
        How many rows of the shared basis each stage has seen.
    """

    people: Indices
    forms: Array
    numbers: tuple[Array | Gathered, ...]
    levels: Array
    doubts: Array
    stops: tuple[int, ...]

    @property
    def rank(self) -> int:
        """How many rows each of them has."""
        return int(self.numbers[0].shape[1])

    @property
    def nbytes(self) -> int:
        """Bytes in memory."""
        kept = [some.nbytes for some in self.numbers if isinstance(some, np.ndarray)]
        return sum(kept) + self.people.nbytes + self.forms.nbytes + self.levels.nbytes + self.doubts.nbytes

    def bounds(self, stage: int, chosen: Indices, coordinates: Array, left: Array) -> Array:
        """Return bounds of |Q y|^2 of chosen people, (n,) rising, at a stage: (n, q).

        Parameters
        ----------
        stage
            From 0.
        chosen
            (n,) indices, rising.
        coordinates
            (columns, q) of the photographs.
        left
            (q,) the squared lengths that the shared basis leaves over of them.
        """
        numbers, asked = self.numbers[stage], coordinates.shape[1]
        found = np.empty((len(chosen), asked), np.float32)
        in_place = isinstance(numbers, np.ndarray) and _together(chosen)
        step = max(1, BLOCK // (self.rank * (asked if in_place else asked + len(coordinates))))
        copied = np.empty((0 if in_place else min(step, len(chosen)), *numbers.shape[1:]), np.float32)
        for start in range(0, len(chosen), step):
            some = chosen[start : start + step]
            found[start : start + step] = self._squares(numbers, some, coordinates, copied)
        rest = self.levels[chosen, stage, None] * left
        rest += self.doubts[chosen, stage, None]
        found += rest
        return found

    def _squares(self, numbers: Array | Gathered, some: Indices, coordinates: Array, copied: Array) -> Array:
        """Return |N a|^2 of some people; where most of their neighbours are asked too, nothing is copied."""
        together, first = _together(some), int(some[0])
        if together:
            taken = numbers[first : some[-1] + 1]
        elif isinstance(numbers, np.ndarray) and len(some) <= len(copied):
            # where it was before: fresh memory would cost more than the copy
            taken = np.take(numbers, some, axis=0, out=copied[: len(some)], mode="clip")
        else:
            taken = numbers[some]
        seen = products(taken, coordinates)
        if seen.shape[2] == 1:
            squares = np.einsum("nr,nr->n", seen[:, :, 0], seen[:, :, 0])[:, None]
        else:
            squares = np.einsum("nrq,nrq->nq", seen, seen)
        return np.asarray(squares[some - first] if together and len(squares) > len(some) else squares)


def _together(some: Indices) -> bool:
    """Return whether most of the people between the first and the last are asked."""
    return len(some) > 0 and int(some[-1] - some[0]) < 2 * len(some)


def crowd(sketches: Sequence[Sketch], columns: Sequence[int]) -> tuple[Company, ...]:
    """Stack sketches, by rank; float16 numbers become float32, which the matrix products of this machine read.

    Parameters
    ----------
    sketches
        Of everybody, in the order of enrolment, with the same stages.
    columns
        The stages' columns, as for `sketch`.

    Raises
    ------
    HarmonicFaceError
        Sketches whose stages differ from the columns.
    """
    stops = tuple(columns)
    for one in sketches:
        if one.stops != stops:
            raise HarmonicFaceError(f"sketches: expected stages of {stops} columns, got {one.stops}")
    ranks = np.array([len(one.numbers[0]) for one in sketches], np.intp)
    return tuple(_company(np.flatnonzero(ranks == rank), sketches, stops) for rank in np.unique(ranks))


def _company(people: Indices, sketches: Sequence[Sketch], stops: tuple[int, ...]) -> Company:
    """Stack the sketches of people of one rank."""
    chosen = [sketches[index] for index in people]
    levels, doubts = np.stack([one.levels for one in chosen]), np.stack([one.doubts for one in chosen])
    numbers = [np.stack([one.numbers[stage] for one in chosen]).astype(np.float32) for stage in range(len(stops))]
    forms = stacked_forms(np.stack([one.form for one in chosen]), levels, doubts)
    return Company(people, forms, tuple(numbers), levels[:, 1:].copy(), doubts[:, 1:].copy(), stops)


def stacked_forms(forms: Array, levels: Array, doubts: Array) -> Array:
    """Return (k + 2, n) forms (n, k) with their levels and doubts, which `bound.features` are multiplied with."""
    return np.concatenate([forms.T, levels[:, :1].T, doubts[:, :1].T])
