"""Shard: one immutable file of many entries' arrays, each array in one piece, mapped into memory when it is opened.

In the file, a safetensors one: the directory, the arrays (wide types first), the directory again. A directory that is
damaged has a copy at the other end of the file, so that whoever is in a damaged shard can be named.
"""

from __future__ import annotations

import hashlib
import mmap
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.files import replacing
from harmonicface.store.directory import MULTIPLE, Directory, joined, read
from harmonicface.store.entry import Kind, digest, is_finite
from harmonicface.store.plain_file import NotOpenedError, mapped
from harmonicface.store.tensors import TYPES, Bytes, Tensor, checksum, header, header_length, views

FIRST, SECOND = "directory", "directory again"
ARRAY = "entries."  # before the names of the entries' arrays
PIECE = 1 << 24  # bytes written at once


@dataclass(frozen=True)
class Record:
    """What a manifest says of a file, enough to notice another one in its place.

    Parameters
    ----------
    file
        Its name in the folder.
    nbytes
        Its length.
    entries
        How many are in it.
    header
        Checksum of its header, which is compared whenever it is opened.
    directory_start, directory_bytes, directory
        Where its directory is, and the checksum of it.
    """

    file: str
    nbytes: int
    entries: int
    header: str
    directory_start: int
    directory_bytes: int
    directory: str


class Source(Protocol):
    """Entries to be written: who they are, and the pieces of each array in their order."""

    @property
    def directory(self) -> Directory:
        """Who they are."""
        ...

    def pieces(self, name: str) -> Iterator[NDArray[Any]]:
        """Yield the rows of an array, contiguous pieces."""
        ...


class Shard:
    """One file, mapped; what is wrong with it is kept in `fault` until somebody asks for its arrays.

    Parameters
    ----------
    path
        The file.
    record
        What the manifest says of it.
    kinds
        What the arrays must be.

    Raises
    ------
    NotOpenedError
        The system refuses to open the file, which may be whole.
    """

    def __init__(self, path: Path, record: Record, kinds: Mapping[str, Kind]) -> None:
        self.path, self.record, self.kinds = path, record, kinds
        self.fault: str | None = None
        self._content: Bytes | None = None
        self._map: mmap.mmap | None = None
        self._arrays: dict[str, NDArray[Any]] = {}
        try:
            self._map, self._content = mapped(path)
            self._arrays = self._opened(self._content)
        except NotOpenedError:
            raise
        except HarmonicFaceError as error:
            self.fault = str(error)

    @property
    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """Every array of all entries, (rows, ...), in the file's memory map: read-only.

        Raises
        ------
        HarmonicFaceError
            The file is damaged.
        """
        if self.fault is not None:
            raise HarmonicFaceError(self.fault)
        return self._arrays

    @cached_property
    def directory(self) -> Directory:
        """Who is in it, from the copy that is whole.

        Raises
        ------
        HarmonicFaceError
            No copy is whole, or it does not fit the arrays.
        """
        for copy in self.directory_copies():
            if checksum(copy) == self.record.directory:
                found = read(copy, self.record.entries, len(self.kinds), str(self.path))
                rows = [len(self._arrays[name]) for name in sorted(self._arrays)]
                if self._arrays and found.starts[-1].tolist() != rows:
                    raise HarmonicFaceError(
                        f"{self.path}: expected arrays of {found.starts[-1].tolist()} rows, got {rows}"
                    )
                return found
        raise HarmonicFaceError(f"{self.path}: expected a directory of its entries, got two damaged ones")

    def directory_copies(self) -> tuple[Bytes, ...]:
        """Return the bytes of both copies of the directory, as far as the file is there."""
        if self._content is None:
            return ()
        length, nbytes = self.record.directory_bytes, self.record.nbytes
        return tuple(self._content[at : at + length] for at in (self.record.directory_start, nbytes - length))

    def entry(self, index: int) -> dict[str, NDArray[Any]]:
        """Return the arrays of one entry, views of the map."""
        starts = self.directory.starts
        return {
            name: array[starts[index, column] : starts[index + 1, column]]
            for column, (name, array) in enumerate(sorted(self.arrays.items()))
        }

    def forget(self) -> None:
        """Give the memory of what was read back to the system; it is read again from the file when it is asked for."""
        if self._map is not None and hasattr(mmap, "MADV_DONTNEED"):
            self._map.madvise(mmap.MADV_DONTNEED)

    def _opened(self, content: Bytes) -> dict[str, NDArray[Any]]:
        """Return the entries' arrays after the header has been compared with the record and with the kinds."""
        if len(content) != self.record.nbytes:
            raise HarmonicFaceError(f"{self.path}: expected {self.record.nbytes} bytes, got {len(content)}")
        length = header_length(content, str(self.path))
        if checksum(content[:length]) != self.record.header:
            raise HarmonicFaceError(f"{self.path}: expected the header it was written with, got one that was changed")
        found = views(content, str(self.path))
        directories = [found.pop(name, np.empty(0)) for name in (FIRST, SECOND)]
        if any(one.shape != (self.record.directory_bytes,) or one.dtype != np.uint8 for one in directories):
            raise HarmonicFaceError(f"{self.path}: expected two directories of {self.record.directory_bytes} bytes")
        if set(found) != {ARRAY + name for name in self.kinds}:
            raise HarmonicFaceError(f"{self.path}: expected arrays {sorted(self.kinds)}, got {sorted(found)!s:.80}")
        for name, kind in self.kinds.items():
            array = found[ARRAY + name]
            if array.dtype != kind.dtype or array.ndim == 0 or array.shape[1:] != kind.shape:
                raise HarmonicFaceError(
                    f"{self.path}, {name}: expected rows of shape {kind.shape} and {kind.dtype}, "
                    f"got {array.shape} and {array.dtype}"
                )
        return {name: found[ARRAY + name] for name in self.kinds}


