"""Directories: columns that come back, and are refused when they contradict themselves."""

from __future__ import annotations

import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.store import directory
from harmonicface.store.directory import Directory, key_hash, vars_of
from harmonicface.store.tensors import packed

NAMES = ["ada", "\N{SNOWMAN}", "x" * 1024]


@pytest.fixture
def some(make) -> Directory:
    return directory.of_entries([make(number, name) for number, name in enumerate(NAMES)])


def same(one: Directory, other: Directory) -> bool:
    return all(np.array_equal(vars_of(one)[name], vars_of(other)[name]) for name in vars_of(one))


def read(content: bytes, entries: int = 3, arrays: int = 3) -> Directory:
    return directory.read(np.frombuffer(content, np.uint8), entries, arrays, "a file")


def test_it_comes_back(some) -> None:
    content = some.to_bytes()
    assert len(content) % 64 == 0
    found = read(content)
    assert same(found, some)
    assert [found.key(i) for i in range(3)] == NAMES
    assert [found.about(i) for i in range(3)] == [{"number": i} for i in range(3)]
    assert found.starts.tolist() == [[0, 0, 0], [0, 1, 1], [1, 3, 2], [3, 6, 3]]
    assert found.hashes.tolist() == [key_hash(name.encode()) for name in NAMES]


def test_joined_is_as_if_made_at_once(make) -> None:
    entries = [make(number) for number in range(7)]
    parts = [directory.of_entries(entries[a:b]) for a, b in ((0, 2), (2, 3), (3, 7))]
    assert same(directory.joined(parts), directory.of_entries(entries))
    assert directory.joined(parts[:1]) is parts[0]


def test_some_are_taken_under_other_names(some, make) -> None:
    taken = some.taken(np.array([0, 2]), {2: "emmy"})
    assert same(taken, directory.of_entries([make(0, "ada"), make(2, "emmy")]))


@pytest.mark.parametrize(
    "change",
    [
        {"keys": np.zeros(5, np.uint8)},
        {"keys": np.zeros((2, 3), np.uint8)},
        {"key_ends": np.array([3, 2, 1030])},
        {"key_ends": np.array([-1, 6, 1030])},
        {"key_ends": np.array([2**62, -(2**62), 1030])},
        {"about_ends": np.array([1, 2, 3])},
        {"about_ends": np.array([1, 2])},
        {"counts": np.full((3, 3), -1)},
        {"counts": np.full((3, 3), 2**62)},
        {"counts": np.ones((3, 2), np.int64)},
        {"digests": np.zeros((3, 15), np.uint8)},
        {"hashes": np.zeros(3, np.int64)},
        {"more": np.zeros(3)},
        {"key_ends": None},
    ],
)
def test_columns_that_contradict_each_other(some, change) -> None:
    columns = {name: array for name, array in {**vars_of(some), **change}.items() if array is not None}
    with pytest.raises(HarmonicFaceError, match="a file: expected the directory of 3 entries, got one that is none"):
        read(packed(columns, {}))


def test_a_directory_of_others(some) -> None:
    with pytest.raises(HarmonicFaceError, match="expected the directory of 4 entries"):
        read(some.to_bytes(), entries=4)
    with pytest.raises(HarmonicFaceError, match="expected the directory of 0 entries"):
        read(packed({name: array[:0] for name, array in vars_of(some).items()}, {}), entries=0)


def test_keys_and_words_that_are_no_text(some) -> None:
    keys, abouts = some.keys.copy(), some.abouts.copy()
    keys[0] = 0xFF
    abouts[0] = ord("[")
    bad = Directory(**{**vars_of(some), "keys": keys, "abouts": abouts})
    with pytest.raises(HarmonicFaceError, match="expected a text as the key of entry 0"):
        bad.key(0)
    with pytest.raises(HarmonicFaceError, match="expected a JSON object about entry 0"):
        bad.about(0)
    listed = Directory(**{**vars_of(some), "abouts": np.frombuffer(b"[]3{}", np.uint8), "about_ends": np.arange(2, 6)})
    with pytest.raises(HarmonicFaceError, match="expected a JSON object about entry 0"):
        listed.about(0)
