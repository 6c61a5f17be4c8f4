"""Manifests: back as written, or refused in one line."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path

import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.store.folder import ArrayFolder
from harmonicface.store.manifest import NAME, read_manifest, write_manifest


def written(folder: Path, change) -> None:
    """Change a manifest and give it the right checksum."""
    content = json.loads((folder / NAME).read_bytes().splitlines()[0])
    content = change(content) or content
    line = json.dumps(content).encode()
    (folder / NAME).write_bytes(line + b'\n{"sha256":"' + hashlib.sha256(line).hexdigest().encode() + b'"}\n')


def refused(folder: Path) -> str:
    with pytest.raises(HarmonicFaceError) as caught:
        read_manifest(folder)
    assert "\n" not in str(caught.value)
    assert "expected" in str(caught.value)
    return str(caught.value)


@pytest.fixture
def path(filled) -> Path:
    filled.remove(["entry 3", "entry 1"])
    filled.rename("entry 12", "\N{SNOWMAN}\n")
    return filled.path


def test_it_comes_back(path) -> None:
    manifest = read_manifest(path)
    assert [one.record.entries for one in manifest.shards] == [10, 10, 1]
    assert manifest.shards[0].removed == (1, 3)
    assert manifest.shards[1].renamed == {2: "\N{SNOWMAN}\n"}
    assert manifest.about == {"what": "a test"}
    assert manifest.generation == 5
    before = (path / NAME).read_bytes()
    write_manifest(path, manifest)
    assert (path / NAME).read_bytes() == before
    assert manifest.files | {NAME} == {one.name for one in path.iterdir()}


def test_every_byte_that_is_changed_and_every_cut_is_noticed(path) -> None:
    content = (path / NAME).read_bytes()
    for place in [*range(0, len(content), 17), len(content) - 1]:
        (path / NAME).write_bytes(content[:place] + bytes([content[place] ^ 0x20]) + content[place + 1 :])
        assert "checksum" in refused(path)
        (path / NAME).write_bytes(content[:place])
        assert "checksum" in refused(path)
    (path / NAME).write_bytes(content + b" ")
    assert "checksum" in refused(path)


@pytest.mark.parametrize("file", ["../0000000000.safetensors", "/etc/passwd", "a/0000000000.safetensors", "x", "", 3])
def test_a_manifest_that_points_outside_the_folder(path, file) -> None:
    written(path, lambda content: content["shards"][0].update(file=file))
    assert "expected files in its own folder, got" in refused(path)


def test_common_arrays_outside_the_folder(path) -> None:
    written(path, lambda content: content["common"].update(file="../../0000000000.safetensors"))
    assert "expected files in its own folder, got" in refused(path)


def test_another_kind_of_manifest_and_another_version(path) -> None:
    written(path, lambda content: content.update(version=2))
    assert "expected version 1 of the format, got 2" in refused(path)
    written(path, lambda content: content.update(format="a shop"))
    assert "expected a harmonicface store, got 'a shop'" in refused(path)


def shard(**changes):
    return lambda content: content["shards"][0].update(changes)


@pytest.mark.parametrize(
    "change",
    [
        lambda content: [1],
        lambda content: content.pop("kinds") and None,
        lambda content: content.update(kinds={}),
        lambda content: content.update(kinds={"rows": {"dtype": "F33", "shape": []}}),
        lambda content: content.update(kinds=[1]),
        lambda content: content.update(about=3),
        lambda content: content.update(number=0),
        lambda content: content.update(number=True),
        lambda content: content.update(generation=-1),
        lambda content: content.update(generation=1.0),
        lambda content: content.update(shards={}) or content.update(shards=[3]),
        lambda content: content["shards"].append(content["shards"][0]),
        lambda content: content["common"].update(digest="x"),
        shard(nbytes=2**80),
        shard(nbytes=0, directory_start=0, directory_bytes=0),
        shard(nbytes=100),
        shard(entries=0),
        shard(entries=10**15),
        shard(header="A" * 64),
        shard(directory_start="1"),
        shard(removed=[3, 1]),
        shard(removed=[1, 1]),
        shard(removed=[10]),
        shard(renamed=[[10, "a"]]),
        shard(renamed=[[5, "a"], [5, "b"]]),
        shard(renamed=[[1, "a"]]),
        shard(renamed=[["a"]]),
    ],
)
def test_a_manifest_of_what_cannot_be(path, change) -> None:
    written(path, change)
    assert "expected a manifest that agrees with itself, got one that does not" in refused(path)


def test_kinds_and_keys_that_are_none(path) -> None:
    before = (path / NAME).read_bytes()
    written(path, shard(renamed=[[5, ""]]))
    assert "key: expected a text" in refused(path)
    (path / NAME).write_bytes(before)
    written(path, lambda content: content["kinds"]["rows"].update(shape=[-1]))
    assert "shape: expected" in refused(path)


def test_deep_json_is_refused(path) -> None:
    line = b"[" * 1_000_000
    (path / NAME).write_bytes(line + b'\n{"sha256":"' + hashlib.sha256(line).hexdigest().encode() + b'"}\n')
    refused(path)


def test_no_folder_a_file_and_a_folder_without_a_manifest(tmp_path) -> None:
    (tmp_path / "file").write_text("x")
    for path in (tmp_path / "none", tmp_path / "file", tmp_path, tmp_path / "a\0b"):
        assert f"expected a harmonicface store at {path}, got none: " in refused(path)


def test_links_pipes_and_giants_are_not_opened(path, tmp_path, monkeypatch) -> None:
    (path / NAME).rename(tmp_path / "elsewhere")
    (path / NAME).symlink_to(tmp_path / "elsewhere")
    assert "got none: Too many levels of symbolic links" in refused(path)
    (path / NAME).unlink()
    os.mkfifo(path / NAME)
    assert "expected a plain file" in refused(path)
    (path / NAME).unlink()
    with (path / NAME).open("wb") as stream:
        stream.truncate(1 << 40)
    assert "expected a file of at most" in refused(path)


def test_the_constructor_reads_it(path) -> None:
    assert len(ArrayFolder(path).version()) == 19
    (path / NAME).write_bytes(b"")
    with pytest.raises(HarmonicFaceError, match="checksum"):
        ArrayFolder(path)
