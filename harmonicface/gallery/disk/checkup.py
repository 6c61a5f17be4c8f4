"""Checkup: everything that is wrong with a gallery on disk, whether it can be opened or not."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.disk import layout, storage
from harmonicface.gallery.disk.paths import is_folder, refuse_nothing
from harmonicface.gallery.disk.sketch_check import check_sketch
from harmonicface.gallery.frame import Frame
from harmonicface.gallery.search.shared_basis import SharedBasis
from harmonicface.store.folder import ArrayFolder
from harmonicface.store.manifest import NAME
from harmonicface.store.part import Damage, Part
from harmonicface.store.plain_file import NotOpenedError
from harmonicface.store.verification import Tell, damages
from harmonicface.store.version import Version, opened

TOGETHER = 64  # people whose rows are multiplied with the shared basis at once


def checkup(path: str | os.PathLike[str], tell: Tell = lambda *_: None) -> tuple[Damage, ...]:
    """Read every byte of a gallery, compare it with its checksum, and look at everybody as a search would.

    Parameters
    ----------
    path
        Its folder, or its one file.
    tell
        Is called with what has been done, how much, and of how much.

    Returns
    -------
    tuple
        What is damaged: the file, the reason, and the names of the people in it who are lost. Empty if all is well;
        the manifest, if without it nothing else can be read.

    Raises
    ------
    HarmonicFaceError
        No gallery is there, or the system does not let it be read.

    Examples
    --------
    >>> import tempfile
    >>> import harmonicface as hf
    >>> with tempfile.TemporaryDirectory() as place:
    ...     gallery = hf.Gallery.create(place + "/people")
    ...     gallery.enroll("ada", hf.synthetic_person(1, 24))
    ...     checkup(place + "/people")
    ()
    """
    refuse_nothing(path)
    place = Path(path)
    try:
        if is_folder(place):
            return _of_folder(place, tell)
        storage.read(place)
    except NotOpenedError:
        raise
    except HarmonicFaceError as error:
        file = place / NAME if is_folder(place) else place
        if not os.path.lexists(file):
            raise
        return (Damage(file.name, str(error), (), 0),)
    return ()


def discard(path: str | os.PathLike[str], tell: Tell = lambda *_: None) -> tuple[Damage, ...]:
    """Take out of a folder what is damaged, with the people who are lost by it; `compact` then removes the bytes.

    Parameters, result and what is raised are those of `checkup`, which says how it was before. A damaged manifest or
    mask stays: nobody is in a gallery without them. What is damaged in a file that is one gallery stays too.
    """
    found = checkup(path, tell)
    if found and is_folder(Path(path)) and NAME not in {damage.file for damage in found}:
        folder = ArrayFolder(path)
        folder.discard_damaged()
        left = folder.version(leave_out_damaged=True)
        folder.remove({key for damage in found for key in damage.keys if key in left})
    return found


def _of_folder(path: Path, tell: Tell) -> tuple[Damage, ...]:
    """Look at a folder; raises if its manifest, or what it says of the gallery, is damaged."""
    version = opened(path, {}, leave_out_damaged=True)
    found = damages(version, tell)
    common = version.manifest.common
    if common is not None and common.file in {damage.file for damage in found}:
        return found
    about, lost = layout.About.read(version, str(path)), {key for damage in found for key in damage.keys}
    try:
        judge = _Judge.of(version, about)
    except HarmonicFaceError as error:
        return (*found, Damage(common.file if common else NAME, f"{path / NAME}: {error}", (), 0))
    return (*found, *_unfit(version, judge, lost, tell))


@dataclass(frozen=True, eq=False)
class _Judge:
    """What everybody in a gallery must fit."""

    frame: Frame
    by_score: bool
    stops: tuple[int, ...]
    basis: SharedBasis | None

    @classmethod
    def of(cls, version: Version, about: layout.About) -> _Judge:
        """Return the judge of a version; raises if its shared basis is none."""
        basis = SharedBasis(version.common[layout.BASIS]) if about.stops else None
        return cls(Frame.of(version.common[layout.MASK]), about.rule().by_score, about.stops, basis)

    def reasons(self, part: Part, indices: Sequence[int]) -> Iterator[tuple[int, str]]:
        """Yield who of some neighbours cannot be in the gallery, and why."""
        starts = part.shard.directory.starts[:, sorted(part.shard.kinds).index(layout.ROWS)]
        first, behind = starts[indices[0]], starts[indices[-1] + 1]
        seen = self._seen(part.shard.arrays[layout.ROWS][first:behind])
        for index in indices:
            try:
                entry = part.entry(index)
                layout.enrolled_from(entry, self.frame, self.by_score)
                if seen is not None:
                    hers = seen[starts[index] - first : starts[index + 1] - first]
                    check_sketch(entry, entry.arrays[layout.ROWS], hers, self.stops)
            except HarmonicFaceError as error:
                yield index, str(error)

    def _seen(self, rows: NDArray[np.floating]) -> NDArray[np.float64] | None:
        """Return the products of rows with those of the shared basis, if there is one."""
        if self.basis is None:
            return None
        with np.errstate(all="ignore"):  # infinite rows are refused before anybody looks at these
            return np.asarray(rows.astype(np.float64) @ self.basis.rows[: self.stops[-1]].T)


def _unfit(version: Version, judge: _Judge, lost: set[str], tell: Tell) -> Iterator[Damage]:
    """Yield who is as she was written, but not what a gallery holds."""
    done = 0
    for part in version.parts:
        for _, neighbours in groupby(part.indices.tolist(), lambda index: index // TOGETHER):
            some = list(neighbours)
            for index, reason in judge.reasons(part, some):
                with suppress(HarmonicFaceError):  # who has no key has been told
                    key = part.key(index)
                    if key not in lost:
                        yield Damage(part.listed.record.file, f"{part.shard.path}: {reason}", (key,), len(part))
            done += len(some)
            tell("people looked at", done, len(version))
        part.shard.forget()
