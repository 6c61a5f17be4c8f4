"""Section: neighbours in one shard of a gallery, whose rows are read where they are."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.disk.layout import ROWS
from harmonicface.gallery.search.packing import DEFECT, DOUBTS, FORM, LEVELS, NUMBERS, Pack
from harmonicface.gallery.search.sketch import ORTHONORMAL
from harmonicface.store.part import Part

BLOCK = 1 << 25  # bytes of rows that are looked at together
Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Section:
    """Some people of one shard.

    Parameters
    ----------
    part
        The shard as a version of the gallery sees it.
    indices
        (n,) rising: which entries of the shard they are; none that has been removed.
    first_place
        The place of the first of them in the gallery's order of enrolment; the others follow.

    Raises
    ------
    HarmonicFaceError
        A damaged shard, somebody without rows, or a part of a sketch.
    """

    part: Part
    indices: Indices
    first_place: int

    def __post_init__(self) -> None:
        if not np.diff(self.starts(ROWS)).all():
            raise HarmonicFaceError(f"{self.part.shard.path}: expected rows of everybody, got somebody without any")
        if not self._whole_sketches():
            raise HarmonicFaceError(f"{self.part.shard.path}: expected whole sketches of rows, got a part of one")

    def __len__(self) -> int:
        return len(self.indices)

    @property
    def pixels(self) -> int:
        """How many pixels a row has."""
        return int(self.part.shard.kinds[ROWS].shape[0])

    @cached_property
    def sketched(self) -> NDArray[np.bool_]:
        """(n,) who of them has a sketch."""
        if DOUBTS not in self.part.shard.kinds:
            return np.zeros(len(self), np.bool_)
        return np.asarray(np.diff(self.starts(DOUBTS))[self.indices] > 0)

    def starts(self, name: str) -> NDArray[np.int64]:
        """Return the first row of every entry of the shard in an array, and the number of rows, (entries + 1,)."""
        return self.part.shard.directory.starts[:, sorted(self.part.shard.kinds).index(name)]

    def rows(self, number: int) -> NDArray[np.floating]:
        """Return the (r, p) rows of one of them as they are stored: a view of the file.

        Raises
        ------
        HarmonicFaceError
            NaN or infinity in them.
        """
        starts, index = self.starts(ROWS), self.indices[number]
        found: NDArray[np.floating] = self.part.shard.arrays[ROWS][starts[index] : starts[index + 1]]
        if not np.isfinite(found).all():
            raise HarmonicFaceError(f"{self.name(number)!r:.80}: expected finite rows, got NaN or infinity")
        return found

    def name(self, number: int) -> str:
        """Return the name of one of them."""
        return self.part.key(int(self.indices[number]))

    def pack(self, first: int) -> Pack:
        """Return what a search needs of those with a sketch, who get the places from `first` on."""
        wanted = np.zeros(self.part.listed.record.entries, np.bool_)
        wanted[self.indices] = True
        ranks = np.diff(self.starts("sketch_numbers_0")).astype(np.intp)
        return Pack(self.part.shard.arrays, ranks, first + np.flatnonzero(self.sketched), wanted)

    def defects(self) -> NDArray[np.float64]:
        """Return how far everybody's rows are from orthonormal, (n,); NaN of who has no sketch.

        Raises
        ------
        HarmonicFaceError
            Somebody's are too far.
        """
        found = np.full(len(self), np.nan)
        if self.sketched.any():
            chosen = self.starts(DEFECT)[self.indices[self.sketched]]
            found[self.sketched] = self.part.shard.arrays[DEFECT][chosen]
            if not ((found[self.sketched] >= 0) & (found[self.sketched] <= ORTHONORMAL)).all():
                raise HarmonicFaceError(f"{self.part.shard.path}: expected orthonormal rows, got some that are not")
        return found

    def closeness(self, units: NDArray[np.float32]) -> Iterator[tuple[slice, NDArray[np.float32]]]:
        """Yield |Q y|^2 of everybody for unit photographs, block by block: which of them, and (n, q) from (q, p).

        Raises
        ------
        HarmonicFaceError
            Rows with NaN or infinity.
        """
        starts, array = self.starts(ROWS), self.part.shard.arrays[ROWS]
        for some in self._blocks(starts, array):
            first, behind = int(self.indices[some][0]), int(self.indices[some][-1]) + 1
            rows = np.asarray(array[starts[first] : starts[behind]], np.float32)
            products = rows @ units.T
            sums = np.add.reduceat(np.square(products, out=products), starts[first:behind] - starts[first], axis=0)
            found = sums[self.indices[some] - first]
            if not np.isfinite(found).all():
                raise HarmonicFaceError(f"{self.part.shard.path}: expected finite rows, got NaN or infinity in some")
            yield some, found

    def _whole_sketches(self) -> bool:
        """Tell whether everybody in the shard has all of a sketch or nothing; others' would be read in its place."""
        names = [name for name in self.part.shard.kinds if name.startswith("sketch_")]
        stages = sum(name.startswith(NUMBERS) for name in names)
        of_all = {FORM: 1, LEVELS: stages + 1, DOUBTS: stages + 1, DEFECT: 1}
        ranks = np.diff(self.starts(ROWS))
        counts = {name: np.diff(self.starts(name)) for name in names}
        return all((counts[name] == np.where(counts[DOUBTS] > 0, of_all.get(name, ranks), 0)).all() for name in names)

    def _blocks(self, starts: NDArray[np.int64], array: NDArray[Any]) -> Iterator[slice]:
        """Yield slices of the people whose rows, with those of removed people between them, are one block."""
        begin, per_row = 0, array.shape[1] * array.itemsize
        while begin < len(self):
            ends = (starts[self.indices[begin:] + 1] - starts[self.indices[begin]]) * per_row
            behind = begin + max(1, int(np.searchsorted(ends, BLOCK, side="right")))
            yield slice(begin, behind)
            begin = behind
