"""Compaction: shards are written again without what was removed, or altogether with other arrays."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path

from harmonicface._validate import describe
from harmonicface.errors import HarmonicFaceError
from harmonicface.store.batch import batches
from harmonicface.store.entry import Entry
from harmonicface.store.manifest import Listed, Manifest
from harmonicface.store.part import Part
from harmonicface.store.shard import damaged_entries
from harmonicface.store.tensors import checksum
from harmonicface.store.version import Cache, Version, opened
from harmonicface.store.writing import commit, is_sound, make_durable, rewritten, strays


def compact(folder: Path, cache: Cache, version: Version, shard_bytes: int) -> int:
    """Write again what has to be, one new shard and one manifest at a time; return how many bytes less it takes."""
    before = version.nbytes
    planned = groups(version, shard_bytes)
    refuse_damaged("compact", (part for group in planned for part in group))
    for group in planned:
        files = [one.record.file for one in version.manifest.shards]
        first = files.index(group[0].listed.record.file)
        places = range(first, first + len(group))
        commit(folder, rewritten(folder, version.manifest, places, group))
        version = opened(folder, cache, leave_out_damaged=True)
    for one in strays(folder, version.manifest.files):
        raise HarmonicFaceError(f"compact: expected to remove {one}, which nobody is in any more, and could not")
    make_durable(folder)  # what was removed does not come back after a loss of power
    return before - version.nbytes


def revise(folder: Path, version: Version, new: Manifest, change: Callable[[Entry], Entry], shard_bytes: int) -> None:
    """Write all entries anew as `change` makes them, for a manifest that has no shards yet, and switch at once."""
    refuse_damaged("revise", version.all_parts)
    for batch in batches(_changed(version, change), new.kinds, shard_bytes):
        new = rewritten(folder, new, range(len(new.shards), len(new.shards)), [batch])
    commit(folder, new)


def refuse_damaged(what: str, parts: Iterable[Part]) -> None:
    """Refuse to write again what is not what was written."""
    for part in parts:
        if not is_sound(part):
            raise HarmonicFaceError(
                f"{what}: expected shards without damage, got {part.listed.record.file}: see `verify`"
            )


def _changed(version: Version, change: Callable[[Entry], Entry]) -> Iterator[Entry]:
    """Yield the entries as they will be, each by its key."""
    for entry in version.entries():
        changed = change(entry)
        if not isinstance(changed, Entry) or changed.key != entry.key:
            raise HarmonicFaceError(f"change: expected an Entry of key {entry.key!r:.80}, got {describe(changed)}")
        yield changed


def groups(version: Version, shard_bytes: int) -> list[list[Part]]:
    """Return neighbouring shards that become one: up to so many bytes, or a single one that has changed."""
    found: list[list[Part]] = [[]]
    total = 0.0
    for part in version.all_parts:
        record = part.listed.record
        left = record.nbytes * len(part) / record.entries
        if not _to_be_written(part) and record.nbytes >= shard_bytes / 2:
            found, total = [*found, []], 0.0
            continue
        if found[-1] and total + left > shard_bytes:
            found, total = [*found, []], 0.0
        found[-1].append(part)
        total += left
    return [group for group in found if len(group) > 1 or any(_to_be_written(part) for part in group)]


def without_damaged(version: Version) -> tuple[Listed, ...]:
    """Return the shards without entries that are not what was written, and without those that cannot be opened."""
    return tuple(one for one in map(_undamaged, version.all_parts) if one is not None)


def _undamaged(part: Part) -> Listed | None:
    """Return a shard's line with its damaged entries removed; None if nothing is left."""
    try:
        bad = set(damaged_entries(part.shard, part.indices))
        for index in part.indices.tolist():
            part.key(index), part.shard.directory.about(index)
    except HarmonicFaceError:
        return None
    if len(bad) == len(part):
        return None
    if not bad:
        return part.listed
    renamed = {index: key for index, key in part.listed.renamed.items() if index not in bad}
    return replace(part.listed, removed=tuple(sorted({*part.listed.removed, *bad})), renamed=renamed)


def _to_be_written(part: Part) -> bool:
    """Tell whether a shard has lost or renamed entries, or one of its directories is damaged."""
    said = part.listed.record.directory
    return part.changed or any(checksum(copy) != said for copy in part.shard.directory_copies())