def write_shard(path: Path, kinds: Mapping[str, Kind], sources: Sequence[Source]) -> Record:
    """Write a new file; when this returns, it survives a loss of power. Memory: the directory, and a piece.

    Raises
    ------
    HarmonicFaceError
        The file cannot be written.
    """
    directory = joined([source.directory for source in sources])
    content = directory.to_bytes()
    rows = dict(zip(sorted(kinds), directory.starts[-1].tolist(), strict=True))
    order = sorted(kinds, key=lambda name: (-kinds[name].dtype.itemsize, name))
    arrays = [Tensor(ARRAY + name, kinds[name].dtype, (rows[name], *kinds[name].shape)) for name in order]
    copies = [Tensor(name, TYPES["U8"], (len(content),)) for name in (FIRST, SECOND)]
    head = header([copies[0], *arrays, copies[1]], {"format": "harmonicface shard", "version": "1"}, MULTIPLE)
    with replacing(path) as temporary, temporary.open("wb", buffering=0) as stream:
        _write(stream.fileno(), np.frombuffer(head + content, np.uint8))
        for name in order:
            for source in sources:
                for piece in source.pieces(name):
                    _write(stream.fileno(), piece.reshape(-1).view(np.uint8))
        _write(stream.fileno(), np.frombuffer(content, np.uint8))
    return Record(
        path.name,
        len(head) + sum(one.nbytes for one in (*copies, *arrays)),
        len(directory),
        hashlib.sha256(head).hexdigest(),
        len(head),
        len(content),
        hashlib.sha256(content).hexdigest(),
    )


def damaged_entries(shard: Shard, indices: NDArray[np.int64]) -> list[int]:
    """Return those of some entries whose arrays are not what was written, or not finite: every byte of them is read."""
    digests = shard.directory.digests
    bad = []
    step = max(1, PIECE // max(1, shard.record.nbytes // shard.record.entries))
    for number, index in enumerate(indices.tolist()):
        arrays = shard.entry(index)
        if digest(arrays) != digests[index].tobytes() or not all(map(is_finite, arrays.values())):
            bad.append(index)
        if number % step == step - 1:
            shard.forget()
    return bad


def _write(handle: int, content: Bytes) -> None:
    """Write all bytes."""
    for start in range(0, len(content), PIECE):
        piece = content[start : start + PIECE].data
        while piece:
            piece = piece[os.write(handle, piece) :]
