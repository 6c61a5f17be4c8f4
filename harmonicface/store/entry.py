"""Entry: one thing that a folder keeps, by key: a few words about it and named arrays; and what these must be."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import describe
from harmonicface.errors import HarmonicFaceError
from harmonicface.store.tensors import MOST_AXES, NAMES

LONGEST_KEY = 1024
LONGEST_NAME, MOST_KINDS = 64, 64  # a header holds them all
LONGEST_ABOUT = 1 << 16
DIGEST_BYTES = 16


@dataclass(frozen=True)
class Kind:
    """What the entries' arrays of one name have in common.

    Parameters
    ----------
    dtype
        Of every element.
    shape
        Of one row: an entry's array is (r, *shape) with its own number r of rows, which may be 0.

    Raises
    ------
    HarmonicFaceError
        A type that files do not have (objects, complex numbers), or a shape that is none.
    """

    dtype: np.dtype[Any]
    shape: tuple[int, ...] = ()

    @property
    def row_bytes(self) -> int:
        """Bytes of one row."""
        return math.prod(self.shape) * self.dtype.itemsize

    def __post_init__(self) -> None:
        try:
            object.__setattr__(self, "dtype", np.dtype(self.dtype))
        except TypeError:
            raise HarmonicFaceError(f"dtype: expected a type of numbers, got {describe(self.dtype)}") from None
        if self.dtype not in NAMES:
            raise HarmonicFaceError(f"dtype: expected one of {', '.join(map(str, NAMES))}, got {self.dtype!s:.40}")
        sides = tuple(self.shape)
        if len(sides) >= MOST_AXES or not all(type(side) is int and 0 < side < 2**40 for side in sides):
            raise HarmonicFaceError(f"shape: expected at most {MOST_AXES - 1} sides above 0, got {sides!s:.80}")


@dataclass(frozen=True, eq=False)
class Entry:
    """One thing by its key.

    Parameters
    ----------
    key
        1 to 1024 bytes as UTF-8, unlike that of any other entry.
    arrays
        (r, ...) by name, of the folder's kinds.
    about
        What JSON can say of it, at most 64 KiB.
    """

    key: str
    arrays: Mapping[str, NDArray[Any]]
    about: Mapping[str, Any] = field(default_factory=dict)

    @property
    def nbytes(self) -> int:
        """Bytes of its arrays."""
        return sum(array.nbytes for array in self.arrays.values())


def checked_key(key: object) -> str:
    """Return a key.

    Raises
    ------
    HarmonicFaceError
        No text, an empty one, one that is too long or has no UTF-8.
    """
    try:
        if isinstance(key, str) and 0 < len(key.encode()) <= LONGEST_KEY:
            return key
    except UnicodeEncodeError:
        pass
    raise HarmonicFaceError(f"key: expected a text of 1 to {LONGEST_KEY} bytes, got {ascii(key)!s:.80}")


def check_kinds(kinds: Mapping[str, Kind]) -> None:
    """Refuse what is no kind by the name of an array.

    Raises
    ------
    HarmonicFaceError
        Another thing, a name that is no identifier or longer than 64, none at all or more than 64.
    """
    good = all(
        isinstance(name, str) and name.isidentifier() and len(name) <= LONGEST_NAME and isinstance(kind, Kind)
        for name, kind in kinds.items()
    )
    if not good or not 0 < len(kinds) <= MOST_KINDS:
        raise HarmonicFaceError(f"kinds: expected a Kind by the name of each array, got {dict(kinds)!s:.80}")


def about_text(about: Mapping[str, Any], longest: int = LONGEST_ABOUT) -> bytes:
    """Return the words about something as JSON.

    Raises
    ------
    HarmonicFaceError
        What JSON cannot say, or too much of it.
    """
    if not isinstance(about, Mapping):
        raise HarmonicFaceError(f"about: expected a dict, got {describe(about)}")
    try:
        text = json.dumps(dict(about), allow_nan=False, separators=(",", ":")).encode()
    except (TypeError, ValueError, RecursionError):
        raise HarmonicFaceError(f"about: expected what JSON can say, got {describe(about)}") from None
    if len(text) > longest:
        raise HarmonicFaceError(f"about: expected at most {longest} bytes of JSON, got {len(text)}")
    return text


def checked_entry(entry: Entry, kinds: Mapping[str, Kind]) -> Entry:
    """Return an entry that may be stored, its arrays contiguous.

    Raises
    ------
    HarmonicFaceError
        A key, words or arrays that do not fit; NaN or infinity.
    """
    if not isinstance(entry, Entry):
        raise HarmonicFaceError(f"entry: expected an Entry, got {describe(entry)}")
    key = checked_key(entry.key)
    about_text(entry.about)
    if set(entry.arrays) != set(kinds):
        raise HarmonicFaceError(f"{key!r:.80}: expected arrays {sorted(kinds)}, got {sorted(entry.arrays)!s:.80}")
    arrays = {name: _checked(entry.arrays[name], kinds[name], f"{key!r:.80}, {name}") for name in sorted(kinds)}
    return Entry(key, arrays, entry.about)


def digest(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Return the checksum of an entry's arrays in the order of their names, each contiguous."""
    checksum = hashlib.sha256()
    for name in sorted(arrays):
        checksum.update(arrays[name].reshape(-1).view(np.uint8).data)
    return checksum.digest()[:DIGEST_BYTES]


def is_finite(array: NDArray[Any]) -> bool:
    """Tell whether an array has neither NaN nor infinity."""
    return array.dtype.kind != "f" or bool(np.isfinite(array).all())


def _checked(array: object, kind: Kind, what: str) -> NDArray[Any]:
    """Return an array of a kind, contiguous."""
    if (
        not isinstance(array, np.ndarray)
        or array.dtype != kind.dtype
        or array.ndim == 0
        or array.shape[1:] != kind.shape
    ):
        shape = str(("rows", *kind.shape)).replace("'", "")
        raise HarmonicFaceError(f"{what}: expected an array {shape} of {kind.dtype}, got {describe(array)}")
    if not is_finite(array):
        raise HarmonicFaceError(f"{what}: expected finite numbers, got NaN or infinity in {describe(array)}")
    return np.ascontiguousarray(array)
