"""Named arrays in one safetensors file, replaced whole, with a checksum over everything in it."""

from __future__ import annotations

import hashlib
import io
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import load_file, save

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.files import replacing

DIGEST = "blake2b"  # the name of the array that holds the checksum
DIGEST_BYTES = 32
CHUNK = 1 << 22


def write_arrays(path: str | os.PathLike[str], arrays: Mapping[str, NDArray[Any]], about: Mapping[str, str]) -> None:
    """Write named arrays and a few words about them. Memory: the size of the file once more.

    Parameters
    ----------
    path
        The file, replaced whole or not at all.
    arrays
        C-contiguous arrays by name; the name "blake2b" is taken.
    about
        Short texts by key, kept in the header.

    Raises
    ------
    HarmonicFaceError
        The file cannot be written.
    """
    blank = np.zeros(DIGEST_BYTES, np.uint8)
    content = bytearray(save({**arrays, DIGEST: blank}, dict(about)))
    start = _digest_start(io.BytesIO(content))
    content[start : start + DIGEST_BYTES] = hashlib.blake2b(content, digest_size=DIGEST_BYTES).digest()
    with replacing(path) as temporary:
        temporary.write_bytes(content)


def read_arrays(path: str | os.PathLike[str]) -> tuple[dict[str, NDArray[Any]], dict[str, str]]:
    """Read what `write_arrays` wrote: the arrays, and the words about them.

    Raises
    ------
    HarmonicFaceError
        The file is missing, cut short, changed in any byte, or was not written by `write_arrays`.
    """
    file = Path(path)
    try:
        if not file.is_file():
            found = "a folder" if file.is_dir() else "none"
            raise HarmonicFaceError(f"expected a file at {file!s:.300}, got {found}")
        with file.open("rb") as stream:
            start = _digest_start(stream)
            stream.seek(start)
            stored = stream.read(DIGEST_BYTES)
            if stored != _digest(stream, start):
                raise HarmonicFaceError(
                    f"{file}: expected the checksum it was written with, got a file that was changed"
                )
            about = _header(stream).get("__metadata__") or {}
        arrays = load_file(file)
    except (SafetensorError, OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        if isinstance(error, HarmonicFaceError):
            raise
        raise HarmonicFaceError(
            f"{file}: expected a whole file of named arrays, got a damaged or foreign one"
        ) from None
    del arrays[DIGEST]
    return arrays, about


def read_about(path: str | os.PathLike[str]) -> dict[str, str]:
    """Read the words about a file's arrays, without the arrays and their checksum; none of a file of another kind."""
    try:
        with Path(path).open("rb") as stream:
            return dict(_header(stream).get("__metadata__") or {})
    except (OSError, ValueError, TypeError, RecursionError, MemoryError):
        return {}


def _header(stream: BinaryIO) -> dict[str, Any]:
    """Return the safetensors header: a JSON object behind its length in eight bytes."""
    size = stream.seek(0, os.SEEK_END)
    stream.seek(0)
    length = int.from_bytes(stream.read(8), "little")
    if not 0 < length <= size - 8:
        raise ValueError("a header longer than the file")
    header = json.loads(stream.read(length))
    header["__start__"], header["__size__"] = 8 + length, size
    return dict(header)


def _digest_start(stream: BinaryIO) -> int:
    """Return where in the file the checksum's bytes stand."""
    header = _header(stream)
    begin, end = header[DIGEST]["data_offsets"]
    start = header["__start__"] + begin
    if end - begin != DIGEST_BYTES or not header["__start__"] <= start <= header["__size__"] - DIGEST_BYTES:
        raise ValueError("a checksum of another length or outside the file")
    return int(start)


def _digest(stream: BinaryIO, blank: int) -> bytes:
    """Return the checksum of the whole file, its own bytes at `blank` taken as zeros."""
    checksum = hashlib.blake2b(digest_size=DIGEST_BYTES)
    stream.seek(0)
    checksum.update(stream.read(blank))
    stream.seek(DIGEST_BYTES, os.SEEK_CUR)
    checksum.update(bytes(DIGEST_BYTES))
    while chunk := stream.read(CHUNK):
        checksum.update(chunk)
    return checksum.digest()
