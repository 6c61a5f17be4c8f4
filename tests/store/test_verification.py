"""Verification: every byte that was changed is found, and who is in it."""

from __future__ import annotations

import dataclasses
import errno
import hashlib
import json
import os

import numpy as np
import pytest

from harmonicface.store import writing
from harmonicface.store.batch import Batch
from harmonicface.store.manifest import NAME
from harmonicface.store.shard import write_shard
from harmonicface.store.verification import damages


@pytest.fixture
def path(filled):
    filled.remove("entry 4")
    filled.rename("entry 5", "five")
    return filled.path / filled.version().parts[0].listed.record.file


def test_all_is_well(filled, path) -> None:
    assert filled.verify() == ()


def test_200_random_bytes_that_are_flipped_are_all_found(filled, path) -> None:
    content = path.read_bytes()
    record = filled.version().parts[0].listed.record
    rng = np.random.default_rng(0)
    for place in rng.integers(len(content), size=200).tolist():
        bit = 1 << int(rng.integers(8))
        path.write_bytes(content[:place] + bytes([content[place] ^ bit]) + content[place + 1 :])
        (damage,) = filled.verify()
        assert damage.file == path.name
        assert str(path) in damage.reason
        assert "\n" not in damage.reason
        if place < record.directory_start:
            assert len(damage.keys) == 9
        else:
            assert len(damage.keys) <= 1  # one entry's own bytes, or one of the two directories
    path.write_bytes(content)
    assert filled.verify() == ()


def test_every_byte_of_the_common_arrays(filled, path) -> None:
    file = filled.path / filled.version().manifest.common.file
    content = file.read_bytes()
    for place in range(len(content)):
        file.write_bytes(content[:place] + bytes([content[place] ^ 0x10]) + content[place + 1 :])
        assert [damage.file for damage in filled.verify()] == [file.name]


def test_the_entry_is_named_by_its_key_of_now(filled, path, make) -> None:
    content = bytearray(path.read_bytes())
    content[bytes(content).index(make(5).arrays["sizes"].tobytes())] ^= 1
    path.write_bytes(content)
    assert [damage.keys for damage in filled.verify()] == [("five",)]


def test_common_arrays_that_were_cut_short(filled, path) -> None:
    file = filled.path / filled.version().manifest.common.file
    content = file.read_bytes()
    for length in (0, len(content) - 1):
        file.write_bytes(content[:length])
        (damage,) = filled.verify()
        assert damage.reason == f"{file}: expected {len(content)} bytes, got {length}"


def test_a_removed_entry_is_read_too_but_nobody_is_lost(filled, path, make) -> None:
    content = bytearray(path.read_bytes())
    content[bytes(content).index(make(4).arrays["sizes"].tobytes())] ^= 1
    path.write_bytes(content)
    assert [(damage.file, damage.keys) for damage in filled.verify()] == [(path.name, ())]
    filled.compact()
    assert filled.verify() == ()
    assert len(filled.version()) == 20


def test_a_shard_that_was_cut_short_or_is_longer_still_says_who_was_in_it(filled, path) -> None:
    content = path.read_bytes()
    expected = tuple("five" if n == 5 else f"entry {n}" for n in range(10) if n != 4)
    record = filled.version().parts[0].listed.record
    for changed in (content[:-1], content[: record.directory_start + record.directory_bytes], content + b"x"):
        path.write_bytes(changed)
        (damage,) = filled.verify()
        assert damage.reason == f"{path}: expected {len(content)} bytes, got {len(changed)}"
        assert (damage.keys, damage.entries) == (expected, 10)


def test_more_entries_than_memory(filled) -> None:
    content = json.loads((filled.path / NAME).read_bytes().splitlines()[0])
    content["shards"][0].update(entries=2**50, nbytes=2**60, directory_bytes=2**58)
    line = json.dumps(content).encode()
    (filled.path / NAME).write_bytes(line + b'\n{"sha256":"' + hashlib.sha256(line).hexdigest().encode() + b'"}\n')
    (damage,) = filled.verify()
    assert (damage.keys, damage.entries) == ((), 2**50)


@pytest.mark.parametrize("length", [0, 1, 100])
def test_a_shard_that_cannot_be_opened(filled, path, length) -> None:
    path.write_bytes(path.read_bytes()[:length])
    (damage,) = filled.verify()
    assert f"got {length}" in damage.reason
    assert (damage.keys, damage.entries) == ((), 10)


def test_a_disk_that_does_not_give_a_file(filled, path, monkeypatch) -> None:
    real, common = os.read, filled.path / filled.version().manifest.common.file
    unreadable = {file.stat().st_ino: file for file in (path, common)}

    def reading(handle: int, count: int) -> bytes:
        if os.fstat(handle).st_ino in unreadable:
            raise OSError(errno.EIO, "Input/output error")
        return real(handle, count)

    monkeypatch.setattr(os, "read", reading)
    reasons = [damage.reason for damage in filled.verify()]
    assert reasons == [f"{file}: expected a file that can be read, got: Input/output error" for file in (common, path)]


def test_a_file_that_is_compacted_away_meanwhile_is_not_accused(filled) -> None:
    filled.remove("entry 3")
    version = filled.version()
    filled.compact()
    assert damages(version) == ()


def test_it_tells_how_far_it_is(filled) -> None:
    told = []
    assert damages(filled.version(), lambda *what: told.append(what)) == ()
    assert told == [("shards read", 1, 3), ("shards read", 2, 3), ("shards read", 3, 3)]


def test_two_damaged_directories(filled, path) -> None:
    record = filled.version().parts[0].listed.record
    content = bytearray(path.read_bytes())
    content[record.directory_start] ^= 1
    content[-1] ^= 1
    path.write_bytes(content)
    (damage,) = filled.verify()
    assert "two damaged ones" in damage.reason
    assert damage.keys == ()


def put_unchecked(filled, entries) -> None:
    """Add what `append` refuses, with right checksums."""
    with writing.alone(filled.path, {}) as version:
        writing.put(filled.path, version, Batch(entries))


def test_nan_behind_right_checksums(filled, make) -> None:
    bad = make(30)
    bad.arrays["rows"][0, 1] = np.nan
    put_unchecked(filled, [make(29), bad])
    (damage,) = filled.verify()
    assert damage.keys == ("entry 30",)
    assert "finite" in damage.reason


def test_a_key_twice(filled, make) -> None:
    put_unchecked(filled, [make(30, "entry 2"), make(31, "entry 3")])
    found = filled.verify()
    assert [damage.keys for damage in found] == [("entry 2",), ("entry 3",)]
    assert "expected keys once" in found[0].reason


def test_a_key_that_is_no_text(filled, make, kinds) -> None:
    batch = Batch([make(30)])
    keys = batch.directory.keys.copy()
    keys[0] = 0xFF
    batch.__dict__["directory"] = dataclasses.replace(batch.directory, keys=keys)
    record = write_shard(filled.path / "0000000009.safetensors", kinds, [batch])
    content = json.loads((filled.path / NAME).read_bytes().splitlines()[0])
    content["shards"].append({**vars(record), "removed": [], "renamed": []})
    content["number"] = 10
    line = json.dumps(content).encode()
    (filled.path / NAME).write_bytes(line + b'\n{"sha256":"' + hashlib.sha256(line).hexdigest().encode() + b'"}\n')
    (damage,) = filled.verify()
    assert damage.reason == f"{filled.path / record.file}: expected a text as the key of entry 0, got other bytes"
    filled.discard_damaged()
    assert filled.verify() == ()
    assert len(filled.version()) == 21


def test_an_empty_folder(folder) -> None:
    assert folder.verify() == ()
