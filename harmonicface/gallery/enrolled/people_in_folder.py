"""The people of a gallery in a folder: what is done to them is on the disk when it is done."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.disk.checkup import checkup
from harmonicface.gallery.disk.layout import BASIS, COEFFICIENTS, MASK, ROWS, TEMPLATE, About, entries_of
from harmonicface.gallery.disk.staging import refuse_writing, staged
from harmonicface.gallery.enrolled.enrolment import Enrolment
from harmonicface.gallery.enrolled.people_in_version import PeopleInVersion
from harmonicface.gallery.frame import Frame
from harmonicface.gallery.search.index import Index
from harmonicface.gallery.search.packing import packed
from harmonicface.store.entry import Entry
from harmonicface.store.folder import ArrayFolder
from harmonicface.store.manifest import NAME as MANIFEST
from harmonicface.store.part import Damage
from harmonicface.store.version import Version
from harmonicface.store.whole import TakenError, make_whole
from harmonicface.store.writing import OutdatedError

if TYPE_CHECKING:
    from distributed import Client


class PeopleInFolder(PeopleInVersion):
    """Everybody in a folder, which the first person may make; the parameters are those of `PeopleInVersion`.

    They are those of the version that was opened, until this handle writes or is refreshed: then it sees what others
    have written too.
    """

    _folder: ArrayFolder | None = None

    @classmethod
    def opened(cls, path: Path, client: Client | None = None, url: str | None = None) -> PeopleInFolder:
        """Open a folder; with a url it is the copy of one in object storage, which nobody writes to.

        Raises
        ------
        HarmonicFaceError
            No gallery is there, or one that contradicts itself.
        """
        if not (path / MANIFEST).exists():
            raise HarmonicFaceError(f"expected a gallery at {path!s:.300}, got a folder that is none")
        folder = ArrayFolder(path)
        version = _version(folder)
        about = About.read(version, str(path))
        people = cls(path, about.rule(), about.dtype, None, client, url)
        people._folder = folder
        people.take(version, about)
        return people

    @property
    def folder(self) -> ArrayFolder:
        """The folder, to be written to; raises as `version` does, and for a copy of one in object storage."""
        if self._folder is None:
            raise self.nothing_there()
        refuse_writing(self.url or self.path)
        return self._folder

    def learn(self, sample: int, seed: int) -> None:
        """Learn a shared basis from so many of the people, and write everybody anew with a sketch in it."""
        self._look()
        folder = self.folder  # refused before anything is learned
        index = self.learned(sample, seed)
        about = replace(self.about, stops=index.stops, sample=index.sample)
        common = {MASK: self.frame.mask, BASIS: index.basis.rows}
        folder.revise(partial(_sketched, index), about.kinds(self.frame), about.words(), common)
        self._look()

    def add(self, people: Sequence[tuple[str, Enrolment]]) -> None:
        """Add people, durably and at once."""
        while not self._added(people):  # somebody has made the folder, or learned another shared basis, meanwhile
            self._look()
        self._look()
        if not self.damaged:  # nothing is written anew beside what is damaged
            self.learn_in_time()

    def _added(self, people: Sequence[tuple[str, Enrolment]]) -> bool:
        """Write people, unless what they are written for has changed."""
        for name, enrolled in people:
            if self._version is not None and not np.array_equal(enrolled.frame.mask, self.frame.mask):
                raise HarmonicFaceError(f"{name}: expected the pixels of the gallery at {self.path!s:.300}, got others")
        try:
            if self._version is None:
                self.make(people[0][1].frame, people)
            else:
                entries = entries_of(people, self.about.dtype, self.index)
                self.folder.append(entries, made_for=self.version)
        except TakenError:
            self._folder = ArrayFolder(self.path)
            return False
        except OutdatedError:
            return False
        return True

    def make(self, frame: Frame, people: Iterable[tuple[str, Enrolment]] = ()) -> None:
        """Make the folder with people in it; raises `TakenError` if something is there."""
        self.about = About.of(self.rule, self.about.dtype)
        entries = entries_of(people, self.about.dtype, None)
        make_whole(self.path, entries, self.about.kinds(frame), self.about.words(), {MASK: frame.mask})
        self._folder = ArrayFolder(self.path)
        self._look()

    def remove(self, names: Sequence[str]) -> None:
        """Take people out, durably and at once."""
        self._look()
        for name in names:
            self.place(name)
        self.folder.remove(names)
        self._look()

    def rename(self, old: str, new: str) -> None:
        """Give a person another name, durably."""
        self._look()
        self.place(old)
        self.folder.rename(old, new)
        self._look()

    def describe(self) -> None:
        """Keep the gallery's rule as it is now."""
        self._look()
        about = About.of(self.rule, self.about.dtype)
        self.folder.describe(replace(about, stops=self.about.stops, sample=self.about.sample).words())
        self._look()

    def verify(self) -> tuple[Damage, ...]:
        """Read everything; say what is damaged, or not what a gallery holds."""
        if self._version is None:
            raise self.nothing_there()
        return checkup(self.path)

    def compact(self) -> int:
        """Write the files anew without what was removed."""
        freed = self.folder.compact()
        self._look()
        return freed

    def refresh(self) -> None:
        """Look at the folder as it is now; one in object storage is copied again if it is another there.

        Raises
        ------
        HarmonicFaceError
            Another gallery has taken its place; what is in object storage cannot be copied.
        """
        if self.url is not None and (copy := staged(self.url)) != self.path:
            version = _version(folder := ArrayFolder(copy))
            self.take(version, About.read(version, str(copy)))
            self.path, self._folder = copy, folder
        else:
            self._look()

    def _look(self) -> None:
        """Look at the folder on this machine as it is now."""
        if self._folder is None:
            return
        version = _version(self._folder)
        self.take(version, About.read(version, str(self.path)))


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


def _sketched(index: Index, entry: Entry) -> Entry:
    """Return a person with a sketch in a shared basis."""
    kept = {name: array for name, array in entry.arrays.items() if name in (ROWS, COEFFICIENTS, TEMPLATE)}
    [sketch] = index.sketches([entry.arrays[ROWS]])
    return replace(entry, arrays=kept | packed(sketch))
