"""Entries: what may be kept."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.store.entry import Entry, Kind, about_text, checked_entry, checked_key, digest, is_finite

KINDS = {"rows": Kind(np.dtype("f4"), (3,)), "marks": Kind(np.dtype("i8"))}
GOOD = Entry("ada", {"rows": np.ones((2, 3), np.float32), "marks": np.arange(4)}, {"a": [1, None]})


def test_a_good_entry_is_kept_as_it_is() -> None:
    found = checked_entry(GOOD, KINDS)
    assert (found.key, found.about) == (GOOD.key, GOOD.about)
    assert all(np.array_equal(found.arrays[name], GOOD.arrays[name]) for name in KINDS)
    assert GOOD.nbytes == 2 * 3 * 4 + 4 * 8


def test_arrays_become_contiguous() -> None:
    rows = np.arange(12, dtype=np.float32).reshape(4, 3)[::2]
    found = checked_entry(dataclasses.replace(GOOD, arrays={**GOOD.arrays, "rows": rows}), KINDS).arrays["rows"]
    assert found.flags.c_contiguous
    assert np.array_equal(found, rows)


def test_a_kind_tells_its_bytes_and_takes_the_name_of_a_type() -> None:
    assert (KINDS["rows"].row_bytes, KINDS["marks"].row_bytes) == (12, 8)
    assert Kind("f2", (2,)).dtype == np.float16  # type: ignore[arg-type]


@pytest.mark.parametrize("dtype", [object, "c8", "U3", ">f4", "M8[s]"])
def test_a_type_that_files_do_not_have(dtype: object) -> None:
    with pytest.raises(HarmonicFaceError, match="dtype: expected one of"):
        Kind(dtype)  # type: ignore[arg-type]


def test_no_type() -> None:
    with pytest.raises(HarmonicFaceError, match="dtype: expected a type of numbers"):
        Kind("nothing")  # type: ignore[arg-type]


@pytest.mark.parametrize("shape", [(0,), (-1,), (2.0,), (True,), (2**50,), (1,) * 8])
def test_a_shape_that_is_none(shape: tuple[int, ...]) -> None:
    with pytest.raises(HarmonicFaceError, match="shape: expected at most 7 sides above 0"):
        Kind(np.dtype("f4"), shape)


@pytest.mark.parametrize("key", ["", "x" * 1025, "\N{SNOWMAN}" * 400, "\ud800", 3, None, b"ada"])
def test_a_key_that_is_none(key: object) -> None:
    with pytest.raises(HarmonicFaceError, match="key: expected a text of 1 to 1024 bytes, got "):
        checked_key(key)


@pytest.mark.parametrize("key", ["x", "../../etc/passwd", "a\nb\0", "\N{SNOWMAN}" * 341])
def test_any_other_text_is_a_key(key: str) -> None:
    assert checked_key(key) == key


@pytest.mark.parametrize("about", [{"a": {1, 2}}, {"a": np.nan}, {"a": object()}, {(1, 2): 3}])
def test_words_that_json_cannot_say(about: dict) -> None:
    with pytest.raises(HarmonicFaceError, match="about: expected what JSON can say"):
        about_text(about)


def test_words_that_are_no_dict_or_too_many() -> None:
    with pytest.raises(HarmonicFaceError, match="about: expected a dict"):
        about_text([1])  # type: ignore[arg-type]
    with pytest.raises(HarmonicFaceError, match="about: expected at most 65536 bytes of JSON"):
        about_text({"a": "x" * 70_000})


def test_what_is_no_entry() -> None:
    with pytest.raises(HarmonicFaceError, match="entry: expected an Entry"):
        checked_entry(("ada", {}), KINDS)  # type: ignore[arg-type]


@pytest.mark.parametrize("arrays", [{}, {"rows": GOOD.arrays["rows"]}, {**GOOD.arrays, "more": np.ones(1)}])
def test_other_arrays(arrays: dict) -> None:
    with pytest.raises(HarmonicFaceError, match=r"'ada': expected arrays \['marks', 'rows'\]"):
        checked_entry(dataclasses.replace(GOOD, arrays=arrays), KINDS)


@pytest.mark.parametrize(
    "rows",
    [
        np.ones((2, 3)),
        np.ones((2, 4), np.float32),
        np.ones(3, np.float32),
        np.ones((), np.float32),
        np.ones((1, 2, 3), np.float32),
        np.ones((2, 3), ">f4"),
        [[1.0, 2.0, 3.0]],
    ],
)
def test_another_type_or_shape(rows: object) -> None:
    with pytest.raises(HarmonicFaceError, match=r"'ada', rows: expected an array \(rows, 3\) of float32, got"):
        checked_entry(dataclasses.replace(GOOD, arrays={**GOOD.arrays, "rows": rows}), KINDS)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_not_finite(bad: float) -> None:
    rows = np.ones((2, 3), np.float32)
    rows[1, 2] = bad
    assert not is_finite(rows)
    with pytest.raises(HarmonicFaceError, match="'ada', rows: expected finite numbers"):
        checked_entry(dataclasses.replace(GOOD, arrays={**GOOD.arrays, "rows": rows}), KINDS)


def test_the_checksum_tells_every_byte_and_bears_no_rows() -> None:
    arrays = {"a": np.zeros((0, 3), np.float32), "b": np.arange(4)}
    before = digest(arrays)
    assert len(before) == 16
    for place in range(arrays["b"].nbytes):
        arrays["b"].view(np.uint8)[place] ^= 1
        assert digest(arrays) != before
        arrays["b"].view(np.uint8)[place] ^= 1
