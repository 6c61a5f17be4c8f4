"""The people of a gallery in a folder: what is done to them is durable, what is asked of them is read when asked."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.enrolment import Enrolment
from harmonicface.gallery.frame import Frame
from harmonicface.gallery.layout import (
    DTYPES,
    MASK,
    ROWS,
    About,
    check_rows,
    enrolled_from,
    entry_of,
)
from harmonicface.gallery.names import checked_name
from harmonicface.gallery.people import People
from harmonicface.gallery.rows import RowBlock
from harmonicface.gallery.rule import Rule
from harmonicface.store.entry import Entry
from harmonicface.store.folder import ArrayFolder
from harmonicface.store.part import Damage, Part
from harmonicface.store.shard import Record
from harmonicface.store.version import Version
from harmonicface.store.whole import make_whole
from harmonicface.store.writing import OutdatedError

PIECE = 1 << 24  # bytes of rows that are looked at together


class PeopleInFolder(People):
    """Everybody in one version of a folder; what this handle writes, it sees, with what others wrote before.

    Parameters
    ----------
    path
        The folder; it may be made by the first person.
    rule
        The gallery's, which a new folder keeps.
    dtype
        Of the rows of a new folder.
    frame
        Of a new folder; None until the first person brings it.
    """

    def __init__(self, path: Path, rule: Rule, dtype: str = DTYPES[0], frame: Frame | None = None) -> None:
        super().__init__(frame)
        self.path = path
        self.about = About.of(rule, dtype)
        self.damaged: tuple[Damage, ...] = ()
        self.rule = rule
        self._folder: ArrayFolder | None = None
        self._version: Version | None = None
        self._firsts: NDArray[np.intp] = np.zeros(1, np.intp)
        self._indices: dict[int, NDArray[np.int64]] = {}
        self._defects: dict[Record, float] = {}  # of shards whose rows have been checked
        self._parts: tuple[Part, ...] = ()

    @classmethod
    def opened(cls, path: Path) -> PeopleInFolder:
        """Open a folder.

        Raises
        ------
        HarmonicFaceError
            No gallery is there, or one that contradicts itself.
        """
        folder = ArrayFolder(path)
        version = _version(folder)
        about = About.read(version, str(path))
        people = cls(path, about.rule(), about.dtype)
        people._folder = folder
        people._take(version, about)
        return people

    def __len__(self) -> int:
        return int(self._firsts[-1])

    @property
    def names(self) -> Sequence[str]:
        """Everybody's name; reads the directories of the shards."""
        return () if self._version is None else tuple(map(checked_name, self._version.keys))

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
            raise HarmonicFaceError(f"expected a gallery at {self.path!s:.300}, got none before somebody is enrolled")
        return self._version

    @property
    def folder(self) -> ArrayFolder:
        """The folder; raises as `version` does."""
        assert self.version is not None
        assert self._folder is not None
        return self._folder

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

    def add(self, name: str, enrolled: Enrolment) -> None:
        """Add a person, durably."""
        self.add_all([(name, enrolled)])

    def add_all(self, people: Sequence[tuple[str, Enrolment]]) -> None:
        """Add people, durably and at once; their names are new, and there is at least one."""
        if self._version is None:
            self.make(people[0][1].frame, self._entries(people))
            return
        while True:
            try:
                self.folder.append(self._entries(people), made_for=self.version)
                break
            except OutdatedError:  # somebody has learned another shared basis
                self.refresh()
        self.refresh()

    def make(self, frame: Frame, entries: Iterable[Entry] = ()) -> None:
        """Make the folder."""
        self.about = About.of(self.rule, self.about.dtype)
        make_whole(self.path, entries, self.about.kinds(frame), self.about.words(), {MASK: frame.mask})
        self._folder = ArrayFolder(self.path)
        self.refresh()

    def remove(self, name: str) -> None:
        """Take a person out, durably."""
        self.refresh()
        self.place(name)
        self.folder.remove(name)
        self.refresh()

    def rename(self, old: str, new: str) -> None:
        """Give a person another name, durably."""
        self.refresh()
        self.place(old)
        self.folder.rename(old, new)
        self.refresh()

    def demand_room(self) -> None:
        """Refuse a path at which no folder can be made."""
        if not _is_free(self.path):
            raise HarmonicFaceError(
                f"create: expected a new or an empty folder, got {self.path!s:.300}, which is there"
            )

    def describe(self) -> None:
        """Keep the gallery's rule as it is now."""
        self.refresh()
        about = About.of(self.rule, self.about.dtype)
        self.folder.describe(replace(about, stops=self.about.stops, sample=self.about.sample).words())
        self.refresh()

    def verify(self) -> tuple[Damage, ...]:
        """Read everything; say what is damaged, or not what a gallery holds."""
        found = self.folder.verify()
        lost = {key for damage in found for key in damage.keys}
        files = {damage.file for damage in found if not damage.keys}
        version = self.folder.version(leave_out_damaged=True)
        about = About.read(version, str(self.path))
        frame, wrong = Frame.of(version.common[MASK]), []
        for part in version.parts:
            for index in part.indices.tolist() if part.listed.record.file not in files else ():
                key = part.key(index)
                if key in lost:
                    continue
                try:
                    enrolled_from(part.entry(index), frame, about.rule().by_score)
                except HarmonicFaceError as error:
                    wrong.append(Damage(part.listed.record.file, str(error), (key,), len(part)))
            part.shard.forget()
        return (*found, *wrong)

    def compact(self) -> int:
        """Write the files anew without what was removed."""
        freed = self.folder.compact()
        self.refresh()
        return freed

    def refresh(self) -> None:
        """Look at the folder as it is now.

        Raises
        ------
        HarmonicFaceError
            Another gallery has taken its place.
        """
        if self._folder is None:
            return
        version = _version(self._folder)
        self._take(version, About.read(version, str(self.path)))

    def _take(self, version: Version, about: About) -> None:
        """Stand for the people of a version."""
        frame = Frame.of(version.common[MASK])
        if self._version is not None:
            same = about.model == self.about.model and np.array_equal(frame.mask, self.frame.mask)
            if not same:
                raise HarmonicFaceError(f"{self.path!s:.300}: expected the gallery that was opened, got another there")
        self.known_frame, self.about, self._version, self.damaged = frame, about, version, version.damaged
        self._parts = version.parts
        self._firsts = np.cumsum([0, *map(len, version.parts)])
        self._indices = {}
        self._album.forget()

    def _entries(self, people: Iterable[tuple[str, Enrolment]]) -> Iterator[Entry]:
        """Yield people as they are kept."""
        for name, enrolled in people:
            yield entry_of(name, enrolled, self.about.dtype)

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


def _version(folder: ArrayFolder) -> Version:
    """Open a folder; shards that cannot be opened are left out with a warning."""
    try:
        return folder.version()
    except HarmonicFaceError:
        version = folder.version(leave_out_damaged=True)
    lost = sum(damage.entries for damage in version.damaged)
    warnings.warn(
        f"{folder.path}: {len(version.damaged)} damaged files, {lost} people are left out: see `verify`", stacklevel=4
    )
    return version


def _is_free(path: Path) -> bool:
    """Tell whether nothing is there, or an empty folder."""
    try:
        return not path.exists() or (path.is_dir() and not any(path.iterdir()))
    except (OSError, ValueError):  # whoever makes it says what is wrong
        return True


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
