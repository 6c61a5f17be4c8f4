"""Sections of shards: their rows are read by the block where they are, and what cannot be is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.disk.section import Section
from harmonicface.gallery.search.packing import packed
from harmonicface.gallery.search.sketch import sketch
from harmonicface.store.entry import Entry
from tests.gallery.shelved_people import BASIS, PIXELS, STOPS, drawn, made, units


def test_some_of_a_shard(tmp_path: Path) -> None:
    people = [drawn(3 + number % 4, "float32") for number in range(6)]
    (part,) = made(tmp_path / "folder", people, (2,)).version().parts
    section = Section(part, np.array([1, 2, 4]), 10)
    assert len(section) == 3 and section.pixels == PIXELS
    assert [section.name(number) for number in range(3)] == ["person 1", "person 2", "person 4"]
    for number, place in enumerate((1, 2, 4)):
        np.testing.assert_array_equal(section.rows(number), people[place])
    assert section.sketched.tolist() == [True, False, True]
    assert np.isnan(section.defects()).tolist() == [False, True, False]
    pack = section.pack(7)
    assert pack.places.tolist() == [7, 9]
    assert pack.alive.tolist() == [False, True, True, False, True, False]
    assert pack.ranks.tolist() == [3, 4, 0, 6, 3, 4]


def test_closeness_of_everybody_by_the_block(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    people = [drawn(3 + number % 7, "float16") for number in range(30)]
    folder = made(tmp_path / "folder", people, range(30), "float16")
    folder.remove(["person 0", "person 8", "person 9", "person 29"])
    left = [rows for number, rows in enumerate(people) if number not in (0, 8, 9, 29)]
    asked = units(people)
    expected = [np.square(asked @ rows.T.astype(np.float64)).sum(axis=1) for rows in left]
    for block in (1, 1000, 1 << 25):
        monkeypatch.setattr("harmonicface.gallery.disk.section.BLOCK", block)
        sections = [Section(part, part.indices, 0) for part in folder.version().parts]
        found = [some for section in sections for _, some in section.closeness(asked.astype(np.float32))]
        np.testing.assert_allclose(np.concatenate(found), expected, rtol=1e-5)
        assert block > 1 or len(found) == len(left)


def test_a_sketch_that_tells_of_rows_that_are_not_orthonormal_is_refused(tmp_path: Path) -> None:
    person = drawn(9, "float32")
    folder = made(tmp_path / "folder", [])
    for defect in (0.02, -1.0):
        arrays = packed(sketch(person, BASIS, STOPS)) | {"rows": person, "sketch_defect": np.array([defect])}
        folder.append([Entry("ada", arrays)])
        with pytest.raises(HarmonicFaceError, match="expected orthonormal rows"):
            Section(folder.version().parts[0], np.array([0]), 0).defects()
        folder.remove("ada")


def test_somebody_without_rows_is_refused(tmp_path: Path) -> None:
    folder = made(tmp_path / "folder", [np.empty((0, PIXELS), np.float32)], (0,))
    with pytest.raises(HarmonicFaceError, match="got somebody without any"):
        Section(folder.version().parts[0], np.array([0]), 0)


@pytest.mark.parametrize("name", ["sketch_form", "sketch_levels", "sketch_doubts", "sketch_defect", "sketch_numbers_0"])
def test_parts_of_sketches_are_refused(tmp_path: Path, name: str) -> None:
    person = drawn(9, "float32")
    folder = made(tmp_path / "folder", [])
    whole = packed(sketch(person, BASIS, STOPS)) | {"rows": person}
    for some in (whole[name][:0], np.concatenate([whole[name]] * 2)):
        folder.append([Entry("ada", whole | {name: some})])
        with pytest.raises(HarmonicFaceError, match="expected whole sketches of rows, got a part of one"):
            Section(folder.version().parts[0], np.array([0]), 0)
        folder.remove("ada")
