"""The people of a gallery in memory: their rows in one array that grows and shrinks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from harmonicface.gallery.disk.layout import DTYPES, ORTHONORMAL
from harmonicface.gallery.enrolled.enrolment import Enrolment
from harmonicface.gallery.enrolled.people import People
from harmonicface.gallery.enrolled.rows import RowBlock, StackedRows
from harmonicface.gallery.frame import Frame
from harmonicface.gallery.search.index import Index
from harmonicface.gallery.search.searcher import Searcher, SearcherInMemory
from harmonicface.gallery.search.sketch import Sketch
from harmonicface.recognition.patterns import Template


class PeopleInMemory(People):
    """Everybody, until the process ends or the gallery is saved.

    Parameters
    ----------
    frame
        As of `People`.
    """

    def __init__(self, frame: Frame | None = None) -> None:
        super().__init__(frame)
        self._rows: StackedRows | None = None
        self._names: list[str] = []
        self._known: set[str] = set()  # the names
        self._sources: list[str] = []
        self._templates: list[Template] = []  # of the default model
        self._index: Index | None = None
        self._sketches: list[Sketch] = []  # of everybody, once there is an index
        self._searcher: SearcherInMemory | None = None

    def __len__(self) -> int:
        return len(self._names)

    @property
    def names(self) -> Sequence[str]:
        """Everybody's name."""
        return tuple(self._names)

    @property
    def dtype(self) -> str:
        """The type of the rows."""
        return DTYPES[0]

    @property
    def rounding(self) -> float:
        """How far |Q y|^2 may be from 1 - distance^2: rows are rounded to float32."""
        return ORTHONORMAL[self.dtype]

    @property
    def nbytes(self) -> int:
        """Memory of rows, templates, sketches and pictures."""
        rows = 0 if self._rows is None else self._rows.array.nbytes
        templates = sum(template.nbytes for template in self._templates)
        return rows + templates + sum(map(_nbytes, self._sketches)) + self._album.nbytes

    @property
    def _everybody(self) -> StackedRows:
        assert self._rows is not None, "somebody is enrolled"
        return self._rows

    def find(self, name: str) -> int | None:
        """Return the place of a person; None if nobody has that name."""
        return self._names.index(name) if name in self._known else None

    def name(self, place: int) -> str:
        """Return a person's name."""
        return self._names[place]

    def source(self, place: int) -> str:
        """Return what a person was enrolled from."""
        return self._sources[place]

    def enrolment(self, place: int) -> Enrolment:
        """Return what stands for a person; her rows are not copied."""
        template = self._templates[place] if self._templates else None
        return Enrolment(self._everybody.subspace(place), self.frame, self._sources[place], template)

    def blocks(self) -> Iterator[RowBlock]:
        """Yield everybody's rows, in one piece."""
        yield self._everybody

    @property
    def index(self) -> Index | None:
        """The shared basis that was learned of them, if one was."""
        return self._index

    def learn(self, sample: int, seed: int) -> None:
        """Learn a shared basis from so many of the people, and sketch everybody in it."""
        self._index = self.learned(sample, seed)
        rows = [self._everybody.rows(place) for place in range(len(self))]
        self._sketches, self._searcher = list(self._index.sketches(rows)), None

    def searcher(self) -> Searcher | None:
        """Return who finds people without reading everybody; None as long as they are scanned."""
        if self._searcher is None and self._index is not None and self._sketches:
            self._searcher = SearcherInMemory(self._everybody, self._sketches, self._index)
        return self._searcher

    def add(self, people: Sequence[tuple[str, Enrolment]]) -> None:
        """Add people, whose names are new."""
        for name, enrolled in people:
            self.known_frame = enrolled.frame
            if self._rows is None:
                self._rows = StackedRows(np.empty((0, enrolled.frame.pixels), np.float32))
            self._rows.append(enrolled.subspace)
            self._names.append(name)
            self._known.add(name)
            self._sources.append(enrolled.source)
            if enrolled.template is not None:
                self._templates.append(enrolled.template)
        if self._index is not None:
            self._sketches += self._index.sketches([enrolled.subspace.rows for _, enrolled in people])
        self._searcher = None
        self.learn_in_time()

    def remove(self, names: Sequence[str]) -> None:
        """Take people out; those behind them move up."""
        for place in sorted(map(self.place, names), reverse=True):
            self._everybody.remove(place)
            self._known.discard(self._names[place])
            del self._names[place], self._sources[place]
            del self._templates[place : place + 1], self._sketches[place : place + 1]
        self._searcher = None
        self._album.forget()

    def rename(self, old: str, new: str) -> None:
        """Give a person another name; she keeps her place."""
        self._names[self.place(old)] = new
        self._known = set(self._names)

    def restore(self, rows: StackedRows, sources: dict[str, str], templates: Sequence[Template]) -> None:
        """Take in everybody from a file."""
        self._rows, self._templates = rows, list(templates)
        self._names, self._known, self._sources = list(sources), set(sources), list(sources.values())


def _nbytes(sketch: Sketch) -> int:
    """Return the memory of a sketch."""
    return sum(array.nbytes for array in (sketch.form, *sketch.numbers, sketch.levels, sketch.doubts))
