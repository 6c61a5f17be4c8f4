"""Manifest: the small file that says which shards are the folder now, and who in them has been removed or renamed.

Two lines of JSON: what is in the folder, and the checksum of the first line. It is replaced whole; what it does not
name is not in the folder.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.files import replacing
from harmonicface.store.directory import ENTRY_BYTES
from harmonicface.store.entry import Kind, checked_key
from harmonicface.store.plain_file import plain_file
from harmonicface.store.shard import Record
from harmonicface.store.tensors import NAMES, TYPES

NAME = "manifest.json"
FORMAT, VERSION = "harmonicface store", 1
LONGEST = 1 << 28
SHARD_NAME = re.compile(r"\d{10}\.safetensors")
CHECKSUM = re.compile(r"[0-9a-f]{64}")


@dataclass(frozen=True)
class Listed:
    """A shard in the folder, and what has happened to its entries since it was written.

    Parameters
    ----------
    record
        The file.
    removed
        Indices of entries that are gone, rising.
    renamed
        New keys by index.
    """

    record: Record
    removed: tuple[int, ...] = ()
    renamed: Mapping[int, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Common:
    """A file with the folder's own arrays.

    Parameters
    ----------
    file, nbytes
        Its name and length.
    digest
        The checksum of all of it.
    header
        The checksum of its header.
    """

    file: str
    nbytes: int
    digest: str
    header: str


@dataclass(frozen=True)
class Manifest:
    """One version of a folder.

    Parameters
    ----------
    kinds
        Of the entries' arrays.
    about
        What the owner of the folder says of it.
    common
        The folder's own arrays, if it has some.
    shards
        In the order of their entries.
    generation
        How often the folder has changed.
    number
        Of the next file: no name is ever used twice.
    """

    kinds: Mapping[str, Kind]
    about: Mapping[str, Any]
    common: Common | None = None
    shards: tuple[Listed, ...] = ()
    generation: int = 0
    number: int = 0

    @property
    def files(self) -> set[str]:
        """The names of all files that it speaks of."""
        return {one.record.file for one in self.shards} | ({self.common.file} if self.common else set())


def write_manifest(folder: Path, manifest: Manifest) -> None:
    """Make a version the folder's; when this returns, it survives a loss of power.

    Raises
    ------
    HarmonicFaceError
        The file cannot be written.
    """
    content = {
        "format": FORMAT,
        "version": VERSION,
        "generation": manifest.generation,
        "number": manifest.number,
        "about": dict(manifest.about),
        "kinds": {name: {"dtype": NAMES[k.dtype], "shape": list(k.shape)} for name, k in manifest.kinds.items()},
        "common": asdict(manifest.common) if manifest.common else None,
        "shards": [
            {**vars(one.record), "removed": list(one.removed), "renamed": [list(p) for p in one.renamed.items()]}
            for one in manifest.shards
        ],
    }
    line = json.dumps(content, separators=(",", ":")).encode()
    with replacing(folder / NAME) as temporary:
        temporary.write_bytes(line + b'\n{"sha256":"' + hashlib.sha256(line).hexdigest().encode() + b'"}\n')


def read_manifest(folder: Path) -> Manifest:
    """Read what the folder is now.

    Raises
    ------
    HarmonicFaceError
        There is none, it is damaged, from another version of the package, or speaks of what cannot be.
    """
    path = folder / NAME
    line = _checked_line(path)
    try:
        content = json.loads(line)
        if content["format"] != FORMAT:
            raise HarmonicFaceError(f"{path}: expected a {FORMAT}, got {content['format']!r:.80}")
        if content["version"] != VERSION:
            raise HarmonicFaceError(f"{path}: expected version {VERSION} of the format, got {content['version']!r:.40}")
        return _manifest(content)
    except (KeyError, TypeError, ValueError, AttributeError, RecursionError) as error:
        if isinstance(error, HarmonicFaceError):
            raise
        raise HarmonicFaceError(f"{path}: expected a manifest that agrees with itself, got one that does not") from None


def _checked_line(path: Path) -> bytes:
    """Return the first line, which the checksum in the second agrees with."""
    try:
        with plain_file(path) as (handle, length):
            if length > LONGEST:
                raise HarmonicFaceError(f"{path}: expected a file of at most {LONGEST} bytes, got {length}")
            with open(handle, "rb", closefd=False) as stream:
                content = stream.read(LONGEST + 1)
    except (OSError, ValueError) as error:
        if isinstance(error, HarmonicFaceError):
            raise
        reason = getattr(error, "strerror", None) or str(error)
        raise HarmonicFaceError(f"expected a {FORMAT} at {str(path.parent)!s:.300}, got none: {reason}") from None
    line, _, rest = content.partition(b"\n")
    if rest != b'{"sha256":"' + hashlib.sha256(line).hexdigest().encode() + b'"}\n':
        raise HarmonicFaceError(f"{path}: expected the checksum it was written with, got a file that was changed")
    return line


def _manifest(content: dict[str, Any]) -> Manifest:
    """Put a manifest together; what cannot be raises."""
    kinds = {str(name): _kind(one) for name, one in content["kinds"].items()}
    shards = tuple(_listed(one) for one in content["shards"])
    common = content["common"] and Common(
        _file(content["common"]["file"]),
        _count(content["common"]["nbytes"]),
        _checksum(content["common"]["digest"]),
        _checksum(content["common"]["header"]),
    )
    manifest = Manifest(
        kinds, dict(content["about"]), common, shards, _count(content["generation"]), _count(content["number"])
    )
    if not kinds or len(manifest.files) != len(shards) + (common is not None):
        raise ValueError("no arrays, or a file twice")
    if any(int(file[:10]) >= manifest.number for file in manifest.files):
        raise ValueError("a file of a number that is not given yet")
    return manifest


def _listed(one: dict[str, Any]) -> Listed:
    """Return a shard's line."""
    record = Record(
        _file(one["file"]),
        _count(one["nbytes"]),
        _count(one["entries"]),
        _checksum(one["header"]),
        _count(one["directory_start"]),
        _count(one["directory_bytes"]),
        _checksum(one["directory"]),
    )

    removed = tuple(_count(index) for index in one["removed"])
    renamed = {_count(index): checked_key(key) for index, key in one["renamed"]}
    rises = bool(np.all(np.diff(removed) > 0)) if removed else True
    if record.nbytes < 8 or record.entries < 1:
        raise ValueError("an empty shard")
    if record.entries * ENTRY_BYTES > record.directory_bytes:
        raise ValueError("more entries than a directory of so many bytes has")
    inside = max((*removed, *renamed, 0)) < record.entries
    if not (rises and inside) or record.directory_start + 2 * record.directory_bytes > record.nbytes:
        raise ValueError("entries or a directory outside the shard")
    if len(renamed) != len(one["renamed"]) or set(renamed) & set(removed):
        raise ValueError("an entry renamed twice, or one that is gone")
    return Listed(record, removed, renamed)


def _kind(one: dict[str, Any]) -> Kind:
    """Return the kind of an array."""
    return Kind(TYPES[one["dtype"]], tuple(one["shape"]))


def _count(value: Any) -> int:
    """Return a count."""
    if type(value) is not int or not 0 <= value < 2**62:
        raise ValueError("no count")
    return value


def _file(value: Any) -> str:
    """Return the name of a file in the folder, of the form that shards have: never a path."""
    if not isinstance(value, str) or not SHARD_NAME.fullmatch(value):
        raise HarmonicFaceError(f"manifest: expected files in its own folder, got {str(value)!r:.80}")
    return value


def _checksum(value: Any) -> str:
    """Return a checksum."""
    if not isinstance(value, str) or not CHECKSUM.fullmatch(value):
        raise ValueError("no checksum")
    return value
