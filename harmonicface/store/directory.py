"""Directory: who is in a shard, with how many rows and what checksum; columns to look through without a loop."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.store.entry import DIGEST_BYTES, Entry, about_text, digest
from harmonicface.store.tensors import Bytes, packed, views

MULTIPLE = 64  # bytes: what stands behind a directory in a file is aligned
ENTRY_BYTES = 24 + DIGEST_BYTES  # of an entry in a directory, at least: two ends, a hash, a checksum


@dataclass(frozen=True, eq=False)
class Directory:
    """The n entries of a shard, in their order.

    Parameters
    ----------
    keys, abouts
        The UTF-8 of all keys, and of all words about them as JSON, one behind the other.
    key_ends, about_ends
        (n,) where each of them ends.
    counts
        (n, a) rows of every array of every entry; the arrays in the order of their names.
    digests
        (n, 16) checksums of the entries' arrays.
    hashes
        (n,) of the keys, by which they are looked for.
    """

    keys: Bytes
    key_ends: NDArray[np.int64]
    abouts: Bytes
    about_ends: NDArray[np.int64]
    counts: NDArray[np.int64]
    digests: Bytes
    hashes: NDArray[np.uint64]

    def __len__(self) -> int:
        return len(self.key_ends)

    @cached_property
    def starts(self) -> NDArray[np.int64]:
        """(n + 1, a) the first row of every entry in every array, and the number of rows."""
        starts = np.zeros((len(self) + 1, self.counts.shape[1]), np.int64)
        np.cumsum(self.counts, axis=0, out=starts[1:])
        return starts

    def key(self, index: int) -> str:
        """Return the key of one entry.

        Raises
        ------
        HarmonicFaceError
            It is no text.
        """
        try:
            return self._text(self.keys, self.key_ends, index).decode()
        except UnicodeDecodeError:
            raise HarmonicFaceError(f"expected a text as the key of entry {index}, got other bytes") from None

    def about(self, index: int) -> dict[str, Any]:
        """Return the words about one entry.

        Raises
        ------
        HarmonicFaceError
            They are no JSON object.
        """
        try:
            about = json.loads(self._text(self.abouts, self.about_ends, index))
        except (ValueError, RecursionError):
            about = None
        if not isinstance(about, dict):
            raise HarmonicFaceError(f"expected a JSON object about entry {index}, got something else")
        return about

    def taken(self, indices: NDArray[np.int64], names: dict[int, str]) -> Directory:
        """Return some of the entries, a few of them under other names."""
        keys = [names.get(int(i)) or self.key(int(i)) for i in indices]
        abouts = [self._text(self.abouts, self.about_ends, int(i)) for i in indices]
        return _of([key.encode() for key in keys], abouts, self.counts[indices], self.digests[indices])

    def to_bytes(self) -> bytes:
        """Return what `read` reads."""
        return packed(vars_of(self), {}, MULTIPLE)

    def _text(self, texts: Bytes, ends: NDArray[np.int64], index: int) -> bytes:
        begin = int(ends[index - 1]) if index else 0
        return texts[begin : int(ends[index])].tobytes()


def key_hash(key: bytes) -> int:
    """Return the hash by which a key is looked for."""
    return int.from_bytes(hashlib.sha256(key).digest()[:8], "little")


def vars_of(directory: Directory) -> dict[str, NDArray[Any]]:
    """Return the columns by name."""
    return {name: getattr(directory, name) for name in Directory.__dataclass_fields__}


def of_entries(entries: Sequence[Entry]) -> Directory:
    """Return the directory of checked entries."""
    counts = np.array([[len(e.arrays[name]) for name in sorted(e.arrays)] for e in entries], np.int64)
    digests = np.frombuffer(b"".join(digest(e.arrays) for e in entries), np.uint8).reshape(-1, DIGEST_BYTES)
    return _of([e.key.encode() for e in entries], [about_text(e.about) for e in entries], counts, digests)


def joined(parts: Sequence[Directory]) -> Directory:
    """Return several directories as one."""
    if len(parts) == 1:
        return parts[0]
    columns = {name: np.concatenate([getattr(one, name) for one in parts]) for name in Directory.__dataclass_fields__}
    for texts, ends in (("keys", "key_ends"), ("abouts", "about_ends")):
        moved = np.cumsum([0, *(len(getattr(one, texts)) for one in parts[:-1])])
        columns[ends] = np.concatenate([getattr(one, ends) + by for one, by in zip(parts, moved, strict=True)])
    return Directory(**columns)


def read(content: Bytes, entries: int, arrays: int, what: str) -> Directory:
    """Read a directory of so many entries with so many arrays each.

    Raises
    ------
    HarmonicFaceError
        It is damaged or contradicts itself.
    """
    columns = views(content, what)
    columns.pop("padding", None)
    expected = {
        "keys": (np.uint8, None),
        "key_ends": (np.int64, (entries,)),
        "abouts": (np.uint8, None),
        "about_ends": (np.int64, (entries,)),
        "counts": (np.int64, (entries, arrays)),
        "digests": (np.uint8, (entries, DIGEST_BYTES)),
        "hashes": (np.uint64, (entries,)),
    }
    fits = set(columns) == set(expected) and all(
        columns[name].dtype == dtype and (columns[name].ndim == 1 if shape is None else columns[name].shape == shape)
        for name, (dtype, shape) in expected.items()
    )
    if not (fits and _agrees(columns)):
        raise HarmonicFaceError(f"{what}: expected the directory of {entries} entries, got one that is none")
    return Directory(**columns)


def _agrees(columns: dict[str, NDArray[Any]]) -> bool:
    """Tell whether ends rise to the end and counts are counts that no sum of them can overflow."""
    for texts, ends in (("keys", "key_ends"), ("abouts", "about_ends")):
        places, length = columns[ends], len(columns[texts])
        if places.size == 0 or places.min() < 0 or places.max() > length or places[-1] != length:
            return False
        if (np.diff(places) < 0).any():
            return False
    counts = columns["counts"]
    return bool(counts.size == 0 or (counts.min() >= 0 and int(counts.max()) * len(counts) < 2**62))


def _of(keys: list[bytes], abouts: list[bytes], counts: NDArray[np.int64], digests: Bytes) -> Directory:
    """Put a directory together."""
    return Directory(
        np.frombuffer(b"".join(keys), np.uint8),
        np.cumsum([len(key) for key in keys], dtype=np.int64),
        np.frombuffer(b"".join(abouts), np.uint8),
        np.cumsum([len(about) for about in abouts], dtype=np.int64),
        counts,
        digests,
        np.array([key_hash(key) for key in keys], np.uint64),
    )
