"""Sketches as arrays of a file, and a search's companies from the arrays of many files, without an object a person."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.search.crowd import Company, Indices
from harmonicface.gallery.search.gathered import Gathered
from harmonicface.gallery.search.sketch import DTYPES, Sketch

Arrays = dict[str, NDArray[Any]]
NUMBERS, TURNS, SQUARES, DOUBTS, DEFECT = (
    f"sketch_{name}" for name in ("numbers", "turns", "squares", "doubts", "defect")
)


def sketch_kinds(stops: Sequence[int], dtype: str = "float32") -> dict[str, tuple[np.dtype[Any], tuple[int, ...]]]:
    """Return the arrays that keep a sketch: by name the type and the shape of one row.

    A person has r rows of the numbers of each stage, (stages - 1) r^2 of the turns, stages r of the squares, as many
    doubts as stages and one defect; nothing of any of them if she is not sketched.

    Parameters
    ----------
    stops
        How many rows of the shared basis each stage has seen.
    dtype
        Of the numbers, "float32" or "float16".

    Raises
    ------
    HarmonicFaceError
        Another dtype.

    Examples
    --------
    >>> sketch_kinds((32, 128))["sketch_numbers_1"]
    (dtype('float32'), (96,))
    """
    if dtype not in DTYPES:
        raise HarmonicFaceError(f"dtype: expected one of {', '.join(DTYPES)}, got {dtype!r}")
    single = np.dtype(np.float32)
    widths = np.diff(stops, prepend=0).tolist()
    kinds = {f"{NUMBERS}_{stage}": (np.dtype(dtype), (width,)) for stage, width in enumerate(widths)}
    return kinds | {
        TURNS: (single, ()),
        SQUARES: (single, ()),
        DOUBTS: (single, ()),
        DEFECT: (np.dtype(np.float64), ()),
    }


def packed(sketch: Sketch) -> Arrays:
    """Return a sketch as arrays of the kinds of `sketch_kinds`."""
    numbers = np.split(sketch.numbers, sketch.stops[:-1], axis=1)
    arrays = {f"{NUMBERS}_{stage}": np.ascontiguousarray(some) for stage, some in enumerate(numbers)}
    return arrays | {
        TURNS: sketch.turns.reshape(-1),
        SQUARES: sketch.squares.reshape(-1),
        DOUBTS: sketch.doubts,
        DEFECT: np.array([sketch.defect]),
    }


def unpacked(arrays: Mapping[str, NDArray[Any]]) -> Sketch:
    """Return the sketch of one person from her arrays, the inverse of `packed`."""
    numbers = [arrays[f"{NUMBERS}_{stage}"] for stage in range(len(arrays[DOUBTS]))]
    stops = tuple(np.cumsum([some.shape[1] for some in numbers]).tolist())
    rank = len(numbers[0])
    turns, squares = arrays[TURNS].reshape(-1, rank, rank), arrays[SQUARES].reshape(-1, rank)
    return Sketch(np.concatenate(numbers, axis=1), turns, squares, arrays[DOUBTS], float(arrays[DEFECT][0]), stops)


@dataclass(frozen=True, eq=False)
class Pack:
    """The people of one file.

    Parameters
    ----------
    arrays
        Those of `sketch_kinds`, the rows of all people of the file one after the other.
    ranks
        (n,) rows of each person's sketch, of all people of the file; 0 for who is not sketched.
    places
        Places in the order of enrolment of those who are alive and sketched.
    alive
        (n,) who of the file is to be found.
    """

    arrays: Mapping[str, NDArray[Any]]
    ranks: Indices
    places: Indices
    alive: NDArray[np.bool_]

    def first_rows(self, rank: int, rows: Indices) -> Indices:
        """Return the first row of those of a rank who are to be found, when each person has so many rows (n,)."""
        first: Indices = np.cumsum(rows) - rows
        return np.asarray(first[self.alive & (self.ranks == rank)])

    def places_of(self, rank: int) -> Indices:
        """Return the places of those of a rank."""
        return np.asarray(self.places[self.ranks[self.alive & (self.ranks > 0)] == rank])


def companies_of(packs: Sequence[Pack], stops: Sequence[int]) -> tuple[Company, ...]:
    """Return the companies of a search, by rank.

    The numbers of the first stage, and a few numbers a person beside them, are copied into memory; those of the later
    stages stay where they are, and a search reads those of the people whom the first stage does not exclude.

    Parameters
    ----------
    packs
        Everybody, file by file.
    stops
        How many rows of the shared basis each stage has seen.

    Raises
    ------
    HarmonicFaceError
        Places that are not one of each person who is alive and sketched; arrays of other stages.
    """
    for pack in packs:
        found = int((pack.alive & (pack.ranks > 0)).sum())
        if len(pack.places) != found:
            raise HarmonicFaceError(f"places: expected {found} of people with a sketch, got {len(pack.places)}")
        for name, (_, shape) in sketch_kinds(stops).items():
            if name not in pack.arrays or pack.arrays[name].shape[1:] != shape:
                seen = pack.arrays[name].shape[1:] if name in pack.arrays else "none"
                raise HarmonicFaceError(f"{name}: expected rows of shape {shape} for stages {stops}, got {seen}")
    ranks = sorted({int(rank) for pack in packs for rank in np.unique(pack.ranks[pack.alive])})
    return tuple(_company(packs, rank, tuple(stops)) for rank in ranks if rank)


def _company(packs: Sequence[Pack], rank: int, stops: tuple[int, ...]) -> Company:
    """Return the people of one rank."""
    having = [pack for pack in packs if (pack.alive & (pack.ranks == rank)).any()]
    stages = len(stops)

    def gathered(name: str, of_rank: NDArray[np.intp], each: int, more: int = 0) -> Gathered:
        """Return `each` rows of everybody from `more` rows on; of_rank[r] is how many a person of rank r has."""
        starts = [pack.first_rows(rank, of_rank[pack.ranks]) + more for pack in having]
        return Gathered([pack.arrays[name] for pack in having], starts, each)

    ranks = np.arange(max(int(pack.ranks.max()) for pack in having) + 1)
    some, square = (ranks > 0).astype(np.intp), rank * rank
    squares = gathered(SQUARES, stages * ranks, stages * rank)[:].reshape(-1, stages, rank)
    doubts = gathered(DOUBTS, stages * some, stages)[:]
    numbers = [gathered(f"{NUMBERS}_{stage}", ranks, rank) for stage in range(stages)]
    turns = [gathered(TURNS, (stages - 1) * ranks**2, square, stage * square) for stage in range(stages - 1)]
    return Company(
        np.concatenate([pack.places_of(rank) for pack in having]),
        (numbers[0][:], *numbers[1:]),
        tuple(turns),
        tuple(np.ascontiguousarray(squares[:, stage]) for stage in range(stages)),
        tuple(np.ascontiguousarray(squares[:, stage].max(axis=1)) for stage in range(stages)),
        tuple(np.ascontiguousarray(doubts[:, stage]) for stage in range(stages)),
        stops,
    )
