"""A folder of a few entries, and how to make others."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from harmonicface.store.entry import Entry, Kind
from harmonicface.store.folder import ArrayFolder

KINDS = {"rows": Kind(np.dtype("f4"), (5,)), "marks": Kind(np.dtype("u1")), "sizes": Kind(np.dtype("f8"), (2, 2))}


def an_entry(number: int, key: str | None = None) -> Entry:
    """Return an entry whose arrays all tell its number."""
    rows = number % 4
    arrays = {
        "rows": np.full((rows + 1, 5), number, np.float32),
        "marks": np.full(rows, number % 256, np.uint8),
        "sizes": np.full((1, 2, 2), number, np.float64),
    }
    return Entry(key or f"entry {number}", arrays, {"number": number})


def number_of(entry: Entry) -> int:
    """Return the number that all of an entry tells, or fail."""
    number = entry.about["number"]
    expected = an_entry(number)
    for name, array in expected.arrays.items():
        np.testing.assert_array_equal(entry.arrays[name], array)
        assert entry.arrays[name].dtype == array.dtype
    return int(number)


@pytest.fixture
def make() -> Callable[..., Entry]:
    return an_entry


@pytest.fixture
def number() -> Callable[[Entry], int]:
    return number_of


@pytest.fixture
def folder(tmp_path: Path) -> ArrayFolder:
    """Return an empty folder."""
    return ArrayFolder.create(tmp_path / "folder", KINDS, {"what": "a test"}, {"mask": np.eye(3, dtype=np.bool_)})


@pytest.fixture
def filled(folder: ArrayFolder, monkeypatch: pytest.MonkeyPatch) -> ArrayFolder:
    """Return a folder of three shards with entries 0 to 9, 10 to 19 and 20."""
    monkeypatch.setattr("harmonicface.store.writing.taken_in", lambda sizes, new: 0)
    folder.append(an_entry(number) for number in range(10))
    folder.append(an_entry(number) for number in range(10, 20))
    folder.append([an_entry(20)])
    return folder


@pytest.fixture
def kinds() -> dict[str, Kind]:
    return KINDS
