"""Staging: a gallery on object storage is copied to this machine's disk and read there; nobody writes to it.

Memory maps, locks and replacing a file in one step are what POSIX file systems do; object storage does none of them.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.files import replacing
from harmonicface.store.manifest import NAME, Manifest, read_manifest

CACHE = "HARMONICFACE_CACHE"  # the environment's word for the folder in which copies are kept
PROTOCOL = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*(::[A-Za-z][A-Za-z0-9+.-]*)*://")
TIMES = 3  # a gallery that is replaced while it is copied is copied again


def is_url(path: str | os.PathLike[str]) -> bool:
    """Tell whether a path is one of fsspec's, as "s3://bucket/people.gallery"; all of these are staged and only read.

    Examples
    --------
    >>> is_url("s3://bucket/people.gallery"), is_url("/data/people.gallery")
    (True, False)
    """
    return isinstance(path, str) and PROTOCOL.match(path) is not None


def refuse_writing(path: str | os.PathLike[str]) -> None:
    """Refuse to write to a path of fsspec's.

    Raises
    ------
    HarmonicFaceError
        It is one.
    """
    if is_url(path):
        raise HarmonicFaceError(
            f"expected a folder on a POSIX file system, where locks and memory maps live, got {path!s:.200}, "
            "which is only read"
        )


def cache_folder() -> Path:
    """Return where this machine keeps copies: HARMONICFACE_CACHE, or harmonicface in the user's folder of caches."""
    named = os.environ.get(CACHE)
    if named:
        return Path(named)
    caches = os.environ.get("XDG_CACHE_HOME")
    return (Path(caches) if caches else Path.home() / ".cache") / "harmonicface"


def staged(url: str, cache: Path | None = None) -> Path:
    """Copy a gallery to this machine, as far as it is not there yet, and return the folder of the copy.

    Parameters
    ----------
    url
        A gallery's folder as fsspec names it.
    cache
        Where copies are kept, each in a folder named by the checksum of its manifest; by default `cache_folder`.

    Raises
    ------
    HarmonicFaceError
        No gallery is there, its protocol needs a package that is missing, files of other lengths than the manifest
        says, a full disk.
    """
    for time in range(TIMES):
        folder, manifest = staged_manifest(url, cache)
        try:
            fetch(url, folder, [(one.record.file, one.record.nbytes) for one in manifest.shards])
            if manifest.common:
                fetch(url, folder, [(manifest.common.file, manifest.common.nbytes)])
            break
        except HarmonicFaceError:
            if time == TIMES - 1 or staged_manifest(url, cache)[0] == folder:
                raise
    return folder


def staged_manifest(url: str, cache: Path | None = None) -> tuple[Path, Manifest]:
    """Copy a gallery's manifest only; return the folder of the copy, which `fetch` fills, and what it says.

    Raises
    ------
    HarmonicFaceError
        As `staged`.
    """
    files, root = _file_system(url)
    try:
        content = files.cat_file(f"{root}/{NAME}")
    except Exception as error:  # every protocol has its own
        raise HarmonicFaceError(f"expected a gallery at {url:.200}, got none: {_reason(error)}") from None
    folder = copy_of(hashlib.sha256(content).hexdigest(), cache)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise HarmonicFaceError(f"cannot make the folder {folder!s:.300}: {error.strerror}") from None
    if not (folder / NAME).exists():
        with replacing(folder / NAME) as temporary:
            temporary.write_bytes(content)
    return folder, read_manifest(folder)


def copy_of(checksum: str, cache: Path | None = None) -> Path:
    """Return where the copy of a gallery is kept, by the checksum of its manifest."""
    return (cache or cache_folder()) / checksum


def fetch(url: str, folder: Path, files: Sequence[tuple[str, int]]) -> None:
    """Copy files of a gallery, with the lengths that its manifest says, as far as they are not there yet.

    Several processes may do it at once: a file appears whole.

    Raises
    ------
    HarmonicFaceError
        A file that is not there, or has another length; a full disk.
    """
    source, root = _file_system(url)
    for name, nbytes in files:
        if (folder / name).exists():
            continue
        with replacing(folder / name) as temporary:
            try:
                source.get_file(f"{root}/{name}", str(temporary))
            except Exception as error:  # every protocol has its own
                raise HarmonicFaceError(f"{url:.200}: cannot copy {name}: {_reason(error)}") from None
            found = temporary.stat().st_size
            if found != nbytes:
                raise HarmonicFaceError(f"{url:.200}: expected {name} of {nbytes} bytes, got {found}")


def _file_system(url: str) -> tuple[Any, str]:
    """Return fsspec's file system of a path, and the path in it."""
    try:
        from fsspec.core import url_to_fs  # an extra, needed for such paths only
    except ImportError:
        raise HarmonicFaceError(
            f"expected fsspec, which opens {url:.200}, got none: pip install harmonicface[distributed]"
        ) from None
    try:
        files, root = url_to_fs(url)
    except Exception as error:  # ImportError of what a protocol needs, ValueError, and its own
        raise HarmonicFaceError(f"cannot open {url:.200}: {_reason(error)}") from None
    return files, str(root).rstrip("/")


def _reason(error: Exception) -> str:
    """Return what went wrong in one line."""
    said = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return " ".join(str(said).split())[:200]
