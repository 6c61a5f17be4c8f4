"""Sketches as arrays of a file, and a search's companies from the arrays of many files, without an object a person."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.search.crowd import Company, Indices, stacked_forms
from harmonicface.gallery.search.gathered import Gathered
from harmonicface.gallery.search.sketch import DTYPES, Sketch, form_columns

Arrays = dict[str, NDArray[Any]]
FORM, NUMBERS, LEVELS, DOUBTS, DEFECT = (f"sketch_{name}" for name in ("form", "numbers", "levels", "doubts", "defect"))


def sketch_kinds(stops: Sequence[int], dtype: str = "float32") -> dict[str, tuple[np.dtype[Any], tuple[int, ...]]]:
    """Return the arrays that keep a sketch: by name the type and the shape of one row.

    A person has one row of the form, r rows of the numbers of each stage, one level and one doubt of the form and of
    each stage, and one defect; nothing of any of them if she is not sketched.

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
    (dtype('float32'), (128,))
    """
    if dtype not in DTYPES:
        raise HarmonicFaceError(f"dtype: expected one of {', '.join(DTYPES)}, got {dtype!r}")
    single, count = np.dtype(np.float32), form_columns(stops)
    kinds = {f"{NUMBERS}_{stage}": (np.dtype(dtype), (stop,)) for stage, stop in enumerate(stops)}
    return kinds | {
        FORM: (single, (count * (count + 1) // 2,)),
        LEVELS: (single, ()),
        DOUBTS: (single, ()),
        DEFECT: (np.dtype(np.float64), ()),
    }


def packed(sketch: Sketch) -> Arrays:
    """Return a sketch as arrays of the kinds of `sketch_kinds`."""
    return {f"{NUMBERS}_{stage}": some for stage, some in enumerate(sketch.numbers)} | {
        FORM: sketch.form[None],
        LEVELS: sketch.levels,
        DOUBTS: sketch.doubts,
        DEFECT: np.array([sketch.defect]),
    }


def unpacked(arrays: Mapping[str, NDArray[Any]]) -> Sketch:
    """Return the sketch of one person from her arrays, the inverse of `packed`."""
    numbers = tuple(arrays[f"{NUMBERS}_{stage}"] for stage in range(len(arrays[DOUBTS]) - 1))
    return Sketch(arrays[FORM][0], numbers, arrays[LEVELS], arrays[DOUBTS], float(arrays[DEFECT][0]))


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

    def first_rows(self, rank: int, each: Indices | int = 1) -> Indices:
        """Return the first row of those of a rank who are to be found, when those with a sketch have `each` rows."""
        rows = np.where(self.ranks > 0, each, 0)
        return np.asarray((np.cumsum(rows) - rows)[self.alive & (self.ranks == rank)], np.intp)

    def places_of(self, rank: int) -> Indices:
        """Return the places of those of a rank."""
        return np.asarray(self.places[self.ranks[self.alive & (self.ranks > 0)] == rank])


def companies_of(packs: Sequence[Pack], stops: Sequence[int]) -> tuple[Company, ...]:
    """Return the companies of a search, by rank.

    The quadratic forms, and a few numbers a person beside them, are copied into memory; the numbers of the stages stay
    where they are, and a search reads those of the people whom it has not excluded before.

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
    bounds = len(stops) + 1

    def one_each(name: str, count: int) -> NDArray[np.float32]:
        """Return `count` rows of everybody, in memory."""
        starts = [pack.first_rows(rank, count) for pack in having]
        return np.asarray(Gathered([pack.arrays[name] for pack in having], starts, count)[:], np.float32)

    rows = [pack.first_rows(rank, pack.ranks) for pack in having]
    numbers = [
        Gathered([pack.arrays[f"{NUMBERS}_{stage}"] for pack in having], rows, rank) for stage in range(len(stops))
    ]
    levels, doubts = one_each(LEVELS, bounds), one_each(DOUBTS, bounds)
    forms = stacked_forms(one_each(FORM, 1)[:, 0], levels, doubts)
    people = np.concatenate([pack.places_of(rank) for pack in having])
    return Company(people, forms, tuple(numbers), levels[:, 1:].copy(), doubts[:, 1:].copy(), stops)
