"""Writing: durable in the right order, without what killed writers left, and never copying damage."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.store import writing
from harmonicface.store.entry import Entry, Kind
from harmonicface.store.folder import ArrayFolder
from harmonicface.store.manifest import NAME


class Disk:
    """What of a folder is on the disk for certain: files as they were fsynced, names as the folder was.

    After every step it builds what a loss of power may leave: the names of the last fsync of the folder, or those of
    now, with every file as it was fsynced last (empty if it never was).
    """

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch, image: Path) -> None:
        self.folder, self.image = folder, image
        self.content = {path.stat().st_ino: path.read_bytes() for path in folder.iterdir()}
        self.names = self._names()
        self.check = lambda image: None
        self.images = 0
        fsync, replace, unlink = os.fsync, os.replace, os.unlink
        monkeypatch.setattr(os, "fsync", lambda handle: (fsync(handle), self._synced(handle)))
        monkeypatch.setattr(os, "replace", lambda *paths: (replace(*paths), self._lost()))
        monkeypatch.setattr(os, "unlink", lambda *paths, **more: (unlink(*paths, **more), self._lost()))
        self._fsync = fsync

    def _names(self) -> dict[str, int]:
        return {path.name: path.stat().st_ino for path in self.folder.iterdir()}

    def _synced(self, handle: int) -> None:
        found = os.fstat(handle)
        if os.path.isdir(handle):  # noqa: PTH112 - a file handle
            if found.st_ino == self.folder.stat().st_ino:
                self.names = self._names()
        else:
            with open(f"/proc/self/fd/{handle}", "rb") as stream:  # noqa: PTH123 - a file handle
                self.content[found.st_ino] = stream.read()
        self._lost()

    def _lost(self) -> None:
        for names in (self.names, self._names()):
            self.images += 1
            image = self.image / str(self.images)
            image.mkdir()
            for name, node in names.items():
                (image / name).write_bytes(self.content.get(node, b""))
            self.check(image)


def test_a_loss_of_power_at_any_step_loses_nothing_that_was_acknowledged(folder, make, monkeypatch, tmp_path) -> None:
    folder.append([make(0)])
    (tmp_path / "images").mkdir()
    disk = Disk(folder.path, monkeypatch, tmp_path / "images")
    before: tuple[str, ...] = ("entry 0",)
    after: tuple[str, ...] = before

    def check(image: Path) -> None:
        survivor = ArrayFolder(image)
        assert survivor.version().keys in (before, after)
        assert survivor.verify() == ()

    disk.check = check
    steps = [(lambda n=n: folder.append([make(n)]), lambda keys, n=n: (*keys, f"entry {n}")) for n in range(1, 10)]
    steps.insert(4, (lambda: folder.remove("entry 2"), lambda keys: tuple(k for k in keys if k != "entry 2")))
    steps.insert(
        6, (lambda: folder.rename("entry 1", "one"), lambda keys: tuple("one" if k == "entry 1" else k for k in keys))
    )
    steps.append((lambda: folder.describe({"a": 1}, {"more": np.ones(3)}), lambda keys: keys))
    steps.append((lambda: folder.compact(), lambda keys: keys))
    for step, result in steps:
        after = result(before)
        step()
        before = after
        (disk.image / "acknowledged").mkdir(exist_ok=True)
        for path in (disk.image / "acknowledged").iterdir():
            path.unlink()
        for name, node in disk.names.items():
            (disk.image / "acknowledged" / name).write_bytes(disk.content.get(node, b""))
        assert ArrayFolder(disk.image / "acknowledged").version().keys == after
    assert disk.images > 100


def test_what_others_put_there_is_left_alone_and_strays_are_removed(filled, make) -> None:
    theirs = ["notes.txt", "1.safetensors", ".hidden", "x0000000077.safetensors"]
    strays = ["0000000077.safetensors", ".0000000078.partial-abc_1.safetensors", ".manifest.partial-abc.json"]
    for name in theirs + strays:
        (filled.path / name).write_bytes(b"x")
    before = {path.name for path in filled.path.iterdir()} - set(strays)
    filled.rename("entry 1", "one")
    assert {path.name for path in filled.path.iterdir()} == before


def test_a_damaged_shard_is_not_copied_into_a_new_one(folder, make, number) -> None:
    folder.append([make(0)])
    (part,) = folder.version().parts
    file = folder.path / part.listed.record.file
    content = bytearray(file.read_bytes())
    content[part.listed.record.directory_start + part.listed.record.directory_bytes] ^= 1
    file.write_bytes(content)
    for n in range(1, 40):
        folder.append([make(n)])
    assert file.exists()
    assert [damage.keys for damage in folder.verify()] == [("entry 0",)]
    assert len(folder.version()) == 40
    assert len(folder.version().parts) < 10
    assert [number(folder.version().entry(f"entry {n}")) for n in range(1, 40)] == list(range(1, 40))


def test_shards_that_cannot_be_opened_stay_and_writing_goes_on(filled, make) -> None:
    last = filled.version().parts[2].listed.record.file
    (filled.path / last).rename(filled.path / "elsewhere")
    ArrayFolder(filled.path).append([make(30)])
    with pytest.raises(HarmonicFaceError, match=last):
        ArrayFolder(filled.path).version()
    (filled.path / "elsewhere").rename(filled.path / last)  # restored from a copy
    assert filled.version().keys == (*(f"entry {n}" for n in range(21)), "entry 30")


@pytest.mark.parametrize("name", ["", "a b", "../x", "padding"])
def test_common_arrays_of_names_that_are_none(filled, name) -> None:
    with pytest.raises(HarmonicFaceError, match="common: expected names of arrays, got"):
        filled.describe(common={name: np.ones(2)})


@pytest.mark.parametrize(
    "array", [[1.0], np.array(["a"]), np.array([1, np.nan]), np.ones(2, object), np.ones(2, ">f8"), np.ones((1,) * 9)]
)
def test_common_arrays_that_are_none(filled, array) -> None:
    with pytest.raises(HarmonicFaceError, match="common, mask: expected an array of finite numbers, got"):
        filled.describe(common={"mask": array})


def test_entries_are_found_by_the_keys_of_now(filled) -> None:
    filled.rename("entry 1", "one")
    version = filled.version()
    assert writing.place_of(version, "one") == (0, 1)
    assert writing.place_of(version, "entry 1") is None
    writing.check_new(version, ["entry 1", "nobody"])
    with pytest.raises(HarmonicFaceError, match="got 'entry 12', which is"):
        writing.check_new(version, ["nobody", "entry 12"])


def test_the_manifest_is_never_a_stray(filled) -> None:
    writing.sweep(filled.path, set())
    assert [path.name for path in filled.path.iterdir()] == [NAME]


def test_more_common_arrays_than_a_header_holds(filled) -> None:
    before = filled.version().manifest
    with pytest.raises(HarmonicFaceError, match="expected a header of at most 1048576 bytes"):
        filled.describe(common={f"array_{n}": np.zeros(0) for n in range(20_000)})
    assert filled.version().manifest == before


def test_as_many_kinds_as_there_may_be(tmp_path) -> None:
    kinds = {name.ljust(64, "x"): Kind(np.dtype("u1"), (1,) * 7) for name in "ab"}
    kinds.update({f"x{n}".ljust(64, "y"): Kind(np.dtype("u1"), (2**39,)) for n in range(62)})
    folder = ArrayFolder.create(tmp_path / "folder", kinds)
    empty = {name: np.zeros((0, *kind.shape), np.uint8) for name, kind in kinds.items()}
    folder.append([Entry("nothing", empty)])
    assert ArrayFolder(folder.path).version().entry("nothing").nbytes == 0
    assert folder.verify() == ()
