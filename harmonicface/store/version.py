"""Version: a folder as it was at one moment; it stays what it is whatever writers do."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.store.entry import Entry, Kind, checked_key
from harmonicface.store.manifest import Common, Manifest, read_manifest
from harmonicface.store.part import Damage, Part
from harmonicface.store.plain_file import NotOpenedError, mapped, read_through
from harmonicface.store.shard import Record, Shard
from harmonicface.store.tensors import checksum, header_length, views

Cache = dict[Record, Shard]


class Version:
    """The entries of a folder at one moment, in the order of their coming.

    Opening one reads the manifest and maps the shards; files that writers remove later stay mapped. It is made by
    `ArrayFolder.version`.

    Parameters
    ----------
    manifest
        What is in the folder.
    parts
        Its shards.
    common
        Maps the file of the folder's own arrays; called at once.
    leave_out_damaged
        Whether damaged shards are left out and told in `damaged`; otherwise they are refused.

    Raises
    ------
    HarmonicFaceError
        A damaged shard.
    """

    def __init__(
        self, manifest: Manifest, parts: tuple[Part, ...], common: CommonArrays | None, leave_out_damaged: bool
    ) -> None:
        self.manifest = manifest
        self.all_parts = parts
        self._common = common
        faults = [fault_of(part, leave_out_damaged) for part in parts]
        self.damaged: tuple[Damage, ...] = tuple(fault for fault in faults if fault)
        if self.damaged and not leave_out_damaged:
            raise HarmonicFaceError(self.damaged[0].reason)
        self.parts: tuple[Part, ...] = tuple(p for p, fault in zip(parts, faults, strict=True) if not fault)

    def __len__(self) -> int:
        return sum(len(part) for part in self.parts)

    def __contains__(self, key: object) -> bool:
        return isinstance(key, str) and self.place(key) is not None

    @property
    def generation(self) -> int:
        """How often the folder had changed."""
        return self.manifest.generation

    @property
    def kinds(self) -> Mapping[str, Kind]:
        """What the entries' arrays are."""
        return self.manifest.kinds

    @property
    def about(self) -> dict[str, Any]:
        """What the owner of the folder says of it."""
        return dict(self.manifest.about)

    @property
    def common(self) -> Mapping[str, NDArray[Any]]:
        """The folder's own arrays, mapped: read-only.

        Raises
        ------
        HarmonicFaceError
            Their file is damaged.
        """
        return {} if self._common is None else self._common.arrays

    @property
    def nbytes(self) -> int:
        """Bytes of all files but the manifest, those of removed entries among them until `compact`."""
        common = self.manifest.common
        return sum(one.record.nbytes for one in self.manifest.shards) + (common.nbytes if common else 0)

    @cached_property
    def keys(self) -> tuple[str, ...]:
        """All keys, in the order of the entries; reads the directories."""
        return tuple(key for part in self.parts for key in part.keys)

    def entries(self) -> Iterator[Entry]:
        """Yield all entries in their order; what was read is given back to the system shard by shard."""
        for part in self.parts:
            for index in part.indices.tolist():
                yield part.entry(index)
            part.shard.forget()

    def entry(self, key: str) -> Entry:
        """Return an entry, its arrays views of the file: read-only.

        Raises
        ------
        HarmonicFaceError
            Nobody of that key, or a damaged one.
        """
        found = self.place(checked_key(key))
        if found is None:
            raise HarmonicFaceError(f"key: expected one that is in the folder, got {key!r:.80}, which is not")
        part, index = found
        return part.entry(index)

    def place(self, key: str) -> tuple[Part, int] | None:
        """Return the part in which an entry is, and its index there."""
        for part in self.parts:
            index = part.find(key)
            if index is not None:
                return part, index
        return None

    def common_damage(self) -> Damage | None:
        """Read the folder's own arrays and say what is wrong with them."""
        return None if self._common is None else self._common.damage()


class CommonArrays:
    """The file of a folder's own arrays, mapped.

    Parameters
    ----------
    path
        The file.
    said
        What the manifest says of it.
    """

    def __init__(self, path: Path, said: Common) -> None:
        self.path, self._said = path, said
        self.fault: str | None = None
        self._arrays: dict[str, NDArray[Any]] = {}
        try:
            _, self._content = mapped(path)
            if len(self._content) != said.nbytes:
                raise HarmonicFaceError(f"{path}: expected {said.nbytes} bytes, got {len(self._content)}")
            length = header_length(self._content, str(path))
            if checksum(self._content[:length]) != said.header:
                raise HarmonicFaceError(f"{path}: expected the header it was written with, got one that was changed")
            self._arrays = views(self._content, str(path))
            self._arrays.pop("padding", None)
        except NotOpenedError:
            raise
        except HarmonicFaceError as error:
            self.fault = str(error)

    @property
    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """The arrays, read-only; raises if the file is damaged."""
        if self.fault is not None:
            raise HarmonicFaceError(self.fault)
        return self._arrays

    def damage(self) -> Damage | None:
        """Read all of it and say what is wrong."""
        fault = self.fault
        try:
            read_through(self.path)
        except HarmonicFaceError as error:
            fault = str(error)
        if fault is None and checksum(self._content) != self._said.digest:
            fault = f"{self.path}: expected the checksum it was written with, got another"
        return None if fault is None else Damage(self._said.file, fault, (), 0)


def fault_of(part: Part, with_directory: bool) -> Damage | None:
    """Say what is wrong with a shard as far as its header tells, and if asked its directory."""
    if part.shard.fault is not None:
        return part.damage(part.shard.fault)
    if with_directory:
        try:
            len(part.shard.directory)
        except HarmonicFaceError as error:
            return part.damage(str(error))
    return None


def opened(folder: Path, cache: Cache, leave_out_damaged: bool = False) -> Version:
    """Open what a folder is now; a writer who replaces files meanwhile makes it look again.

    Parameters
    ----------
    folder
        The folder.
    cache
        Shards that are mapped already; it is made to hold those of this version and no others.
    leave_out_damaged
        As of `Version`.

    Raises
    ------
    HarmonicFaceError
        No manifest, a damaged one, or damaged shards.
    """
    while True:
        manifest = read_manifest(folder)
        shards = [_shard(folder, one.record, manifest.kinds, cache) for one in manifest.shards]
        common = CommonArrays(folder / manifest.common.file, manifest.common) if manifest.common else None
        faulty = any(shard.fault for shard in shards) or (common is not None and common.fault is not None)
        if faulty and read_manifest(folder) != manifest:
            continue  # the files that were missing have been replaced by others
        cache.clear()
        cache.update({shard.record: shard for shard in shards if shard.fault is None})
        parts = tuple(Part(shard, one) for shard, one in zip(shards, manifest.shards, strict=True))
        return Version(manifest, parts, common, leave_out_damaged)


def _shard(folder: Path, record: Record, kinds: Mapping[str, Kind], cache: Cache) -> Shard:
    """Return a shard, mapped before or now."""
    known = cache.get(record)
    if known is not None and known.kinds == kinds:
        return known
    return Shard(folder / record.file, record, kinds)
