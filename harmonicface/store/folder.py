"""ArrayFolder: entries of named arrays in a folder of immutable shards; many readers, one writer at a time."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.files import alone_in
from harmonicface.store import writing
from harmonicface.store.batch import batches
from harmonicface.store.entry import Entry, Kind, check_kinds, checked_key
from harmonicface.store.manifest import Listed, Manifest, read_manifest, write_manifest
from harmonicface.store.upkeep import SHARD_BYTES, Upkeep
from harmonicface.store.version import Version, opened


class ArrayFolder(Upkeep):
    """A folder that keeps entries: each a key, a few words, and named arrays with its own number of rows.

    What a method has done is on the disk when it returns and survives a killed process and a loss of power; what it
    has not finished is not there. Writers wait for each other, by a lock of the system on the folder that a dead
    process cannot hold. Readers wait for nobody: a `Version` stays what it was when it was opened. Local POSIX file
    systems only.

    Parameters
    ----------
    path
        A folder made by `ArrayFolder.create`.

    Raises
    ------
    HarmonicFaceError
        No such folder, or its manifest is damaged or of another version.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np
    >>> place = tempfile.TemporaryDirectory()
    >>> folder = ArrayFolder.create(place.name + "/people", {"rows": Kind(np.dtype(np.float32), (4,))})
    >>> folder.append([Entry("ada", {"rows": np.eye(3, 4, dtype=np.float32)}, {"source": "photographs"})])
    1
    >>> version = folder.version()
    >>> folder.rename("ada", "Ada Lovelace")
    >>> version.keys, folder.version().keys
    (('ada',), ('Ada Lovelace',))
    >>> folder.version().entry("Ada Lovelace").arrays["rows"].shape
    (3, 4)
    >>> place.cleanup()
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        super().__init__(Path(path))
        read_manifest(self.path)

    @classmethod
    def create(
        cls,
        path: str | os.PathLike[str],
        kinds: Mapping[str, Kind],
        about: Mapping[str, Any] | None = None,
        common: Mapping[str, NDArray[Any]] | None = None,
    ) -> ArrayFolder:
        """Make a folder.

        Parameters
        ----------
        path
            A new or empty folder, in one that is there.
        kinds
            What the entries' arrays are, by name; at least one.
        about
            What JSON can say of the folder, at most 16 MiB.
        common
            The folder's own arrays by name.

        Raises
        ------
        HarmonicFaceError
            Something is there already, it cannot be made, or what is given cannot be kept.
        """
        folder = Path(path)
        check_kinds(kinds)
        manifest = Manifest(dict(kinds), writing.checked_about(about or {}))
        try:
            folder.mkdir(exist_ok=True)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise HarmonicFaceError(f"cannot make the folder {path!s:.300}: {reason}") from None
        with alone_in(folder):
            if any(not writing.PARTIAL.fullmatch(one.name) for one in folder.iterdir()):
                raise HarmonicFaceError(f"create: expected a new or an empty folder, got {path!s:.300} with files")
            writing.sweep(folder, set())
            write_manifest(folder, writing.with_common(folder, manifest, common or {}))
        writing.make_durable(folder.resolve().parent)
        return cls(folder)

    def version(self, leave_out_damaged: bool = False) -> Version:
        """Open the folder as it is now: the manifest is read and the shards are mapped, no more.

        Parameters
        ----------
        leave_out_damaged
            Whether shards that cannot be opened are left out, told in `Version.damaged`; otherwise they are refused.

        Raises
        ------
        HarmonicFaceError
            A damaged manifest or shard.
        """
        return opened(self.path, self._cache, leave_out_damaged)

    def append(self, entries: Iterable[Entry], shard_bytes: int = SHARD_BYTES, made_for: Version | None = None) -> int:
        """Add entries behind the others.

        They are written by the piece of `shard_bytes`, so that memory does not grow with their number; a writer who is
        killed leaves whole pieces. Others may write between two pieces.

        Parameters
        ----------
        entries
            Of the folder's kinds, with new keys, finite.
        shard_bytes
            How many bytes of arrays are collected before they are written, at least 1.
        made_for
            Entries that were made with the folder's own arrays say with which: those of this version.

        Returns
        -------
        int
            How many they were.

        Raises
        ------
        HarmonicFaceError
            An entry that does not fit, whose piece is not written, or a full disk.
        OutdatedError
            The folder has other arrays of its own, or other kinds, than that version.
        """
        count, manifest = 0, read_manifest(self.path)
        writing.check_made_for(manifest, made_for)
        for batch in batches(entries, manifest.kinds, _validate.at_least(shard_bytes, 1, "shard_bytes")):
            with writing.alone(self.path, self._cache) as version:
                writing.check_made_for(version.manifest, made_for)
                writing.check_new(version, batch.keys)
                writing.put(self.path, version, batch)
            count += len(batch.entries)
            del batch  # before the next one is collected
        return count

    def remove(self, keys: str | Iterable[str]) -> None:
        """Take entries out, all or none. Their bytes stay in the files until `compact`.

        Raises
        ------
        HarmonicFaceError
            Nobody of such a key, or the same twice.
        """
        wanted = [checked_key(key) for key in ([keys] if isinstance(keys, str) else keys)]
        with writing.alone(self.path, self._cache) as version:
            gone: dict[int, set[int]] = {}
            for key in wanted:
                place, index = _place(version, key)
                if index in gone.setdefault(place, set()):
                    raise HarmonicFaceError(f"remove: expected every key once, got {key!r:.80} twice")
                gone[place].add(index)
            shards = list(version.manifest.shards)
            for place, indices in gone.items():
                one = shards[place]
                renamed = {index: key for index, key in one.renamed.items() if index not in indices}
                shards[place] = Listed(one.record, tuple(sorted({*one.removed, *indices})), renamed)
            left = tuple(one for one in shards if len(one.removed) < one.record.entries)
            if wanted:
                writing.commit(self.path, replace(version.manifest, shards=left))

    def rename(self, old: str, new: str) -> None:
        """Give an entry another key.

        Raises
        ------
        HarmonicFaceError
            Nobody of the old key, somebody of the new one.
        """
        checked_key(old)
        with writing.alone(self.path, self._cache) as version:
            place, index = _place(version, old)
            if checked_key(new) == old:
                return
            writing.check_new(version, [new])
            shards = list(version.manifest.shards)
            one = shards[place]
            shards[place] = Listed(one.record, one.removed, {**one.renamed, index: new})
            writing.commit(self.path, replace(version.manifest, shards=tuple(shards)))

    def describe(
        self, about: Mapping[str, Any] | None = None, common: Mapping[str, NDArray[Any]] | None = None
    ) -> None:
        """Replace what is said of the folder, its own arrays, or both at once.

        Raises
        ------
        HarmonicFaceError
            What cannot be kept.
        """
        with writing.alone(self.path, self._cache) as version:
            writing.commit(self.path, writing.described(self.path, version.manifest, about, common))


def _place(version: Version, key: str) -> tuple[int, int]:
    """Return the number of an entry's shard and its index there; raises if nobody has that key."""
    found = writing.place_of(version, key)
    if found is None:
        raise HarmonicFaceError(f"key: expected one that is in the folder, got {key!r:.80}, which is not")
    return found
