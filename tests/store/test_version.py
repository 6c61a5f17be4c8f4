"""Versions: a folder as it was, whatever writers do meanwhile."""

from __future__ import annotations

import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.store import version as versions
from harmonicface.store.manifest import NAME, read_manifest


def flip(path, place: int) -> None:
    content = bytearray(path.read_bytes())
    content[place] ^= 1
    path.write_bytes(content)


def test_what_is_in_it(filled, number, kinds) -> None:
    found = filled.version()
    assert found.keys == tuple(f"entry {n}" for n in range(21))
    assert len(found) == 21
    assert [number(entry) for entry in found.entries()] == list(range(21))
    assert number(found.entry("entry 13")) == 13
    assert "entry 13" in found
    assert "entry 21" not in found
    assert 13 not in found
    assert found.kinds == kinds
    assert found.about == {"what": "a test"}
    assert found.common["mask"].sum() == 3
    assert found.generation == 3
    assert found.nbytes == sum(one.stat().st_size for one in filled.path.iterdir() if one.name != NAME)


def test_nobody_of_that_key(filled) -> None:
    with pytest.raises(HarmonicFaceError, match="key: expected one that is in the folder, got 'ada', which is not"):
        filled.version().entry("ada")
    with pytest.raises(HarmonicFaceError, match="key: expected a text"):
        filled.version().entry("")


def test_it_stays_what_it_is(filled, make, number) -> None:
    before = filled.version()
    filled.remove(["entry 0", "entry 20"])
    filled.rename("entry 1", "one")
    filled.append([make(30)])
    filled.describe({"what": "else"}, {})
    filled.compact()
    assert [number(entry) for entry in before.entries()] == list(range(21))
    assert before.keys == tuple(f"entry {n}" for n in range(21))
    assert before.common["mask"].sum() == 3
    assert before.about == {"what": "a test"}
    after = filled.version()
    assert after.keys == ("one", *(f"entry {n}" for n in range(2, 20)), "entry 30")
    assert dict(after.common) == {}


def test_opening_maps_and_reads_no_directory(filled, monkeypatch) -> None:
    def fail(*_):
        raise AssertionError("a directory was read")

    monkeypatch.setattr("harmonicface.store.shard.read", fail)
    assert len(type(filled)(filled.path).version()) == 21


def test_a_damaged_shard_is_refused_or_left_out(filled, number) -> None:
    first = filled.version().parts[0].listed.record
    flip(filled.path / first.file, 20)
    with pytest.raises(HarmonicFaceError, match=rf"{first.file}: expected the header it was written with"):
        type(filled)(filled.path).version()
    found = type(filled)(filled.path).version(leave_out_damaged=True)
    assert [number(entry) for entry in found.entries()] == list(range(10, 21))
    (damage,) = found.damaged
    assert damage.keys == tuple(f"entry {n}" for n in range(10))
    assert "entry 3" not in found


def test_a_shard_of_which_nobody_knows_who_is_in_it(filled) -> None:
    first = filled.version().parts[0].listed.record
    (filled.path / first.file).unlink()
    found = type(filled)(filled.path).version(leave_out_damaged=True)
    assert [(damage.file, damage.keys, damage.entries) for damage in found.damaged] == [(first.file, (), 10)]


def test_both_directories_damaged(filled) -> None:
    record = filled.version().parts[0].listed.record
    flip(filled.path / record.file, record.directory_start + 5)
    flip(filled.path / record.file, record.nbytes - 5)
    found = type(filled)(filled.path).version(leave_out_damaged=True)
    assert [damage.keys for damage in found.damaged] == [()]
    assert len(found) == 11
    with pytest.raises(HarmonicFaceError, match="two damaged ones"):
        _ = type(filled)(filled.path).version().keys


@pytest.mark.parametrize("place", [3, 20])
def test_damaged_common_arrays_are_refused_when_they_are_asked_for(filled, place) -> None:
    flip(filled.path / read_manifest(filled.path).common.file, place)
    found = type(filled)(filled.path).version()
    assert len(found) == 21
    with pytest.raises(HarmonicFaceError, match="expected"):
        _ = found.common
    assert found.common_damage().reason.startswith(str(filled.path))


def test_common_arrays_are_read_for_their_damage(filled) -> None:
    assert filled.version().common_damage() is None
    said = read_manifest(filled.path).common
    flip(filled.path / said.file, said.nbytes - 1)
    damage = filled.version().common_damage()
    assert "expected the checksum it was written with" in damage.reason
    filled.describe(common={})
    assert filled.version().common_damage() is None


def test_a_writer_between_the_manifest_and_the_shards(filled, monkeypatch, number) -> None:
    """The manifest that is read first names shards that are gone when they are opened."""
    read, happened = versions.read_manifest, []

    def late(folder):
        manifest = read(folder)
        if not happened:
            happened.append(True)
            filled.remove("entry 0")
            filled.compact()
        return manifest

    monkeypatch.setattr(versions, "read_manifest", late)
    reader = type(filled)(filled.path)
    assert [number(entry) for entry in reader.version().entries()] == list(range(1, 21))
    assert happened
