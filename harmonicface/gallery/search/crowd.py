"""Crowd: everybody's sketches, stacked stage by stage so that a search reads them from one end to the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.search.gathered import Gathered
from harmonicface.gallery.search.sketch import Sketch

Array = NDArray[np.float32]
Indices = NDArray[np.intp]
EVERYBODY = slice(None)


@dataclass(frozen=True, eq=False)
class Company:
    """People of the same number of rows; made by `crowd`, or by `packing.companies_of` from the arrays of files.

    Parameters
    ----------
    people
        (n,) their places in the order of enrolment.
    numbers
        For each stage (n, r, columns) float32: the columns that it adds; of the later stages they may stay in files.
    turns
        For each stage but the first (n, r, r) float32, or (n, r^2) in files.
    squares
        For each stage (n, r) float32.
    largest
        For each stage (n,) float32: the largest of the squares.
    doubts
        For each stage (n,) float32.
    stops
        How many rows of the shared basis each stage has seen.
    """

    people: Indices
    numbers: tuple[Array | Gathered, ...]
    turns: tuple[Array | Gathered, ...]
    squares: tuple[Array, ...]
    largest: tuple[Array, ...]
    doubts: tuple[Array, ...]
    stops: tuple[int, ...]

    @property
    def rank(self) -> int:
        """How many rows each of them has."""
        return int(self.numbers[0].shape[1])

    def first_products(self, coordinates: Array, chosen: Indices | slice = EVERYBODY) -> Array:
        """Return b of the first stage: (n, r) from (m,) coordinates, (n, r, q) from (m, q)."""
        numbers = self.numbers[0][chosen]
        flat = numbers.reshape(-1, numbers.shape[2]) @ coordinates[: self.stops[0]]
        return np.asarray(flat.reshape(len(numbers), self.rank, *coordinates.shape[1:]))

    def next_products(self, stage: int, chosen: Indices, products: Array, coordinates: Array) -> Array:
        """Return b of a later stage for chosen people from that of the stage before; shapes as of the first."""
        start, stop = self.stops[stage - 1 : stage + 1]
        added = self.numbers[stage][chosen].reshape(-1, stop - start) @ coordinates[start:stop]
        turns = self.turns[stage - 1][chosen].reshape(-1, self.rank, self.rank)
        turned = turns @ products if products.ndim == 3 else np.einsum("nkl,nl->nk", turns, products)
        return np.asarray(turned + added.reshape(products.shape))


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
        if one.numbers.shape[1] != stops[-1] or len(one.squares) != len(stops):
            expected = f"stages of {stops} columns"
            raise HarmonicFaceError(f"sketches: expected {expected}, got {len(one.squares)} of {one.numbers.shape[1]}")
    ranks = np.array([len(one.numbers) for one in sketches], np.intp)
    return tuple(_company(np.flatnonzero(ranks == rank), sketches, stops) for rank in np.unique(ranks))


def _company(people: Indices, sketches: Sequence[Sketch], stops: tuple[int, ...]) -> Company:
    """Stack the sketches of people of one rank."""
    chosen = [sketches[index] for index in people]
    spans = list(zip((0, *stops[:-1]), stops, strict=True))
    return Company(
        people,
        tuple(np.stack([one.numbers[:, a:b] for one in chosen]).astype(np.float32) for a, b in spans),
        tuple(np.stack([one.turns[stage] for one in chosen]) for stage in range(len(stops) - 1)),
        tuple(np.stack([one.squares[stage] for one in chosen]) for stage in range(len(stops))),
        tuple(np.stack([one.squares[stage].max() for one in chosen]) for stage in range(len(stops))),
        tuple(np.stack([one.doubts[stage] for one in chosen]) for stage in range(len(stops))),
        stops,
    )
