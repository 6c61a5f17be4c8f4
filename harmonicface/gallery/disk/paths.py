"""What is at a path where a gallery is, or is to be; a name that nothing can have has nothing there."""

from __future__ import annotations

import os
from pathlib import Path

from harmonicface.errors import HarmonicFaceError
from harmonicface.store.manifest import NAME

PathLike = str | os.PathLike[str]


def is_folder(path: PathLike) -> bool:
    """Tell whether a folder is there."""
    try:
        return Path(path).is_dir()
    except (OSError, ValueError):
        return False


def is_file(path: PathLike) -> bool:
    """Tell whether a file is there."""
    try:
        return Path(path).is_file()
    except (OSError, ValueError):
        return False


def is_free(path: PathLike) -> bool:
    """Tell whether nothing is there, or an empty folder."""
    try:
        place = Path(path)
        return not os.path.lexists(place) or (place.is_dir() and not any(place.iterdir()))
    except (OSError, ValueError):  # opening it says what is wrong
        return False


def is_same(one: PathLike, other: PathLike) -> bool:
    """Tell whether two paths are one place."""
    try:
        return Path(one).exists() and Path(other).exists() and Path(one).samefile(other)
    except (OSError, ValueError):
        return False


def refuse_nothing(path: PathLike) -> None:
    """Refuse a path at which nothing is, or a folder that is no gallery.

    Raises
    ------
    HarmonicFaceError
        It is such a path.
    """
    if not os.path.lexists(path):
        raise HarmonicFaceError(f"expected a gallery at {path!s:.300}, got none")
    if is_folder(path) and not os.path.lexists(Path(path) / NAME):
        raise HarmonicFaceError(f"expected a gallery at {path!s:.300}, got a folder that is none")
