"""A folder that is made with everything in it: there whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.store.entry import Entry, Kind
from harmonicface.store.folder import ArrayFolder
from harmonicface.store.whole import TakenError, make_whole
from harmonicface.store.writing import OutdatedError

KINDS = {"rows": Kind(np.dtype("f4"), (3,))}
COMMON = {"mask": np.ones((2, 2), np.bool_)}


def entry(key: str) -> Entry:
    return Entry(key, {"rows": np.full((2, 3), len(key), np.float32)}, {"number": len(key)})


def made(path: Path, *keys: str) -> ArrayFolder:
    make_whole(path, map(entry, keys), KINDS, {"what": "people"}, COMMON)
    return ArrayFolder(path)


def test_everything_is_there(tmp_path: Path) -> None:
    (tmp_path / "people").mkdir()
    version = made(tmp_path / "people", "a", "bb").version()
    assert version.keys == ("a", "bb")
    assert version.about == {"what": "people"}
    assert version.common["mask"].all()
    assert [one.name for one in tmp_path.iterdir()] == ["people"]


def test_an_empty_folder_behind_a_link(tmp_path: Path) -> None:
    (tmp_path / "disk").mkdir()
    (tmp_path / "disk" / "empty").mkdir()
    (tmp_path / "people").symlink_to(tmp_path / "disk" / "empty")
    assert made(tmp_path / "people", "a").version().keys == ("a",)
    assert (tmp_path / "people").is_symlink()
    assert [one.name for one in (tmp_path / "disk").iterdir()] == ["empty"]


def test_nothing_is_beside_it_when_it_is_made_durable(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real, seen = os.fsync, []

    def noted(handle: int) -> None:
        real(handle)
        if os.fstat(handle).st_ino == tmp_path.stat().st_ino:
            seen.append([one.name for one in tmp_path.iterdir()])

    monkeypatch.setattr(os, "fsync", noted)
    made(tmp_path / "people", "a")
    assert seen[-1] == ["people"]


def test_what_is_interrupted_leaves_nothing(tmp_path: Path) -> None:
    def interrupted() -> Iterator[Entry]:
        yield entry("a")
        assert [one.name.startswith(".people.partial-") for one in tmp_path.iterdir()] == [True]
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make_whole(tmp_path / "people", interrupted(), KINDS, {}, COMMON)
    assert list(tmp_path.iterdir()) == []


def test_what_the_dead_left_is_removed_and_what_the_living_make_is_not(tmp_path: Path) -> None:
    (tmp_path / ".people.partial-dead").mkdir()
    (tmp_path / ".people.partial-dead" / "file").write_text("of a dead writer")

    def entries() -> Iterator[Entry]:
        made(tmp_path / "people", "meanwhile")
        yield entry("a")

    with pytest.raises(TakenError, match=r"cannot make the folder .*people: Directory not empty"):
        make_whole(tmp_path / "people", entries(), KINDS, {}, COMMON)
    assert ArrayFolder(tmp_path / "people").version().keys == ("meanwhile",)
    assert [one.name for one in tmp_path.iterdir()] == ["people"]


def test_what_is_in_the_way_stays(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    with pytest.raises(TakenError, match=r"cannot make the folder .*file: Not a directory"):
        made(tmp_path / "file", "a")
    assert (tmp_path / "file").read_text() == "mine"
    with pytest.raises(HarmonicFaceError, match=r"cannot make the folder .*none.*: expected a folder .*none, got none"):
        made(tmp_path / "none" / "people", "a")
    with pytest.raises(HarmonicFaceError, match=r"cannot make the folder .*: File name too long"):
        made(tmp_path / ("n" * 300), "a")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_where_nobody_may_write(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(HarmonicFaceError, match=r"cannot make the folder .*: Permission denied"):
        made(tmp_path / "people", "a")


def test_other_entries_take_the_place_of_all_at_once(tmp_path: Path) -> None:
    folder = made(tmp_path / "people", "a", "bb")
    before = folder.version()
    wide = {"rows": Kind(np.dtype("f4"), (3,)), "more": Kind(np.dtype("i4"))}

    def entries(*keys: str) -> Iterator[Entry]:
        for key in keys:
            assert folder.version().keys == ("a", "bb")
            yield Entry(key, {**entry(key).arrays, "more": np.arange(2, dtype=np.int32)})

    for keys, message in (
        (("c", "c"), "got 'c' twice"),
        (("d", "e", "d"), "key: expected every one once, got 'd' twice"),
    ):
        with pytest.raises(HarmonicFaceError, match=message):
            folder.replace(entries(*keys), wide, {"what": "others"}, {}, shard_bytes=1)
        assert folder.version().keys == ("a", "bb")
    folder.replace(entries("ccc", "a"), wide, {"what": "others"}, {}, shard_bytes=1)
    version = folder.version()
    assert (version.keys, version.about, dict(version.common)) == (("ccc", "a"), {"what": "others"}, {})
    assert version.entry("a").arrays["more"].tolist() == [0, 1]
    assert before.entry("bb").arrays["rows"].tolist() == [[2.0] * 3] * 2
    assert folder.verify() == ()
    assert {one.name for one in folder.path.iterdir()} == version.manifest.files | {"manifest.json"}


@pytest.mark.parametrize("change", ["common", "kinds"])
def test_entries_that_were_made_for_another_version(tmp_path: Path, change: str) -> None:
    folder = made(tmp_path / "people", "a")
    version = folder.version()
    folder.append([entry("bb")], made_for=version)
    folder.rename("bb", "b")
    folder.append([entry("ccc")], made_for=version)
    if change == "common":
        folder.describe(common=COMMON)
    else:
        more = {**KINDS, "more": Kind(np.dtype("i4"))}
        folder.revise(lambda one: Entry(one.key, {**one.arrays, "more": np.zeros(0, np.int32)}, one.about), more)
    with pytest.raises(OutdatedError, match="append: expected entries made with the folder's own arrays"):
        folder.append([entry("dddd")], made_for=version)

    def entries() -> Iterator[Entry]:
        folder.describe(common={"mask": np.zeros((2, 2), np.bool_)})
        yield Entry("e", folder.version().entry("a").arrays)

    with pytest.raises(OutdatedError):
        folder.append(entries(), made_for=folder.version())
    assert folder.version().keys == ("a", "b", "ccc")
