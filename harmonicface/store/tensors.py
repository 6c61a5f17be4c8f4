"""The safetensors layout: named arrays behind a JSON header, laid out by ourselves and mapped without trust.

The layout is eight bytes with the length of the header, the header (a JSON object: type, shape and place of every
array), and the arrays one behind the other without gaps, little-endian. The library safetensors reads these files too;
here the header is checked before anything is done with it, because arrays are mapped, not read.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError

Bytes = NDArray[np.uint8]
TYPES = {
    "BOOL": np.dtype("?"),
    "U8": np.dtype("u1"),
    "I8": np.dtype("i1"),
    "U16": np.dtype("<u2"),
    "I16": np.dtype("<i2"),
    "F16": np.dtype("<f2"),
    "U32": np.dtype("<u4"),
    "I32": np.dtype("<i4"),
    "F32": np.dtype("<f4"),
    "U64": np.dtype("<u8"),
    "I64": np.dtype("<i8"),
    "F64": np.dtype("<f8"),
}
NAMES = {dtype: name for name, dtype in TYPES.items()}
LONGEST_HEADER = 1 << 20
MOST_AXES = 8
ABOUT = "__metadata__"  # the one name in the header that is no array


@dataclass(frozen=True)
class Tensor:
    """Type and shape of one array in a file."""

    name: str
    dtype: np.dtype[Any]
    shape: tuple[int, ...]

    @property
    def nbytes(self) -> int:
        """How many bytes it takes."""
        return math.prod(self.shape) * self.dtype.itemsize


def header(tensors: Sequence[Tensor], about: Mapping[str, str], multiple: int = 8) -> bytes:
    """Return the header of a file whose arrays follow in the order given, its length before it.

    Parameters
    ----------
    tensors
        Types that are keys of `NAMES`, names without repetition.
    about
        Short texts by key.
    multiple
        The first array stands at a multiple of so many bytes: blanks fill the header.
    """
    described: dict[str, Any] = {ABOUT: dict(about)}
    place = 0
    for one in tensors:
        described[one.name] = {
            "dtype": NAMES[one.dtype],
            "shape": list(one.shape),
            "data_offsets": [place, place + one.nbytes],
        }
        place += one.nbytes
    text = json.dumps(described, separators=(",", ":")).encode()
    text += b" " * (-(8 + len(text)) % multiple)
    return len(text).to_bytes(8, "little") + text


def packed(arrays: Mapping[str, NDArray[Any]], about: Mapping[str, str], multiple: int = 1) -> bytes:
    """Return whole small arrays as one safetensors file of a length that is a multiple of `multiple`.

    What the length lacks is filled by an array "padding". Wide types come first, so that every array is aligned.
    """
    named = {name: np.asarray(array, order="C") for name, array in arrays.items()}
    order = sorted(named, key=lambda name: (-named[name].itemsize, name))
    tensors = [Tensor(name, named[name].dtype, named[name].shape) for name in order]
    missing = -sum(one.nbytes for one in tensors) % multiple
    tensors.append(Tensor("padding", TYPES["U8"], (missing,)))
    head = header(tensors, about, multiple)
    return b"".join([head, *(named[name].tobytes() for name in order), bytes(missing)])


def views(content: Bytes, what: str) -> dict[str, NDArray[Any]]:
    """Return the arrays of a file as views of its bytes; nothing but the header is read.

    Parameters
    ----------
    content
        (n,) all bytes of the file, mapped or in memory.
    what
        The file's name, for messages.

    Raises
    ------
    HarmonicFaceError
        A header that is none, lies about its length or the file's, or has other than known types and plain shapes.

    Examples
    --------
    >>> content = packed({"rows": np.eye(2, dtype=np.float32)}, {})
    >>> views(np.frombuffer(content, np.uint8), "a file")["rows"]
    array([[1., 0.],
           [0., 1.]], dtype=float32)
    """
    start, described = _described(content, what)
    ends = 0
    found = {}
    try:
        for name, one in sorted(described.items(), key=lambda item: item[1]["data_offsets"]):
            tensor = Tensor(name, TYPES[one["dtype"]], _shape(one["shape"]))
            begin, end = one["data_offsets"]
            if type(begin) is not int or begin != ends or end != begin + tensor.nbytes:
                raise HarmonicFaceError(
                    f"{what}: expected arrays one behind the other, got {name!r:.40} of {tensor.nbytes:.4g} bytes "
                    f"from {begin!s:.40} to {end!s:.40} behind {ends}"
                )
            if start + end > len(content):
                raise HarmonicFaceError(
                    f"{what}: expected arrays inside its {len(content)} bytes, got {name!r:.40} of {tensor.nbytes:.4g}"
                )
            found[name] = content[start + begin : start + end].view(tensor.dtype).reshape(tensor.shape)
            ends = end
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        if isinstance(error, HarmonicFaceError):
            raise
        raise HarmonicFaceError(f"{what}: expected a type, a shape and a place of every array, got others") from None
    if start + ends != len(content):
        raise HarmonicFaceError(f"{what}: expected {start + ends} bytes as its header says, got {len(content)}")
    return found


def checksum(content: Bytes) -> str:
    """Return the SHA-256 of bytes, which are read without being copied."""
    return hashlib.sha256(content.data).hexdigest()


def header_length(content: Bytes, what: str) -> int:
    """Return how many bytes the header takes with its length before it.

    Raises
    ------
    HarmonicFaceError
        More than the file has, or more than a header of ours.
    """
    length = int.from_bytes(content[:8].tobytes(), "little")
    if len(content) < 8 or not 0 < length <= min(len(content) - 8, LONGEST_HEADER):
        raise HarmonicFaceError(
            f"{what}: expected a header of at most {LONGEST_HEADER} bytes inside its {len(content)}, got {length:.4g}"
        )
    return 8 + length


def _described(content: Bytes, what: str) -> tuple[int, dict[str, Any]]:
    """Return where the arrays begin, and what the header says of each."""
    start = header_length(content, what)
    try:
        described = json.loads(content[8:start].tobytes())
    except (ValueError, RecursionError):
        described = None
    if not isinstance(described, dict) or not all(isinstance(one, dict) for one in described.values()):
        raise HarmonicFaceError(f"{what}: expected a JSON header of named arrays, got something else")
    described.pop(ABOUT, None)
    return start, described


def _shape(value: Any) -> tuple[int, ...]:
    """Return a plain shape, otherwise TypeError."""
    if not isinstance(value, list) or len(value) > MOST_AXES:
        raise TypeError
    if not all(type(side) is int and 0 <= side < 2**62 for side in value):
        raise TypeError
    return tuple(value)
