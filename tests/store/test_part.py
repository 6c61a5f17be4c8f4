"""Parts: a shard without those who are gone, by the keys of now."""

from __future__ import annotations

import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.store import directory, part
from harmonicface.store.batch import Batch
from harmonicface.store.entry import digest
from harmonicface.store.manifest import Listed
from harmonicface.store.part import Part
from harmonicface.store.shard import Shard, write_shard


@pytest.fixture
def some(tmp_path, kinds, make) -> Part:
    path = tmp_path / "0000000000.safetensors"
    record = write_shard(path, kinds, [Batch([make(number) for number in range(8)])])
    return Part(Shard(path, record, kinds), Listed(record, (0, 3, 4), {5: "five"}))


def test_who_is_in_it(some) -> None:
    keys = ["entry 1", "entry 2", "five", "entry 6", "entry 7"]
    assert some.keys == keys
    assert len(some) == len(keys)
    assert some.changed
    assert some.alive.tolist() == [False, True, True, False, False, True, True, True]
    assert [some.find(key) for key in keys] == [1, 2, 5, 6, 7]
    assert [some.find(key) for key in ("entry 0", "entry 3", "entry 5", "nobody")] == [None] * 4


def test_an_entry(some, number) -> None:
    assert [number(some.entry(index)) for index in some.indices.tolist()] == [1, 2, 5, 6, 7]
    assert some.entry(5).key == "five"


@pytest.mark.parametrize("most", [1, 60, 1 << 24])
def test_its_pieces_are_the_rows_of_those_who_are_in_it(some, make, most, monkeypatch) -> None:
    monkeypatch.setattr(part, "PIECE", most)
    for name in ("rows", "marks", "sizes"):
        expected = np.concatenate([make(number).arrays[name] for number in (1, 2, 5, 6, 7)])
        pieces = list(some.pieces(name))
        np.testing.assert_array_equal(np.concatenate(pieces), expected)
        assert all(piece.nbytes <= max(most, some.shard.kinds[name].row_bytes) for piece in pieces)


def test_its_directory_is_that_of_a_new_shard(some, make) -> None:
    expected = directory.of_entries([make(n, "five" if n == 5 else None) for n in (1, 2, 5, 6, 7)])
    for name, column in directory.vars_of(expected).items():
        np.testing.assert_array_equal(getattr(some.directory, name), column)


def test_nothing_changed(some) -> None:
    as_written = Part(some.shard, Listed(some.listed.record))
    assert not as_written.changed
    assert as_written.directory is some.shard.directory


def test_keys_of_the_same_hash_are_told_apart(some, monkeypatch) -> None:
    monkeypatch.setattr(part, "key_hash", lambda key: 7)
    some.__dict__["hashes"] = np.full(8, 7, np.uint64)
    assert [some.find(key) for key in ("entry 1", "five", "nobody")] == [1, 5, None]


def test_nan_in_a_shard_of_right_checksums_is_refused(tmp_path, kinds, make) -> None:
    entry = make(1)
    entry.arrays["rows"][0, 0] = np.nan
    path = tmp_path / "0000000000.safetensors"
    record = write_shard(path, kinds, [Batch([entry])])
    found = Part(Shard(path, record, kinds), Listed(record))
    assert found.shard.directory.digests[0].tobytes() == digest(entry.arrays)
    with pytest.raises(HarmonicFaceError, match="'entry 1', rows: expected finite numbers, got NaN"):
        found.entry(0)


def test_damage_names_everybody_who_is_known(some, tmp_path) -> None:
    assert some.damage("a reason").keys == tuple(some.keys)
    some.shard.path.write_bytes(b"")
    gone = Part(Shard(some.shard.path, some.listed.record, some.shard.kinds), some.listed)
    found = gone.damage("a reason")
    assert (found.file, found.reason, found.keys, found.entries) == ("0000000000.safetensors", "a reason", (), 8)
