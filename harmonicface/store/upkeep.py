"""Upkeep: what is done to a folder of entries as a whole: compact, revise, verify, discard what is damaged."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.store import compaction, writing
from harmonicface.store.batch import batches
from harmonicface.store.entry import Entry, Kind, check_kinds
from harmonicface.store.part import Damage
from harmonicface.store.verification import damages
from harmonicface.store.version import Cache, opened

SHARD_BYTES = 1 << 28  # of arrays that are written at once


class Upkeep:
    """A folder of entries as a whole.

    Parameters
    ----------
    path
        The folder.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._cache: Cache = {}

    def compact(self, shard_bytes: int = SHARD_BYTES) -> int:
        """Write shards again that have lost entries or are small; what was removed or renamed is in no file any more.

        Readers of older versions keep the old files until they let go of them. Other writers wait. It needs free
        space for one shard; a process that is killed has compacted some of them.

        Parameters
        ----------
        shard_bytes
            Neighbours are joined up to so many bytes; those that have lost nobody and are half as large stay.

        Returns
        -------
        int
            How many bytes less the files take.

        Raises
        ------
        HarmonicFaceError
            A damaged shard, before anything is written; or a full disk.
        """
        _validate.at_least(shard_bytes, 1, "shard_bytes")
        with writing.alone(self.path, self._cache) as version:
            return compaction.compact(self.path, self._cache, version, shard_bytes)

    def revise(
        self,
        change: Callable[[Entry], Entry],
        kinds: Mapping[str, Kind] | None = None,
        about: Mapping[str, Any] | None = None,
        common: Mapping[str, NDArray[Any]] | None = None,
        shard_bytes: int = SHARD_BYTES,
    ) -> None:
        """Write all entries anew with other arrays or words, and switch to them at once: all or nothing.

        Other writers wait. It needs as much free space as the folder takes; a process that is killed has done nothing.

        Parameters
        ----------
        change
            Makes of every entry what it will be, under the same key.
        kinds, about, common
            As of `create`; what is not given stays.
        shard_bytes
            As of `append`.

        Raises
        ------
        HarmonicFaceError
            A damaged shard, an entry that does not fit, or a full disk.
        """
        _validate.at_least(shard_bytes, 1, "shard_bytes")
        if kinds is not None:
            check_kinds(kinds)
        with writing.alone(self.path, self._cache) as version:
            manifest = writing.described(self.path, version.manifest, about, common)
            manifest = replace(manifest, kinds=dict(kinds or manifest.kinds), shards=())
            compaction.revise(self.path, version, manifest, change, shard_bytes)

    def replace(
        self,
        entries: Iterable[Entry],
        kinds: Mapping[str, Kind],
        about: Mapping[str, Any],
        common: Mapping[str, NDArray[Any]],
        shard_bytes: int = SHARD_BYTES,
    ) -> None:
        """Put other entries in the place of all, and switch to them at once: all or nothing.

        Other writers wait. It needs free space for the new entries; a process that is killed has done nothing.

        Parameters
        ----------
        entries
            With different keys.
        kinds, about, common, shard_bytes
            As of `create`, and of `append`.

        Raises
        ------
        HarmonicFaceError
            An entry that does not fit, a key twice, or a full disk.
        """
        _validate.at_least(shard_bytes, 1, "shard_bytes")
        check_kinds(kinds)
        with writing.alone(self.path, self._cache) as version:
            manifest = writing.described(self.path, version.manifest, about, common)
            manifest = replace(manifest, kinds=dict(kinds), shards=())
            keys: set[str] = set()
            for batch in batches(entries, kinds, shard_bytes):
                again = keys.intersection(batch.keys)
                if again:
                    raise HarmonicFaceError(f"key: expected every one once, got {again.pop()!r:.80} twice")
                keys.update(batch.keys)
                manifest = writing.rewritten(
                    self.path, manifest, range(len(manifest.shards), len(manifest.shards)), [batch]
                )
            writing.commit(self.path, manifest)

    def discard_damaged(self) -> tuple[Damage, ...]:
        """Remove the entries that are not what was written, and shards that cannot be opened with everybody in them.

        The damaged bytes stay in their files until `compact`, and `verify` tells of them without anybody's key.

        Returns
        -------
        tuple
            What `verify` says of the folder before.

        Raises
        ------
        HarmonicFaceError
            A damaged manifest.
        """
        with writing.alone(self.path, {}) as version:  # the files as they are, not as they were mapped before
            found = damages(version)
            if found:
                shards = compaction.without_damaged(version)
                writing.commit(self.path, replace(version.manifest, shards=shards))
            return found

    def verify(self) -> tuple[Damage, ...]:
        """Read every byte and compare it with its checksum; nothing is changed.

        Returns
        -------
        tuple
            What is damaged, with the entries in it; empty if all is well.

        Raises
        ------
        HarmonicFaceError
            A damaged manifest.
        """
        return damages(opened(self.path, {}, leave_out_damaged=True))
