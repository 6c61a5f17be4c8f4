"""What one writer does, alone: new files first, then the manifest, then the end of files that it names no more."""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import describe
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.files import alone_in, replacing
from harmonicface.store.batch import Batch
from harmonicface.store.directory import key_hash
from harmonicface.store.entry import about_text, is_finite
from harmonicface.store.manifest import SHARD_NAME, Common, Listed, Manifest, read_manifest, write_manifest
from harmonicface.store.merging import taken_in
from harmonicface.store.part import Part
from harmonicface.store.shard import Source, damaged_entries, write_shard
from harmonicface.store.tensors import MOST_AXES, NAMES, header_length, packed
from harmonicface.store.version import Cache, Version, opened

LONGEST_ABOUT = 1 << 24
PARTIAL = re.compile(r"\.\d{10}\.partial-\w+\.safetensors|\.manifest\.partial-\w+\.json")


class OutdatedError(HarmonicFaceError):
    """What was to be written was made for a version whose own arrays or kinds the folder has no more."""


@contextmanager
def alone(folder: Path, cache: Cache) -> Iterator[Version]:
    """Yield what the folder is while nobody else writes.

    Files that killed writers left are removed first; files that were written in vain, because of a full disk or an
    entry that does not fit, afterwards.
    """
    with alone_in(folder):
        version = opened(folder, cache, leave_out_damaged=True)
        sweep(folder, version.manifest.files)
        try:
            yield version
        except BaseException:
            with suppress(HarmonicFaceError):
                sweep(folder, version.manifest.files | read_manifest(folder).files)
            raise


def commit(folder: Path, manifest: Manifest) -> None:
    """Make a version the folder's, durably; then remove the files that it does not name."""
    write_manifest(folder, replace(manifest, generation=manifest.generation + 1))
    sweep(folder, manifest.files)


def sweep(folder: Path, keep: set[str]) -> None:
    """Remove shards and temporary files that are not the folder's; what others put there is left alone.

    What cannot be removed now, or comes back after a loss of power, is removed by the next writer.
    """
    for one in strays(folder, keep):
        with suppress(OSError):
            one.unlink()


def strays(folder: Path, keep: set[str]) -> list[Path]:
    """Return shards and temporary files that are not the folder's."""
    return [one for one in folder.iterdir() if _is_ours(one.name) and one.name not in keep]


def _is_ours(name: str) -> bool:
    """Tell whether a file is a shard or a writer's temporary file by its name."""
    return bool(SHARD_NAME.fullmatch(name) or PARTIAL.fullmatch(name))


def make_durable(folder: Path) -> None:
    """Make the names in a folder survive a loss of power."""
    if hasattr(os, "O_DIRECTORY"):
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def put(folder: Path, version: Version, batch: Batch) -> None:
    """Write new entries, together with as many of the last shards as `taken_in` says; damaged ones are never copied."""
    parts = version.all_parts
    most = taken_in([part.listed.record.nbytes for part in parts], batch.nbytes)
    count = 0
    while count < most and is_sound(parts[-1 - count]):
        count += 1
    kept = len(parts) - count
    commit(folder, rewritten(folder, version.manifest, range(kept, len(parts)), [*parts[kept:], batch]))


def rewritten(folder: Path, manifest: Manifest, places: range, sources: Sequence[Source]) -> Manifest:
    """Write sources into one new shard, and return the manifest with it in the place of others."""
    record = write_shard(folder / f"{manifest.number:010}.safetensors", manifest.kinds, sources)
    shards = (*manifest.shards[: places.start], Listed(record), *manifest.shards[places.stop :])
    return replace(manifest, shards=shards, number=manifest.number + 1)


def is_sound(part: Part) -> bool:
    """Tell whether all entries that are in the folder are what was written: every byte of them is read."""
    try:
        return not damaged_entries(part.shard, part.indices)
    except HarmonicFaceError:
        return False


def place_of(version: Version, key: str) -> tuple[int, int] | None:
    """Return the number of an entry's shard and its index there; entries of damaged shards are found too."""
    for place, part in enumerate(version.all_parts):
        with suppress(HarmonicFaceError):  # a shard of which nobody knows any more who is in it
            index = part.find(key)
            if index is not None:
                return place, index
    return None


def check_made_for(now: Manifest, made_for: Version | None) -> None:
    """Refuse entries that were made with other arrays of the folder's own than it has now."""
    if made_for is not None and (now.common, now.kinds) != (made_for.manifest.common, made_for.manifest.kinds):
        raise OutdatedError("append: expected entries made with the folder's own arrays, which have changed meanwhile")


def check_new(version: Version, keys: Sequence[str]) -> None:
    """Refuse keys that are in the folder, by one comparison of columns a shard."""
    hashes = np.array([key_hash(key.encode()) for key in keys], np.uint64)
    for part in version.all_parts:
        with suppress(HarmonicFaceError):
            known = np.isin(hashes, part.hashes)
            if known.any():
                taken = [keys[i] for i in np.flatnonzero(known).tolist() if part.find(keys[i]) is not None]
                if taken:
                    break
    else:
        return
    raise HarmonicFaceError(f"key: expected one that is not in the folder yet, got {taken[0]!r:.80}, which is")


def with_common(folder: Path, manifest: Manifest, common: Mapping[str, NDArray[Any]]) -> Manifest:
    """Write a folder's own arrays, and return the manifest with them."""
    for name, array in common.items():
        if not str(name).isidentifier() or name == "padding":
            raise HarmonicFaceError(f"common: expected names of arrays, got {str(name)!r:.80}")
        kept = isinstance(array, np.ndarray) and array.dtype in NAMES and array.ndim <= MOST_AXES
        if not kept or not is_finite(array):
            raise HarmonicFaceError(f"common, {name}: expected an array of finite numbers, got {describe(array)}")
    if not common:
        return replace(manifest, common=None)
    content = packed(common, {"format": "harmonicface common", "version": "1"})
    file = f"{manifest.number:010}.safetensors"
    with replacing(folder / file) as temporary:
        temporary.write_bytes(content)
    head = content[: header_length(np.frombuffer(content, np.uint8), file)]
    said = Common(file, len(content), hashlib.sha256(content).hexdigest(), hashlib.sha256(head).hexdigest())
    return replace(manifest, common=said, number=manifest.number + 1)


def described(
    folder: Path, manifest: Manifest, about: Mapping[str, Any] | None, common: Mapping[str, NDArray[Any]] | None
) -> Manifest:
    """Return a manifest with other words or other arrays of the folder's own, which are written."""
    if about is not None:
        manifest = replace(manifest, about=checked_about(about))
    return manifest if common is None else with_common(folder, manifest, common)


def checked_about(about: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is said of a folder as it will be read."""
    return dict(json.loads(about_text(about, LONGEST_ABOUT)))
