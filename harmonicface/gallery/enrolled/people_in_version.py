"""The people in one version of a folder: read, and checked, when they are asked for."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.disk.layout import BASIS, DTYPES, MASK, ROWS, About, check_rows, enrolled_from
from harmonicface.gallery.distributed.shared_shelf import SharedShelf
from harmonicface.gallery.distributed.workers import enrolments
from harmonicface.gallery.enrolled.enrolment import Enrolment, Model
from harmonicface.gallery.enrolled.people import People
from harmonicface.gallery.enrolled.promised import Promise
from harmonicface.gallery.enrolled.rows import RowBlock
from harmonicface.gallery.frame import Frame
from harmonicface.gallery.names import checked_name
from harmonicface.gallery.rule import Rule
from harmonicface.gallery.search.index import Index
from harmonicface.gallery.search.searcher import Searcher
from harmonicface.gallery.search.shared_basis import SharedBasis
from harmonicface.gallery.search.shelf import Shelf
from harmonicface.store.entry import Entry
from harmonicface.store.part import Damage, Part
from harmonicface.store.shard import Record
from harmonicface.store.version import Version

if TYPE_CHECKING:
    from distributed import Client

PIECE = 1 << 24  # bytes of rows that are looked at together


class PeopleInVersion(People):
    """Everybody who was in a folder at one moment; nobody, as long as there is no folder.

    Parameters
    ----------
    path
        The folder.
    rule
        The gallery's.
    dtype
        Of the rows of a folder that is still to be made.
    frame
        Of such a folder, if it is known.
    client
        Of a Dask cluster, whose workers search and enrol; None for this process.
    url
        Of what in object storage the folder is a copy of.
    """

    def __init__(
        self,
        path: Path,
        rule: Rule,
        dtype: str = DTYPES[0],
        frame: Frame | None = None,
        client: Client | None = None,
        url: str | None = None,
    ) -> None:
        super().__init__(frame)
        self.path, self.client, self.url = path, client, url
        self.about = About.of(rule, dtype)
        self.damaged: tuple[Damage, ...] = ()
        self.rule = rule
        self._version: Version | None = None
        self._parts: tuple[Part, ...] = ()
        self._firsts: NDArray[np.intp] = np.zeros(1, np.intp)  # the place of the first person of each part
        self._indices: dict[int, NDArray[np.int64]] = {}  # by part: which entries of the shard are in the folder
        self._defects: dict[Record, float] = {}  # of shards whose rows have been checked
        self._index: Index | None = None
        self._searcher: Searcher | None = None

    def __len__(self) -> int:
        return int(self._firsts[-1])

    @property
    def names(self) -> Sequence[str]:
        """Everybody's name; reads the directories of the shards."""
        return () if self._version is None else tuple(map(checked_name, self._version.keys))

    @property
    def dtype(self) -> str:
        """The type of the rows as they are kept."""
        return self.about.dtype

    @property
    def rounding(self) -> float:
        """How far |Q y|^2 may be from 1 - distance^2; everybody's rows are read and checked once."""
        return max((self._defect(part) for part in self._parts), default=0.0)

    @property
    def nbytes(self) -> int:
        """Bytes on the disk, those of removed people among them until `compact`."""
        return 0 if self._version is None else self._version.nbytes

    @property
    def version(self) -> Version:
        """What was in the folder when it was last looked at.

        Raises
        ------
        HarmonicFaceError
            The folder is still to be made, by the first person.
        """
        if self._version is None:
            raise self.nothing_there()
        return self._version

    def find(self, name: str) -> int | None:
        """Return the place of a person; None if nobody has that name."""
        for number, part in enumerate(self._parts):
            index = part.find(name)
            if index is not None:
                return int(self._firsts[number] + np.searchsorted(self._indices_of(number), index))
        return None

    def name(self, place: int) -> str:
        """Return a person's name."""
        part, index = self._where(place)
        return checked_name(part.key(index))

    def source(self, place: int) -> str:
        """Return what a person was enrolled from."""
        part, index = self._where(place)
        return str(part.shard.directory.about(index).get("source"))

    def entry(self, place: int) -> Entry:
        """Return a person as she is kept."""
        part, index = self._where(place)
        return part.entry(index)

    def enrolment(self, place: int) -> Enrolment:
        """Return what stands for a person, checked (`enrolled_from`)."""
        return enrolled_from(self.entry(place), self.frame, self.rule.by_score)

    def blocks(self) -> Iterator[RowBlock]:
        """Yield everybody's rows as float32, checked when their shard is looked at for the first time."""
        for part in self._parts:
            self._defect(part)
            array, starts = part.shard.arrays[ROWS], _starts(part, ROWS)
            for first, behind in _runs(part, starts, PIECE // (4 * self.frame.pixels)):
                rows = array[starts[first] : starts[behind]]
                yield RowBlock(np.asarray(rows, np.float32), starts[first : behind + 1] - starts[first])

    @property
    def index(self) -> Index | None:
        """The shared basis that was learned of them, if one was; it is read when it is first asked for."""
        if self._index is None and self.about.stops:
            try:
                basis = SharedBasis(self.version.common[BASIS])
            except HarmonicFaceError as error:
                raise HarmonicFaceError(f"{self.path!s:.300}, basis: {error}") from None
            self._index = Index(basis, self.about.stops, self.about.sample)
        return self._index

    def searcher(self) -> Searcher | None:
        """Return who finds people without reading everybody, on the cluster if there is one; None if they are scanned.

        What a search reads first of everybody is copied into memory when it is first asked for.
        """
        if self._searcher is None and self.client is not None:
            sound = replace(self.version.manifest, shards=tuple(part.listed for part in self._parts))
            self._searcher = SharedShelf(self.url or str(self.path), self.client, sound)
        elif self._searcher is None and self.index is not None:
            firsts = self._firsts[:-1].tolist()
            self._searcher = Shelf.of_parts(self._parts, firsts, self.index.basis, self.index.stops)
        return self._searcher

    def enrolments(self, sources: Iterable[Promise], model: Model) -> Iterator[Enrolment]:
        """Yield what stands for people, in their order, made by the cluster if there is one."""
        if self.client is None:
            return super().enrolments(sources, model)
        return enrolments(self.client, sources, self.known_frame, model)

    def take(self, version: Version, about: About) -> None:
        """Stand for the people of a version."""
        frame = Frame.of(version.common[MASK])
        other = about.model != self.rule.model
        if self._version is not None:
            other = other or not np.array_equal(frame.mask, self.frame.mask)
            if version.manifest.common != self._version.manifest.common:
                self._index = None
        if other:
            raise HarmonicFaceError(f"{self.path!s:.300}: expected the gallery that was opened, got another there")
        self.known_frame, self.about, self._version, self.damaged = frame, about, version, version.damaged
        self._parts = version.parts
        self._firsts = np.cumsum([0, *map(len, version.parts)])
        self._indices, self._searcher = {}, None
        self._album.forget()

    def nothing_there(self) -> HarmonicFaceError:
        """Return what is raised where a folder is needed and there is none yet."""
        return HarmonicFaceError(f"expected a gallery at {self.path!s:.300}, got none before somebody is enrolled")

    def _where(self, place: int) -> tuple[Part, int]:
        """Return the part in which a person is, and her index there."""
        number = int(np.searchsorted(self._firsts, place, side="right")) - 1
        return self._parts[number], int(self._indices_of(number)[place - self._firsts[number]])

    def _defect(self, part: Part) -> float:
        """Return the largest |Q Q^T - I| of anybody in a shard, everybody's rows checked."""
        record = part.listed.record
        if record not in self._defects:
            array, starts = part.shard.arrays[ROWS], _starts(part, ROWS)
            self._defects[record] = max(
                check_rows(array[starts[index] : starts[index + 1]], part.key(index)) for index in part.indices.tolist()
            )
        return self._defects[record]

    def _indices_of(self, number: int) -> NDArray[np.int64]:
        """Return who of a part is in the folder."""
        if number not in self._indices:
            self._indices[number] = self._parts[number].indices
        return self._indices[number]


def _starts(part: Part, name: str) -> NDArray[np.int64]:
    """Return the first row of everybody of a shard in an array, and the number of rows."""
    return part.shard.directory.starts[:, sorted(part.shard.kinds).index(name)]


def _runs(part: Part, starts: NDArray[np.int64], rows: int) -> Iterator[tuple[int, int]]:
    """Yield ranges of entries that are all in the folder, of about so many rows each."""
    edges = np.flatnonzero(np.diff(part.alive, prepend=False, append=False)).reshape(-1, 2)
    for first, behind in edges.tolist():
        while first < behind:
            last = int(np.searchsorted(starts, starts[first] + rows, side="right")) - 1
            end = min(behind, max(last, first + 1))
            yield first, end
            first = end
