"""Batch: new entries that are written together, collected until they are many bytes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.store.directory import Directory, of_entries
from harmonicface.store.entry import Entry, Kind, checked_entry


@dataclass(frozen=True, eq=False)
class Batch:
    """Checked entries with different keys, at least one.

    Parameters
    ----------
    entries
        In their order.
    """

    entries: Sequence[Entry]

    @property
    def keys(self) -> list[str]:
        """Their keys."""
        return [entry.key for entry in self.entries]

    @property
    def nbytes(self) -> int:
        """Bytes of their arrays."""
        return sum(entry.nbytes for entry in self.entries)

    @cached_property
    def directory(self) -> Directory:
        """Who they are, with checksums of their arrays."""
        return of_entries(self.entries)

    def pieces(self, name: str) -> Iterator[NDArray[Any]]:
        """Yield everybody's rows of an array."""
        for entry in self.entries:
            yield entry.arrays[name]


def batches(entries: Iterable[Entry], kinds: Mapping[str, Kind], nbytes: int) -> Iterator[Batch]:
    """Check entries and yield them in batches of `nbytes` and at most one entry more.

    Raises
    ------
    HarmonicFaceError
        An entry that does not fit, or a key twice in a batch.
    """
    collected: dict[str, Entry] = {}
    total = 0
    for entry in entries:
        checked = checked_entry(entry, kinds)
        if checked.key in collected:
            raise HarmonicFaceError(f"key: expected every one once, got {checked.key!r:.80} twice")
        collected[checked.key] = checked
        total += checked.nbytes
        if total >= nbytes:
            yield Batch(tuple(collected.values()))
            collected, total = {}, 0
    if collected:
        yield Batch(tuple(collected.values()))
