"""Shelves of people in files: their answers are those of a scan of everybody, however they are cut."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.distributed.share import shares_of
from harmonicface.gallery.search.cascade import Found
from harmonicface.gallery.search.shared_basis import SharedBasis
from harmonicface.gallery.search.shelf import Shelf, merged
from harmonicface.store.folder import ArrayFolder
from harmonicface.store.version import Version
from tests.gallery.shelved_people import BASIS, PIXELS, STOPS, drawn, made, pairs, scan, units


def shelf_of(version: Version, basis: SharedBasis | None = BASIS) -> Shelf:
    """Return one shelf of everybody."""
    firsts = np.cumsum([0, *(len(part) for part in version.parts)])[:-1]
    return Shelf.of_parts(version.parts, firsts.tolist(), basis, STOPS if basis else ())


@pytest.mark.parametrize("unsketched", [(), (0, 1, 9, 19), tuple(range(20))])
@pytest.mark.parametrize("dtype", ["float32", "float16"])
@pytest.mark.parametrize(("top", "distance"), [(1, 1.0), (5, 1.0), (None, 0.9), (3, 0.5), (50, 1.0)])
def test_answers_are_those_of_a_scan(
    tmp_path: Path, unsketched: tuple[int, ...], dtype: str, top: int | None, distance: float
) -> None:
    people = [drawn((9, 5, 9, 25)[number % 4], dtype) for number in range(20)]
    people.append(people[3])  # a tie
    folder = made(tmp_path / "folder", people, unsketched, dtype)
    folder.remove(["person 4", "person 13"])
    left = [rows for number, rows in enumerate(people) if number not in (4, 13)]
    version, asked = folder.version(), units(people)
    assert len(version.parts) == 3
    for basis in (BASIS, None):
        shelf = shelf_of(version, basis)
        answers = [shelf.search(unit, top, distance) for unit in asked]
        expected = [scan(left, unit, top, distance) for unit in asked]
        assert [pairs(one) for one in answers] == expected
        assert [pairs(one) for one in shelf.search_many(asked, top, distance)] == expected
        for count in (2, 5, 100):
            shelves = [share.shelf() for share in shares_of(str(folder.path), count)]
            assert len(shelves) == min(count, len(left))
            assert sum(map(len, shelves)) == len(left)
            parts = [shelf.search_many(asked, top, distance) for shelf in shelves]
            assert [pairs(merged(one, top)) for one in zip(*parts, strict=True)] == expected


@given(st.integers(0, 2**32), st.integers(1, 9), st.floats(0.2, 1.0))
def test_any_photograph_is_answered_as_by_a_scan(
    shelved: tuple[Shelf, list[np.ndarray]], seed: int, top: int, distance: float
) -> None:
    shelf, people = shelved
    rng = np.random.default_rng(seed)
    photo = rng.normal(size=9) @ people[seed % 16] + rng.uniform(0, 1) * rng.normal(size=PIXELS)
    unit = photo / np.linalg.norm(photo)
    assert pairs(shelf.search(unit, top, distance)) == scan(people, unit, top, distance)


@pytest.fixture(scope="module")
def shelved(tmp_path_factory: pytest.TempPathFactory) -> tuple[Shelf, list[np.ndarray]]:
    people = [drawn(9, "float32") for _ in range(16)]
    folder = made(tmp_path_factory.mktemp("shelved") / "folder", people, (2, 3))
    return shelf_of(folder.version()), people


def test_nobody_is_found_on_an_empty_shelf(tmp_path: Path) -> None:
    shelf = shelf_of(made(tmp_path / "folder", []).version())
    unit = np.eye(PIXELS)[0]
    assert len(shelf) == 0 and shelf.places.tolist() == []
    assert shelf.search(unit) == Found((), (), (), 0)
    assert shelf.search_many(unit[None], 3) == [Found((), (), (), 0)]
    assert shelf.closeness(unit[None]).shape == (0, 1)


def test_no_question_has_no_answer(shelved: tuple[Shelf, list[np.ndarray]]) -> None:
    assert shelved[0].search_many(np.empty((0, PIXELS))) == []


def test_what_was_read_can_be_forgotten(shelved: tuple[Shelf, list[np.ndarray]]) -> None:
    shelf, people = shelved
    shelf.forget()
    unit = units(people)[0]
    assert pairs(shelf.search(unit)) == scan(people, unit, 1, 1.0)
    assert shelf.nbytes > sum(company.forms.nbytes for company in shelf._companies) + 16 * 16


def test_survivors_are_summed_stage_by_stage() -> None:
    answers = [Found((1,), (0.3,), (9, 2), 1), Found((), (), (), 0), Found((5,), (0.3,), (4,), 4)]
    assert merged(answers, None) == Found((1, 5), (0.3, 0.3), (13, 6), 5)
    assert merged([], 1) == Found((), (), (), 0)


def test_a_basis_of_other_pixels_is_refused(tmp_path: Path) -> None:
    folder = made(tmp_path / "folder", [drawn(9, "float32")])
    with pytest.raises(HarmonicFaceError, match="expected a basis of 80 pixels, got one of 4"):
        shelf_of(folder.version(), SharedBasis(np.eye(4)))


def test_rows_that_are_not_orthonormal_are_refused_by_name(tmp_path: Path) -> None:
    folder = made(tmp_path / "folder", [drawn(9, "float32"), 1.1 * drawn(9, "float32")], (0, 1))
    with pytest.raises(HarmonicFaceError, match="'person 1': expected orthonormal rows"):
        shelf_of(folder.version()).search(np.eye(PIXELS)[0])


@pytest.mark.parametrize("unsketched", [(), (0, 1)])
def test_nan_in_a_file_is_refused(tmp_path: Path, unsketched: tuple[int, ...]) -> None:
    people = [drawn(9, "float32"), drawn(9, "float32")]
    folder = made(tmp_path / "folder", people, unsketched)
    record = folder.version().manifest.shards[0].record
    path = folder.path / record.file
    content = path.read_bytes()
    assert content.count(people[1][3].tobytes()) == 1
    path.write_bytes(content.replace(people[1][3].tobytes(), np.full(PIXELS, np.nan, np.float32).tobytes()))
    with pytest.raises(HarmonicFaceError, match="expected finite rows, got NaN or infinity"):
        shelf_of(ArrayFolder(folder.path).version()).search(people[1][0].astype(np.float64))
    with pytest.raises(HarmonicFaceError, match="expected finite rows, got NaN or infinity"):
        shelf_of(ArrayFolder(folder.path).version()).closeness(people[1][:1].astype(np.float64))
