"""Galleries on object storage are copied to this machine, whole files or none, and never written to."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import fsspec
import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.disk import staging
from harmonicface.gallery.disk.staging import cache_folder, fetch, is_url, refuse_writing, staged, staged_manifest
from harmonicface.store.entry import Entry, Kind
from harmonicface.store.folder import ArrayFolder

URL = "memory://people.gallery"


def upload(folder: ArrayFolder) -> None:
    """Copy a folder to the storage, as anybody would."""
    files = fsspec.filesystem("memory")
    files.put(f"{folder.path}/", "/people.gallery/", recursive=True)


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[ArrayFolder]:
    folder = ArrayFolder.create(
        tmp_path / "people", {"rows": Kind(np.dtype("f4"), (3,))}, common={"mask": np.ones((1, 3), np.bool_)}
    )
    folder.append([Entry("ada", {"rows": np.eye(3, dtype=np.float32)})])
    files = fsspec.filesystem("memory")
    upload(folder)
    yield folder
    files.store.clear()
    files.pseudo_dirs[:] = [""]


def test_the_copy_is_the_gallery(folder: ArrayFolder, tmp_path: Path) -> None:
    copy = ArrayFolder(staged(URL, tmp_path / "cache")).version()
    assert copy.keys == ("ada",)
    np.testing.assert_array_equal(copy.entry("ada").arrays["rows"], np.eye(3))
    np.testing.assert_array_equal(copy.common["mask"], [[True] * 3])
    assert not ArrayFolder(staged(URL, tmp_path / "cache")).verify()


def test_what_is_there_is_not_copied_again(
    folder: ArrayFolder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = staged(URL, tmp_path / "cache")
    times = {path.name: path.stat().st_mtime_ns for path in first.iterdir()}
    assert staged(URL + "/", tmp_path / "cache") == first
    assert {path.name: path.stat().st_mtime_ns for path in first.iterdir()} == times
    assert set(times) == {path.name for path in folder.path.iterdir()}


def test_every_version_has_its_own_copy(folder: ArrayFolder, tmp_path: Path) -> None:
    first = staged(URL, tmp_path / "cache")
    folder.append([Entry("emmy", {"rows": np.eye(3, dtype=np.float32)})])
    upload(folder)
    second = staged(URL, tmp_path / "cache")
    assert ArrayFolder(first).version().keys == ("ada",)
    assert ArrayFolder(second).version().keys == ("ada", "emmy")


def test_a_gallery_that_is_replaced_meanwhile_is_copied_again(
    folder: ArrayFolder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fetched = staging.fetch

    def replaced(url: str, place: Path, files: list[tuple[str, int]]) -> None:
        monkeypatch.setattr(staging, "fetch", fetched)
        fsspec.filesystem("memory").rm("/people.gallery", recursive=True)
        folder.append([Entry("emmy", {"rows": np.eye(3, dtype=np.float32)})])
        folder.compact()
        upload(folder)
        fetched(url, place, files)

    monkeypatch.setattr(staging, "fetch", replaced)
    assert ArrayFolder(staged(URL, tmp_path / "cache")).version().keys == ("ada", "emmy")


def test_files_of_other_lengths_and_missing_ones_are_refused(folder: ArrayFolder, tmp_path: Path) -> None:
    place, manifest = staged_manifest(URL, tmp_path / "cache")
    name = manifest.shards[0].record.file
    with pytest.raises(HarmonicFaceError, match=f"expected {name} of 7 bytes, got"):
        fetch(URL, place, [(name, 7)])
    fsspec.filesystem("memory").rm(f"/people.gallery/{name}")
    with pytest.raises(HarmonicFaceError, match=f"cannot copy {name}"):
        staged(URL, tmp_path / "cache")
    assert [path.name for path in place.iterdir()] == ["manifest.json"]


def test_a_manifest_that_points_outside_is_refused(folder: ArrayFolder, tmp_path: Path) -> None:
    files = fsspec.filesystem("memory")
    files.pipe_file("/people.gallery/manifest.json", b'{"shards": [{"file": "../../etc/passwd"}]}\n')
    with pytest.raises(HarmonicFaceError, match="expected the checksum it was written with"):
        staged(URL, tmp_path / "cache")


@pytest.mark.parametrize(
    ("url", "said"),
    [
        ("memory://nothing", "expected a gallery at memory://nothing, got none"),
        ("nothing://x", "cannot open nothing://x: Protocol not known: nothing"),
    ],
)
def test_what_is_no_gallery_is_refused_in_one_line(url: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(HarmonicFaceError, match=said) as caught:
        staged(url, tmp_path)
    assert "\n" not in str(caught.value)


def test_a_cache_that_cannot_be_made_is_refused(folder: ArrayFolder, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(HarmonicFaceError, match="cannot make the folder"):
        staged(URL, tmp_path / "file")


def test_a_missing_fsspec_is_said(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "fsspec.core", None)
    with pytest.raises(HarmonicFaceError, match=r"expected fsspec, .*harmonicface\[distributed\]"):
        staged(URL, tmp_path)


def test_nobody_writes_to_object_storage() -> None:
    with pytest.raises(HarmonicFaceError, match=r"expected a folder on a POSIX file system, .* got s3://a/b, which is"):
        refuse_writing("s3://a/b")
    refuse_writing("/a/b")


def test_urls_and_paths() -> None:
    assert is_url("zip://a::s3://b") and is_url("s3+x://b")
    assert not any(map(is_url, ["a/b", "C:\\a", Path("s3://b"), "://", "1a://b"]))


def test_where_copies_are_kept(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("HARMONICFACE_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder() == tmp_path / "harmonicface"
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert cache_folder() == Path.home() / ".cache" / "harmonicface"
    monkeypatch.setenv("HARMONICFACE_CACHE", str(tmp_path / "here"))
    assert cache_folder() == tmp_path / "here"
