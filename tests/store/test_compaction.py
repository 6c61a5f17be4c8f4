"""Compaction: what was removed is in no file, the order stays, damage is not copied."""

from __future__ import annotations

import errno
import os

import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.store.compaction import groups
from harmonicface.store.entry import Entry, Kind
from harmonicface.store.folder import ArrayFolder
from harmonicface.store.manifest import NAME, SHARD_NAME


def everything(folder) -> bytes:
    return b"".join(path.read_bytes() for path in sorted(folder.path.iterdir()))


def flip(path, place: int) -> None:
    content = bytearray(path.read_bytes())
    content[place] ^= 1
    path.write_bytes(content)


def test_removed_bytes_and_old_names_are_gone(filled, make, number) -> None:
    secret = make(13).arrays["sizes"].tobytes()
    filled.remove("entry 13")
    filled.rename("entry 12", "somebody")
    before = filled.version().nbytes
    content = everything(filled)
    assert secret in content
    assert b"entry 13" in content
    assert b"entry 12" in content
    assert filled.compact() == before - filled.version().nbytes > 0
    content = everything(filled)
    assert secret not in content
    assert b"entry 13" not in content
    assert b"entry 12" not in content
    assert filled.version().keys == (
        *(f"entry {n}" for n in range(12)),
        "somebody",
        *(f"entry {n}" for n in range(14, 21)),
    )
    assert [number(entry) for entry in filled.version().entries()] == [*range(13), *range(14, 21)]
    assert filled.verify() == ()
    assert len(filled.version().parts) == 1
    assert len(list(filled.path.iterdir())) == 3  # the manifest, the common arrays, one shard


def test_a_second_time_there_is_nothing_to_do(filled) -> None:
    filled.compact()
    before = filled.version().generation
    assert filled.compact() == 0
    assert filled.version().generation == before


def test_large_shards_that_have_lost_nobody_stay(filled) -> None:
    sizes = [part.listed.record.nbytes for part in filled.version().parts]
    filled.remove("entry 20")  # the last of its shard, which goes at once
    assert len(filled.version().parts) == 2
    before = {path: path.stat().st_mtime_ns for path in filled.path.iterdir() if path.name != NAME}
    assert filled.compact(shard_bytes=min(sizes[:2])) == 0
    assert {path: path.stat().st_mtime_ns for path in filled.path.iterdir() if path.name != NAME} == before
    filled.remove("entry 3")
    version = filled.version()
    assert [[part.listed.record.file for part in group] for group in groups(version, min(sizes[:2]))] == [
        [version.parts[0].listed.record.file]
    ]


def test_shards_are_joined_up_to_so_many_bytes(filled) -> None:
    largest = max(part.listed.record.nbytes for part in filled.version().parts)
    filled.remove([f"entry {n}" for n in range(0, 20, 2)])
    filled.compact(shard_bytes=largest + 100)
    assert [len(part) for part in filled.version().parts] == [10, 1]
    filled.compact(shard_bytes=1 << 20)
    assert [len(part) for part in filled.version().parts] == [11]


def test_it_stops_before_anything_is_written_when_a_shard_is_damaged(filled) -> None:
    last = filled.version().parts[2].listed.record
    flip(filled.path / last.file, last.directory_start + last.directory_bytes)
    filled.remove("entry 3")
    before = everything(filled)
    with pytest.raises(HarmonicFaceError, match=f"compact: expected shards without damage, got {last.file}"):
        filled.compact()
    assert everything(filled) == before


def test_a_damaged_copy_of_a_directory_is_written_anew(filled) -> None:
    record = filled.version().parts[0].listed.record
    flip(filled.path / record.file, record.nbytes - 1)
    assert len(filled.verify()) == 1
    filled.compact(shard_bytes=1)
    assert filled.verify() == ()
    assert len(filled.version()) == 21


def test_damaged_entries_are_discarded_and_no_others(filled, make, number) -> None:
    records = [part.listed.record for part in filled.version().parts]
    content = (filled.path / records[0].file).read_bytes()
    flip(filled.path / records[0].file, content.index(make(7).arrays["sizes"].tobytes()))
    flip(filled.path / records[0].file, content.index(make(6).arrays["sizes"].tobytes()))
    (filled.path / records[1].file).unlink()
    filled.rename("entry 7", "seven")
    filled.rename("entry 8", "eight")
    found = filled.discard_damaged()
    assert [damage.keys for damage in found] == [("entry 6", "seven"), ()]
    assert [damage.keys for damage in filled.verify()] == [()]  # bytes of those who are gone
    assert [number(entry) for entry in filled.version().entries()] == [0, 1, 2, 3, 4, 5, 8, 9, 20]
    filled.compact()
    assert filled.verify() == ()
    assert [number(entry) for entry in filled.version().entries()] == [0, 1, 2, 3, 4, 5, 8, 9, 20]
    assert "eight" in filled.version()
    assert filled.discard_damaged() == ()


