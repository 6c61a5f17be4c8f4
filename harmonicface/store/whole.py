"""Whole: a folder of entries that is made with all of them at once, so that nobody ever sees a part of it."""

from __future__ import annotations

import errno
import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.files import alone_in
from harmonicface.store import writing
from harmonicface.store.entry import Entry, Kind
from harmonicface.store.folder import ArrayFolder

try:
    import fcntl
except ImportError:  # not a POSIX system: no locks there
    fcntl = None  # type: ignore[assignment]


class TakenError(HarmonicFaceError):
    """Somebody else has made something at that place meanwhile."""


def make_whole(
    path: str | os.PathLike[str],
    entries: Iterable[Entry],
    kinds: Mapping[str, Kind],
    about: Mapping[str, Any],
    common: Mapping[str, NDArray[Any]],
) -> None:
    """Make a folder with entries in it; a process that is killed has made none.

    Parameters
    ----------
    path
        A new folder or an empty one, in one that is there.
    entries
        With different keys.
    kinds, about, common
        As of `ArrayFolder.create`.

    Raises
    ------
    HarmonicFaceError
        What is given cannot be kept, or the disk is full.
    TakenError
        Something is there.
    """
    target = Path(path)
    with suppress(OSError, ValueError):  # of a name that nothing can have, making it says so
        target = target.resolve()  # an empty folder may be elsewhere, behind a link
    with _beside(target) as temporary:
        folder = ArrayFolder.create(temporary, kinds, about, common)
        folder.append(entries)
        try:
            temporary.rename(target)  # takes the place of an empty folder, of nothing else
        except OSError as error:
            taken = error.errno in (errno.ENOTEMPTY, errno.EEXIST, errno.ENOTDIR)
            refused = TakenError if taken else HarmonicFaceError
            raise refused(f"cannot make the folder {target!s:.300}: {error.strerror or error}") from None
    writing.make_durable(target.parent)


@contextmanager
def _beside(target: Path) -> Iterator[Path]:
    """Yield a path for a new folder in the same file system; what killed writers left there is removed first."""
    prefix = f".{target.name[:50]}.partial-"
    try:
        with alone_in(target.parent):
            for one in list(target.parent.iterdir()):
                if one.name.startswith(prefix):
                    _remove_abandoned(one)
            outer = Path(tempfile.mkdtemp(dir=target.parent, prefix=prefix))
            handle = os.open(outer, os.O_RDONLY)
            _lock(handle)
    except (OSError, ValueError) as error:  # ValueError: a null character
        reason = str(error) if isinstance(error, HarmonicFaceError) else getattr(error, "strerror", None) or error
        raise HarmonicFaceError(f"cannot make the folder {target!s:.300}: {reason}") from None
    try:
        yield outer / "folder"
    finally:
        os.close(handle)
        shutil.rmtree(outer, ignore_errors=True)


def _remove_abandoned(outer: Path) -> None:
    """Remove what a writer left who is dead: nobody holds the lock on it."""
    with suppress(OSError):
        handle = os.open(outer, os.O_RDONLY)
        try:
            _lock(handle, wait=False)
            shutil.rmtree(outer, ignore_errors=True)
        finally:
            os.close(handle)


def _lock(handle: int, wait: bool = True) -> None:
    """Show other writers that a folder is being written, or raise OSError if another does."""
    if fcntl is not None:
        fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    elif not wait:
        raise OSError("no locks here: nobody knows who is dead")
