"""Files are replaced whole or not at all, and one writer at a time."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from harmonicface.errors import HarmonicFaceError

try:
    import fcntl
except ImportError:  # not a POSIX system: no locks there
    fcntl = None  # type: ignore[assignment]


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path beside `path`; what is written there takes its place when the block ends well.

    A process that is killed while it writes leaves the old file and its temporary one; the next writer of the same
    file removes that, because the dead process holds no lock on it any more.

    Parameters
    ----------
    path
        The file to write; of a symbolic link the file that it points to. Its folder must exist.

    Yields
    ------
    Path
        A file of the same ending in the same folder. It is removed when the block raises.

    Raises
    ------
    HarmonicFaceError
        The folder does not exist or cannot be written to, or the disk is full.
    """
    try:
        target = Path(path).resolve()
        prefix = f".{target.stem[:50]}.partial-"
        _remove_abandoned(target.parent, prefix, target.suffix)
        handle, name = tempfile.mkstemp(dir=target.parent, prefix=prefix, suffix=target.suffix)
    except (OSError, ValueError) as error:  # ValueError: a null character
        raise HarmonicFaceError(f"cannot write {path!s:.300}: {_reason(error)}") from None
    temporary = Path(name)
    try:
        _lock(handle)
        yield temporary
        _publish(temporary, target)
    except OSError as error:
        raise HarmonicFaceError(f"cannot write {target}: {_reason(error)}") from None
    finally:
        temporary.unlink(missing_ok=True)
        os.close(handle)


@contextmanager
def alone_in(folder: str | os.PathLike[str]) -> Iterator[None]:
    """Let one process at a time change the files of a folder: read, change, write, without losing what another wrote.

    The lock is the system's own on the folder: nothing is left behind, and a dead process holds none.

    Raises
    ------
    HarmonicFaceError
        The folder is not there, or its file system has no locks.
    """
    try:
        handle = os.open(folder, os.O_RDONLY)
    except (OSError, ValueError) as error:
        raise HarmonicFaceError(f"expected a folder {folder!s:.300}, got none: {_reason(error)}") from None
    try:
        try:
            _lock(handle)
        except OSError as error:  # a file system without locks
            raise HarmonicFaceError(f"cannot lock the folder {folder!s:.300}: {_reason(error)}") from None
        yield
    finally:
        os.close(handle)


def _remove_abandoned(folder: Path, prefix: str, suffix: str) -> None:
    """Remove temporary files whose writers are dead: nobody holds the lock on them."""
    if fcntl is None:
        return
    for path in folder.iterdir():
        if path.name.startswith(prefix) and path.suffix == suffix:
            with suppress(OSError), path.open("rb") as stream:
                fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
                path.unlink()


def _lock(handle: int) -> None:
    """Wait until nobody else holds the lock on a file or folder, and hold it until it is closed."""
    if fcntl is not None:
        fcntl.flock(handle, fcntl.LOCK_EX)


def _publish(temporary: Path, target: Path) -> None:
    """Move a finished file to its name so that a crash leaves the old one or the new one, never a part."""
    umask = os.umask(0)
    os.umask(umask)
    temporary.chmod(0o666 & ~umask)  # mkstemp makes files that only their owner can read
    with temporary.open("rb+") as stream:
        os.fsync(stream.fileno())
    temporary.replace(target)
    if hasattr(os, "O_DIRECTORY"):
        folder = os.open(target.parent, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)


def _reason(error: Exception) -> str:
    """Return what the system says, without the path that it repeats."""
    return getattr(error, "strerror", None) or str(error)