def test_what_the_system_does_not_open_is_not_discarded(filled, monkeypatch) -> None:
    real = os.open

    def refusing(path, *flags, **more):
        if str(path).endswith("2.safetensors"):
            raise OSError(errno.EMFILE, "Too many open files")
        return real(path, *flags, **more)

    monkeypatch.setattr(os, "open", refusing)
    for call in (filled.discard_damaged, filled.verify, type(filled)(filled.path).version):
        with pytest.raises(HarmonicFaceError, match="Too many open files"):
            call()
    monkeypatch.undo()
    assert len(type(filled)(filled.path).version()) == 21


def test_common_arrays_that_the_system_does_not_open(filled, monkeypatch) -> None:
    real = os.open
    file = filled.version().manifest.common.file

    def refusing(path, *flags, **more):
        if str(path).endswith(file):
            raise OSError(errno.EACCES, "Permission denied")
        return real(path, *flags, **more)

    monkeypatch.setattr(os, "open", refusing)
    with pytest.raises(HarmonicFaceError, match="Permission denied"):
        filled.version()


def test_a_shard_of_which_nothing_is_left_goes(filled, make) -> None:
    record = filled.version().parts[2].listed.record
    flip(filled.path / record.file, record.directory_start + record.directory_bytes)
    assert [damage.keys for damage in filled.discard_damaged()] == [("entry 20",)]
    assert not (filled.path / record.file).exists()
    assert len(filled.version()) == 20


def test_everything_is_revised_at_once(filled, make, number) -> None:
    before = filled.version()
    filled.remove("entry 3")
    filled.rename("entry 4", "four")

    def doubled(entry: Entry) -> Entry:
        assert len(ArrayFolder(filled.path).version()) == 20  # nobody sees a part of it
        return Entry(entry.key, {"twice": 2 * entry.arrays["sizes"][0]}, {"was": entry.about["number"]})

    filled.revise(doubled, {"twice": Kind(np.dtype("f8"), (2,))}, {"version": 2}, {}, shard_bytes=200)
    after = ArrayFolder(filled.path).version()
    assert after.keys == ("entry 0", "entry 1", "entry 2", "four", *(f"entry {n}" for n in range(5, 21)))
    assert (after.about, dict(after.common), len(after.parts)) == ({"version": 2}, {}, 3)
    for entry in after.entries():
        assert (entry.arrays["twice"] == 2 * entry.about["was"]).all()
    assert [number(entry) for entry in before.entries()] == list(range(21))
    assert {path.name for path in filled.path.iterdir()} == after.manifest.files | {NAME}
    assert filled.verify() == ()
    filled.revise(lambda entry: entry)
    assert filled.version().keys == after.keys
    assert filled.version().about == {"version": 2}


def test_a_revision_that_fails_changes_nothing(filled, make) -> None:
    before = ArrayFolder(filled.path).version().manifest
    with pytest.raises(HarmonicFaceError, match="change: expected an Entry of key 'entry 0', got"):
        filled.revise(lambda entry: Entry("other", entry.arrays))
    with pytest.raises(HarmonicFaceError, match="change: expected an Entry of key 'entry 12', got NoneType None"):
        filled.revise(lambda entry: None if entry.key == "entry 12" else entry, shard_bytes=100)
    with pytest.raises(HarmonicFaceError, match="kinds: expected a Kind"):
        filled.revise(lambda entry: entry, {})
    with pytest.raises(HarmonicFaceError, match=r"'entry 0': expected arrays \['x'\]"):
        filled.revise(lambda entry: entry, {"x": Kind(np.dtype("f4"))})
    assert ArrayFolder(filled.path).version().manifest == before
    last = filled.version().parts[2].listed.record
    flip(filled.path / last.file, last.directory_start + last.directory_bytes)
    with pytest.raises(HarmonicFaceError, match="revise: expected shards without damage"):
        filled.revise(lambda entry: entry)
    assert {path.name for path in filled.path.iterdir()} == before.files | {NAME}


def test_a_loss_of_power_does_not_bring_back_what_was_removed(filled, monkeypatch) -> None:
    fsync, seen = os.fsync, []

    def noted(handle: int) -> None:
        fsync(handle)
        seen.append({path.name for path in filled.path.iterdir()} if os.fstat(handle).st_ino == node else None)

    node = filled.path.stat().st_ino
    filled.remove("entry 3")
    monkeypatch.setattr(os, "fsync", noted)
    filled.compact()
    assert seen[-1] == filled.version().manifest.files | {NAME}


def test_what_cannot_be_removed_is_told(filled, monkeypatch) -> None:
    filled.remove("entry 3")
    file = filled.path / filled.version().parts[0].listed.record.file

    real = os.unlink

    def refusing(path, **more):
        if SHARD_NAME.fullmatch(path.name):
            raise PermissionError(errno.EACCES, "Permission denied")
        real(path, **more)

    monkeypatch.setattr(os, "unlink", refusing)
    with pytest.raises(HarmonicFaceError, match=f"compact: expected to remove {file}, .* could not"):
        filled.compact()
    filled.rename("entry 4", "four")  # nobody else is in its way
    monkeypatch.undo()
    filled.rename("four", "entry 4")
    assert {path.name for path in filled.path.iterdir()} == filled.version().manifest.files | {NAME}
