"""Plain files, opened without trust: no link is followed, and nothing waits for a pipe."""

from __future__ import annotations

import errno
import mmap
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from harmonicface.errors import HarmonicFaceError
from harmonicface.store.tensors import Bytes

PIECE = 1 << 22  # bytes read at once
FLAGS = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)


class NotOpenedError(HarmonicFaceError):
    """The system does not open a file that may be whole: too many are open, or no right to read it."""


@contextmanager
def plain_file(path: Path) -> Iterator[tuple[int, int]]:
    """Yield the handle and the length of a file.

    Raises
    ------
    HarmonicFaceError
        It is no plain file.
    OSError
        It is a link, or the system refuses.
    """
    handle = os.open(path, FLAGS)
    try:
        found = os.fstat(handle)
        if not stat.S_ISREG(found.st_mode):
            raise HarmonicFaceError(f"{path}: expected a plain file, got something else")
        yield handle, found.st_size
    finally:
        os.close(handle)


def mapped(path: Path) -> tuple[mmap.mmap | None, Bytes]:
    """Map a file into memory, and return its bytes, read-only; an empty file has no map.

    Raises
    ------
    HarmonicFaceError
        It is missing, a link or no plain file.
    NotOpenedError
        The system refuses for another reason, which says nothing about the file.
    """
    try:
        with plain_file(path) as (handle, length):
            content = mmap.mmap(handle, length, access=mmap.ACCESS_READ) if length else None
    except OSError as error:
        refused = HarmonicFaceError if error.errno in (errno.ENOENT, errno.ELOOP) else NotOpenedError
        raise refused(f"{path}: expected a file that can be mapped, got: {error.strerror}") from None
    return content, np.empty(0, np.uint8) if content is None else np.frombuffer(content, np.uint8)


def read_through(path: Path) -> None:
    """Read a file once: what the disk does not give is an error here, but ends a process that finds it in a map.

    A file that another writer has removed meanwhile lives on where it is mapped, and is not read.

    Raises
    ------
    HarmonicFaceError
        The disk does not give all of it.
    """
    try:
        with plain_file(path) as (handle, _):
            while os.read(handle, PIECE):
                pass
    except FileNotFoundError:
        pass
    except OSError as error:
        raise HarmonicFaceError(f"{path}: expected a file that can be read, got: {error.strerror}") from None
