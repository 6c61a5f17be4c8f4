"""Verification: every byte of a version against its checksums; what is damaged, and who is in it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from harmonicface.errors import HarmonicFaceError
from harmonicface.store.part import Damage, Part
from harmonicface.store.plain_file import read_through
from harmonicface.store.shard import damaged_entries
from harmonicface.store.tensors import checksum
from harmonicface.store.version import Version

Tell = Callable[[str, int, int], None]


def damages(version: Version, tell: Tell = lambda *_: None) -> tuple[Damage, ...]:
    """Read everything and say what is damaged; memory: a shard's directory and 16 MB.

    Parameters
    ----------
    version
        Opened with `leave_out_damaged`, so that shards that cannot be opened are told too.
    tell
        Is called with what has been read, how many of them, and of how many.
    """
    found = [version.common_damage()]
    for number, part in enumerate(version.all_parts):
        found.append(damage_in(part))
        tell("shards read", number + 1, len(version.all_parts))
    return tuple(one for one in (*found, *_twice(version)) if one is not None)


def damage_in(part: Part) -> Damage | None:
    """Say what is wrong with a shard: of the entries those whose own bytes are not what was written."""
    shard, record = part.shard, part.listed.record
    if shard.fault is not None:
        return part.damage(shard.fault)
    try:
        read_through(shard.path)
        bad = damaged_entries(shard, np.arange(len(shard.directory), dtype=np.int64))
        keys = tuple(part.key(index) for index in bad if part.alive[index])
        for index in part.indices.tolist():
            part.key(index), part.shard.directory.about(index)
    except HarmonicFaceError as error:
        return part.damage(f"{shard.path}: {error}" if str(shard.path) not in str(error) else str(error))
    if bad:
        reason = f"{shard.path}: expected finite arrays with the checksums they had, got {len(bad)} others"
        return Damage(record.file, reason, keys, record.entries)
    if any(checksum(copy) != record.directory for copy in shard.directory_copies()):
        reason = f"{shard.path}: expected two equal directories, got one of them changed"
        return Damage(record.file, reason, (), record.entries)
    return None


def _twice(version: Version) -> list[Damage]:
    """Say whether a key is in the folder twice, which no writer does."""
    parts = [part for part in version.parts if len(part)]
    if not parts:
        return []
    hashes = np.concatenate([part.hashes[part.alive] for part in parts])
    values, counts = np.unique(hashes, return_counts=True)
    again = set(values[counts > 1].tolist())
    seen: set[str] = set()
    found = []
    for part in parts if again else []:
        for index in part.indices.tolist():
            if int(part.hashes[index]) in again:
                key = part.key(index)
                if key in seen:
                    reason = f"{part.shard.path}: expected keys once, got {key!r:.80} again"
                    found.append(Damage(part.listed.record.file, reason, (key,), part.listed.record.entries))
                seen.add(key)
    return found
