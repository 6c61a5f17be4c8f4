"""The safetensors layout: read by the library too; headers that lie are refused before anything is mapped."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from safetensors.numpy import load, save

from harmonicface.errors import HarmonicFaceError
from harmonicface.store.tensors import LONGEST_HEADER, TYPES, Tensor, checksum, header, header_length, packed, views


def bytes_of(content: bytes) -> np.ndarray:
    return np.frombuffer(content, np.uint8)


def with_header(described: object, body: int = 32) -> np.ndarray:
    text = described if isinstance(described, bytes) else json.dumps(described).encode()
    return bytes_of(len(text).to_bytes(8, "little") + text + bytes(body))


def one(dtype: object, shape: object, offsets: object) -> dict[str, object]:
    return {"rows": {"dtype": dtype, "shape": shape, "data_offsets": offsets}}


ARRAYS = st.dictionaries(
    st.text(st.characters(codec="ascii", categories=["Ll"]), min_size=1, max_size=6).filter(lambda n: n != "padding"),
    hnp.arrays(st.sampled_from(list(TYPES.values())), hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=3)),
    max_size=4,
)


@given(ARRAYS, st.sampled_from([1, 8, 64]))
def test_the_library_reads_what_is_packed_and_so_do_views(arrays: dict[str, np.ndarray], multiple: int) -> None:
    content = packed(arrays, {"who": "a test"}, multiple)
    assert len(content) % multiple == 0
    for found in (load(content), views(bytes_of(content), "a file")):
        del found["padding"]
        assert {n: (a.dtype, a.shape, a.tobytes()) for n, a in found.items()} == {
            n: (a.dtype, a.shape, a.tobytes()) for n, a in arrays.items()
        }


def test_views_read_what_the_library_writes() -> None:
    arrays = {"b": np.eye(3), "a": np.arange(5, dtype=np.uint8)}
    found = views(bytes_of(save(arrays, {"x": "y"})), "a file")
    assert all(np.array_equal(found[name], arrays[name]) for name in arrays)


def test_views_are_views() -> None:
    content = bytes_of(packed({"rows": np.eye(3)}, {}))
    assert np.shares_memory(views(content, "a file")["rows"], content)


def test_the_arrays_begin_at_a_multiple() -> None:
    for name in ("a", "ab", "abc" * 30):
        assert len(header([Tensor(name, TYPES["F32"], (2, 3))], {}, 64)) % 64 == 0


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"1234567",
        bytes(8),
        bytes(64),
        b"\xff" * 64,
        (10**12).to_bytes(8, "little") + b"{}",
        (LONGEST_HEADER + 1).to_bytes(8, "little") + bytes(LONGEST_HEADER + 10),
    ],
)
def test_a_header_of_a_length_that_cannot_be(content: bytes) -> None:
    with pytest.raises(HarmonicFaceError, match="a file: expected a header of at most"):
        header_length(bytes_of(content), "a file")


@pytest.mark.parametrize("text", [b"not json", b"\xff\xfe", b"[" * 100_000, b"[]", b"3", b'{"rows": 3}'])
def test_a_header_that_is_no_object_of_arrays(text: bytes) -> None:
    with pytest.raises(HarmonicFaceError, match="a file: expected a JSON header of named arrays"):
        views(with_header(text), "a file")


@pytest.mark.parametrize(
    "described",
    [
        one("F32", [8], None),
        one("F32", [8], [0]),
        one("F33", [8], [0, 32]),
        one(["F32"], [8], [0, 32]),
        one("F32", 8, [0, 32]),
        one("F32", [-8], [0, 32]),
        one("F32", [8.0], [0, 32]),
        one("F32", [True], [0, 4]),
        one("F32", [1] * 40, [0, 4]),
        one("F32", [2**70], [0, 32]),
        one("U8", [0, 2**61, 2**61], [0, 0]),
        {"rows": {}},
        {**one("U8", [32], [0, 32]), "b": {"dtype": "U8", "shape": [1], "data_offsets": {}}},
    ],
)
def test_arrays_that_are_none(described: object) -> None:
    with pytest.raises(HarmonicFaceError, match="a file: expected a type, a shape and a place"):
        views(with_header(described, 0 if "U8" in str(described) and "b" not in str(described) else 32), "a file")


@pytest.mark.parametrize(
    "described",
    [
        one("F32", [8], [4, 36]),
        one("F32", [8], [-4, 28]),
        one("F32", [8], [0.0, 32]),
        one("F32", [8], ["0", "32"]),
        one("F32", [9], [0, 32]),
        one("F32", [8], [0, 31]),
        one("F32", [8], [0, 10**400]),
        {**one("U8", [20], [0, 20]), "b": {"dtype": "U8", "shape": [13], "data_offsets": [19, 32]}},
    ],
)
def test_arrays_with_gaps_overlaps_or_wrong_sizes(described: object) -> None:
    with pytest.raises(HarmonicFaceError, match="a file: expected arrays one behind the other"):
        views(with_header(described), "a file")


def test_an_array_of_terabytes() -> None:
    with pytest.raises(HarmonicFaceError, match=r"expected arrays inside its \d+ bytes, got 'rows' of 4e\+12"):
        views(with_header(one("F32", [10**12], [0, 4 * 10**12])), "a file")


def test_bytes_behind_the_last_array() -> None:
    with pytest.raises(HarmonicFaceError, match=r"expected \d+ bytes as its header says"):
        views(with_header(one("F32", [7], [0, 28])), "a file")


def test_the_checksum_is_that_of_the_standard() -> None:
    assert checksum(bytes_of(b"abc")) == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
