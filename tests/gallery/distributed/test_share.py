"""Shares of a gallery: everybody is in one, in order; a gallery that was changed since is noticed."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path

import fsspec
import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.distributed.share import shares_of
from harmonicface.gallery.search.shelf import merged
from harmonicface.store.folder import ArrayFolder
from tests.gallery.shelved_people import drawn, made, pairs, scan, units

PEOPLE = [drawn(9, "float32") for _ in range(30)]


@pytest.fixture
def folder(tmp_path: Path) -> ArrayFolder:
    return made(tmp_path / "folder", PEOPLE, (8,))


@pytest.mark.parametrize("count", [1, 2, 3, 11, 29])
def test_everybody_is_in_one_share(folder: ArrayFolder, count: int) -> None:
    folder.remove(["person 0", *(f"person {number}" for number in range(7, 14)), "person 29"])
    left = [place for place in range(30) if place not in (0, *range(7, 14), 29)]
    shares = shares_of(str(folder.path), count)
    assert len(shares) == min(count, len(left))
    assert max(share.people for share in shares) - min(share.people for share in shares) <= 1
    shelves = [pickle.loads(pickle.dumps(share)).shelf() for share in shares]
    assert [place for shelf in shelves for place in shelf.places] == list(range(len(left)))
    names = [section.name(number) for s in shelves for section in s.sections for number in range(len(section))]
    assert names == [f"person {place}" for place in left]
    for unit in units(PEOPLE):
        answer = merged([shelf.search(unit, 4) for shelf in shelves], 4)
        assert pairs(answer) == scan([PEOPLE[place] for place in left], unit, 4, 1.0)


def test_a_share_names_its_own_shards_only(folder: ArrayFolder) -> None:
    shares = shares_of(str(folder.path), 5)
    assert [len(share.manifest.shards) for share in shares] == [1, 2, 2, 2, 2]
    assert all(len(pickle.dumps(share)) < 4000 for share in shares)


def test_an_empty_gallery_has_one_empty_share(tmp_path: Path) -> None:
    (share,) = shares_of(str(made(tmp_path / "folder", []).path), 3)
    assert share.people == len(share.shelf()) == 0


def test_the_version_that_was_opened_is_shared_out(folder: ArrayFolder) -> None:
    manifest = folder.version().manifest
    shorter = replace(manifest, shards=manifest.shards[1:])  # as without a damaged one
    assert sum(share.people for share in shares_of(str(folder.path), 2, shorter)) == 23


def test_a_gallery_that_was_changed_is_opened_again(folder: ArrayFolder) -> None:
    share = shares_of(str(folder.path), 1)[0]
    folder.compact()
    with pytest.raises(
        HarmonicFaceError, match=r"expected the files of generation \d+, got a gallery that was changed"
    ):
        share.shelf()


def test_a_damaged_shard_is_refused(folder: ArrayFolder) -> None:
    share = shares_of(str(folder.path), 1)[0]
    file = folder.path / share.manifest.shards[2].record.file
    file.write_bytes(file.read_bytes()[:-1])
    with pytest.raises(HarmonicFaceError, match=r"expected \d+ bytes, got \d+"):
        share.shelf()


def test_no_gallery_has_no_shares(tmp_path: Path) -> None:
    with pytest.raises(HarmonicFaceError, match="got none"):
        shares_of(str(tmp_path), 2)


def test_shares_of_object_storage_copy_their_own_shards(
    folder: ArrayFolder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    files = fsspec.filesystem("memory")
    files.put(f"{folder.path}/", "/shared/", recursive=True)
    monkeypatch.setenv("HARMONICFACE_CACHE", str(tmp_path / "here"))
    shares = shares_of("memory://shared", 5)
    monkeypatch.setenv("HARMONICFACE_CACHE", str(tmp_path / "a worker's"))
    assert shares[0].shelf().places.tolist() == list(range(6))
    copied = sorted(path.name for path in (tmp_path / "a worker's" / shares[0].copy).iterdir())
    common = shares[0].manifest.common
    assert common is not None and copied == sorted([common.file, shares[0].manifest.shards[0].record.file])
    unit = units(PEOPLE)[0]
    answer = merged([share.shelf().search(unit, 30) for share in shares], 30)
    np.testing.assert_array_equal(pairs(answer), scan(PEOPLE, unit, 30, 1.0))
    with pytest.raises(HarmonicFaceError, match="expected generation 7 of the gallery, got generation"):
        shares_of("memory://shared", 2, replace(shares[0].manifest, generation=7))
    files.rm("/shared", recursive=True)
