"""Part: one shard as a version sees it, without the entries that are gone, renamed ones by their new keys."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.store.directory import Directory, key_hash
from harmonicface.store.entry import Entry, is_finite
from harmonicface.store.manifest import Listed
from harmonicface.store.shard import PIECE, Shard


@dataclass(frozen=True)
class Damage:
    """What is wrong with one file.

    Parameters
    ----------
    file
        Its name in the folder.
    reason
        What was expected and what is there, one line.
    keys
        The entries that are lost or changed by it; empty if it is none, or if nobody knows any more who was in it.
    entries
        How many entries the file has.
    """

    file: str
    reason: str
    keys: tuple[str, ...]
    entries: int


@dataclass(frozen=True, eq=False)
class Part:
    """A shard in one version.

    Parameters
    ----------
    shard
        The file.
    listed
        What has happened to its entries.
    """

    shard: Shard
    listed: Listed

    def __len__(self) -> int:
        return self.listed.record.entries - len(self.listed.removed)

    @cached_property
    def alive(self) -> NDArray[np.bool_]:
        """(n,) which entries of the shard are in the folder; the arrays hold the rows of the others too.

        Raises
        ------
        HarmonicFaceError
            Both directories of the shard are damaged.
        """
        alive = np.ones(len(self.shard.directory), np.bool_)
        alive[list(self.listed.removed)] = False
        return alive

    @property
    def indices(self) -> NDArray[np.int64]:
        """Which entries of the shard are in the folder, rising."""
        return np.flatnonzero(self.alive).astype(np.int64)

    @property
    def changed(self) -> bool:
        """Whether anything has happened to its entries."""
        return bool(self.listed.removed or self.listed.renamed)

    @cached_property
    def hashes(self) -> NDArray[np.uint64]:
        """(n,) hashes of the keys as they are now."""
        hashes = self.shard.directory.hashes
        if self.listed.renamed:
            hashes = hashes.copy()
            hashes[list(self.listed.renamed)] = [key_hash(key.encode()) for key in self.listed.renamed.values()]
        return hashes

    @cached_property
    def directory(self) -> Directory:
        """Who is in the folder, by their keys of now."""
        if not self.changed:
            return self.shard.directory
        return self.shard.directory.taken(self.indices, dict(self.listed.renamed))

    def key(self, index: int) -> str:
        """Return the key of an entry of the shard."""
        return self.listed.renamed.get(index) or self.shard.directory.key(index)

    @property
    def keys(self) -> list[str]:
        """Return all keys of now."""
        return [self.key(index) for index in self.indices.tolist()]

    def find(self, key: str) -> int | None:
        """Return the index of an entry of the shard by its key, if it is here."""
        for index in np.flatnonzero(self.hashes == np.uint64(key_hash(key.encode()))).tolist():
            if self.alive[index] and self.key(index) == key:
                return int(index)
        return None

    def entry(self, index: int) -> Entry:
        """Return an entry of the shard, its arrays read-only views of the file.

        Raises
        ------
        HarmonicFaceError
            The shard is damaged, or has NaN or infinity there.
        """
        arrays, key = self.shard.entry(index), self.key(index)
        for name, array in arrays.items():
            if not is_finite(array):
                raise HarmonicFaceError(f"{key!r:.80}, {name}: expected finite numbers, got NaN or infinity")
        return Entry(key, arrays, self.shard.directory.about(index))

    def pieces(self, name: str) -> Iterator[NDArray[Any]]:
        """Yield the rows of everybody who is in the folder, contiguous pieces of at most 16 MB."""
        array, column = self.shard.arrays[name], sorted(self.shard.kinds).index(name)
        starts = self.shard.directory.starts[:, column]
        rows = max(1, PIECE // self.shard.kinds[name].row_bytes)
        edges = np.flatnonzero(np.diff(self.alive, prepend=False, append=False))
        read = 0
        for first, behind in starts[edges].reshape(-1, 2).tolist():
            for start in range(first, behind, rows):
                piece = array[start : min(start + rows, behind)]
                yield piece
                read += piece.nbytes
                if read >= PIECE:
                    self.shard.forget()
                    read = 0
        self.shard.forget()

    def damage(self, reason: str) -> Damage:
        """Say that the whole shard is damaged, with everybody in it who is still known."""
        try:
            keys = tuple(self.keys)
        except HarmonicFaceError:
            keys = ()
        return Damage(self.listed.record.file, reason, keys, self.listed.record.entries)
