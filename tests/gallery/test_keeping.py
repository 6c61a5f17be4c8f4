"""A gallery in a folder: durable, seen by the handle that wrote, never half there; and what is refused."""

from __future__ import annotations

import multiprocessing
import os
import random
import time
from collections.abc import Iterable, Iterator
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import harmonicface as hf
from harmonicface.gallery import roll
from harmonicface.gallery.disk.layout import About, check_rows
from harmonicface.gallery.enrolled import people_in_version
from harmonicface.gallery.enrolled.enrolment import Enrolment, Model, enrolment_of
from harmonicface.gallery.enrolled.people_in_folder import PeopleInFolder
from harmonicface.gallery.frame import Frame
from harmonicface.gallery.rule import Rule
from harmonicface.gallery.search.shelf import Shelf
from harmonicface.store.entry import Entry
from harmonicface.store.folder import ArrayFolder
from harmonicface.store.manifest import Manifest

SIZE = 24
KILLS = int(os.environ.get("HARMONICFACE_KILLS", "5"))
PEOPLE = {name: hf.synthetic_person(seed, SIZE) for seed, name in enumerate(["ada", "emmy", "sofia", "grace"])}
PHOTO = hf.render(PEOPLE["emmy"], hf.lights.natural(2))


def filled(gallery: hf.Gallery, names: list[str] | None = None) -> hf.Gallery:
    for name in names or PEOPLE:
        gallery.enroll(name, PEOPLE[name])
    return gallery


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "people"


@pytest.fixture
def kept(path: Path) -> hf.Gallery:
    return filled(hf.Gallery.create(path, "harmonic9"))


def test_what_a_method_has_done_is_on_the_disk(path: Path) -> None:
    gallery = hf.Gallery.create(path, "harmonic9", threshold=0.2, margin=np.inf, shortlist=7)
    assert not path.exists()
    for number, name in enumerate(PEOPLE):
        gallery.enroll(name, PEOPLE[name])
        assert hf.Gallery.open(path).names == gallery.names == tuple(PEOPLE)[: number + 1]
    gallery.rename("ada", "Ada Lovelace")
    assert hf.Gallery.open(path).names == gallery.names == ("Ada Lovelace", "emmy", "sofia", "grace")
    gallery.remove("sofia")
    opened = hf.Gallery.open(path)
    assert opened.names == gallery.names == ("Ada Lovelace", "emmy", "grace")
    assert (opened.threshold, opened.margin, opened.shortlist, opened.model) == (0.2, np.inf, 7, "harmonic9")
    assert opened.path == path
    assert "emmy" in opened and "sofia" not in opened and 5 not in opened
    assert opened.source_of("emmy") == "surface"
    assert_array_equal(opened.pictures_of("emmy"), gallery.pictures_of("emmy"))
    assert opened.bytes_per_person > 9 * 4 * SIZE * SIZE


def test_with_a_mask_the_folder_is_made_at_once(path: Path) -> None:
    mask = np.ones((SIZE, SIZE), np.bool_)
    mask[:3] = False
    gallery = hf.Gallery.create(path, mask=mask)
    opened = hf.Gallery.open(path)
    assert (len(opened), opened.names, opened.bytes_per_person) == (0, (), 0.0)
    assert_array_equal(opened.mask, mask)
    opened.enroll("ada", PEOPLE["ada"])
    gallery.enroll("emmy", PEOPLE["emmy"])
    assert gallery.names == ("ada", "emmy")
    with pytest.raises(hf.HarmonicFaceError, match="match: expected a gallery with somebody in it, got an empty one"):
        hf.Gallery.create(path.with_name("other"), mask=mask).match(PHOTO)


def test_a_handle_stays_at_its_version_until_it_is_refreshed_or_writes(path: Path, kept: hf.Gallery) -> None:
    reader, other = hf.Gallery.open(path), hf.Gallery.open(path)
    before = reader.match(PHOTO)
    kept.remove("emmy")
    kept.compact()
    assert reader.names == tuple(PEOPLE)
    assert reader.match(PHOTO).candidates == before.candidates
    other.threshold, other.shortlist = 0.4, 9
    other.save()
    assert other.names == ("ada", "sofia", "grace")
    assert reader.threshold == 0.1
    reader.refresh()
    assert (reader.names, reader.threshold, reader.shortlist) == (("ada", "sofia", "grace"), 0.4, 9)
    with pytest.raises(hf.HarmonicFaceError, match="somebody in the gallery, got 'emmy'"):
        kept.remove("emmy")
    hf.Gallery().refresh()


def test_two_who_begin_at_once_lose_nobody(path: Path) -> None:
    one, other = hf.Gallery.create(path, "harmonic9"), hf.Gallery.create(path, "harmonic9")
    one.enroll("ada", PEOPLE["ada"])
    other.enroll("emmy", PEOPLE["emmy"])
    assert other.names == ("ada", "emmy")
    third = hf.Gallery.create(path.with_name("third"), "harmonic9")
    hf.Gallery.create(third.path or "", "linear3", mask=np.ones((SIZE, SIZE), np.bool_))
    with pytest.raises(hf.HarmonicFaceError, match="expected the gallery that was opened, got another there"):
        third.enroll("ada", PEOPLE["ada"])


def test_two_who_begin_with_other_pixels(path: Path) -> None:
    one, other = hf.Gallery.create(path, "harmonic9"), hf.Gallery.create(path, "harmonic9")
    mask = np.ones((SIZE, SIZE), np.bool_)
    mask[0] = False
    hf.Gallery.create(path, "harmonic9", mask=mask)
    with pytest.raises(hf.HarmonicFaceError, match=r"ada: expected the pixels of the gallery at .*, got others"):
        one.enroll("ada", PEOPLE["ada"])
    other.refresh()
    assert len(other) == 0


def test_names_that_are_taken_meanwhile(path: Path, kept: hf.Gallery) -> None:
    other = hf.Gallery.open(path)
    kept.enroll("mary", PEOPLE["ada"])
    with pytest.raises(hf.HarmonicFaceError, match="key: expected one that is not in the folder yet, got 'mary'"):
        other.enroll("mary", PEOPLE["ada"])
    with pytest.raises(hf.HarmonicFaceError, match="name: expected one that is not in the gallery yet, got 'ada'"):
        other.rename("emmy", "ada")
    with pytest.raises(hf.HarmonicFaceError, match="name: expected one without slashes, got 'a/b'"):
        other.rename("emmy", "a/b")
    with pytest.raises(hf.HarmonicFaceError, match="name: expected one without slashes"):
        other.enroll("..\\b", PEOPLE["ada"])


def test_a_basis_that_somebody_learns_meanwhile(path: Path, kept: hf.Gallery) -> None:
    other = hf.Gallery.open(path)
    kept.index(people=3)
    other.enroll("mary", PEOPLE["ada"])
    kept.index(people=4, seed=5)
    other.enroll("hedy", PEOPLE["emmy"])
    assert other.verify() == ()
    assert other.match(PHOTO, explain=True).search.survivors != ()  # type: ignore[union-attr]
    expected = filled(hf.Gallery("harmonic9"))
    expected.enroll("mary", PEOPLE["ada"])
    expected.enroll("hedy", PEOPLE["emmy"])
    assert other.match(PHOTO).candidates == expected.match(PHOTO).candidates


@pytest.mark.parametrize("dtype", ["float32", "float16"])
@pytest.mark.parametrize("model", ["default", "harmonic9"])
def test_saved_folders_answer_the_same(tmp_path: Path, model: str, dtype: str) -> None:
    gallery = filled(hf.Gallery(model))
    gallery.save(tmp_path / "people", dtype=dtype)
    opened = hf.Gallery.open(tmp_path / "people")
    assert opened.names == gallery.names
    bytes_before = opened.bytes_per_person
    opened.index(people=3)
    for path in (tmp_path / "again", tmp_path / "one.safetensors"):
        opened.save(path)
        again = hf.Gallery.open(path)
        assert again.match(PHOTO).candidates == opened.match(PHOTO).candidates
        assert (again.match(PHOTO, explain=True).search.survivors != ()) == (  # type: ignore[union-attr]
            path.suffix == "" and model == "harmonic9"
        )
    if dtype == "float32":
        assert opened.match(PHOTO).candidates == gallery.match(PHOTO).candidates
    else:
        assert opened.match(PHOTO).name == "emmy"
        gallery.save(tmp_path / "single")
        assert bytes_before < 0.7 * hf.Gallery.open(tmp_path / "single").bytes_per_person


def test_saving_in_the_place_of_a_gallery_replaces_all_of_it(path: Path, kept: hf.Gallery) -> None:
    reader = hf.Gallery.open(path)
    other = filled(hf.Gallery("linear3", mask=np.eye(SIZE) == 0), ["grace"])
    other.save(path)
    assert hf.Gallery.open(path).names == ("grace",)
    assert hf.Gallery.open(path).model == "linear3"
    assert reader.names == tuple(PEOPLE)
    for change in (reader.refresh, lambda: reader.enroll("mary", PEOPLE["ada"]), lambda: reader.remove("ada")):
        with pytest.raises(hf.HarmonicFaceError, match="expected the gallery that was opened, got another there"):
            change()


def test_some_people_are_saved(path: Path, kept: hf.Gallery) -> None:
    kept.save(path.with_name("some"), among=["grace", "ada"])
    assert hf.Gallery.open(path.with_name("some")).names == ("grace", "ada")
    kept.save(path.with_name("some.safetensors"), among=["emmy"])
    assert hf.Gallery.open(path.with_name("some.safetensors")).names == ("emmy",)


def test_a_file_of_a_gallery_stays_a_file(tmp_path: Path) -> None:
    filled(hf.Gallery("harmonic9")).save(tmp_path / "x.safetensors")
    (tmp_path / "x.safetensors").rename(tmp_path / "people.gallery")
    gallery = hf.Gallery.open(tmp_path / "people.gallery")
    gallery.remove("ada")
    gallery.save(tmp_path / "people.gallery")
    assert (tmp_path / "people.gallery").is_file()
    assert hf.Gallery.open(tmp_path / "people.gallery").names == ("emmy", "sofia", "grace")


def test_what_cannot_be_kept(path: Path, kept: hf.Gallery, tmp_path: Path) -> None:
    memory = filled(hf.Gallery("harmonic9"), ["ada"])
    for wrong, message in (
        (lambda: memory.save(), "save without a path: expected a gallery in a folder, got one in memory"),
        (lambda: memory.verify(), "verify: expected a gallery in a folder, got one in memory"),
        (lambda: memory.compact(), "compact: expected a gallery in a folder, got one in memory"),
        (lambda: kept.save(dtype="float16"), "save: expected another path for other rows"),
        (lambda: kept.save(path, among=["ada"]), "save: expected another path for other rows or for some"),
        (lambda: kept.save(tmp_path / "b", among=[]), "save: expected a gallery with somebody in it"),
        (lambda: kept.save(tmp_path / "b", among=["ada", "ada"]), "among: expected each name once, got 2 of 1 people"),
        (lambda: kept.save(tmp_path / "b", among=["mary"]), "name: expected somebody in the gallery, got 'mary'"),
        (
            lambda: kept.save(tmp_path / "b", dtype="float8"),
            "dtype: expected one of float32, float16, got str 'float8'",
        ),
        (lambda: kept.save(tmp_path / "b.safetensors", dtype="float16"), "dtype: expected float32 for a portable file"),
        (lambda: kept.save("s3://bucket/people"), "expected a folder on a POSIX file system"),
        (lambda: hf.Gallery.create("s3://bucket/people"), "expected a folder on a POSIX file system"),
        (lambda: hf.Gallery.create(path), "create: expected a new or an empty folder, got .*, which is there"),
        (lambda: hf.Gallery.create(tmp_path / "no" / "people"), "expected a folder .*no, got none"),
        (lambda: hf.Gallery.create(tmp_path / "b", dtype="int8"), "dtype: expected one of float32, float16"),
        (lambda: hf.Gallery.create(tmp_path / "b").remove("ada"), "name: expected somebody in the gallery, got 'ada'"),
        (lambda: hf.Gallery.create(tmp_path / "b").verify(), "expected a gallery at .*, got none before somebody is"),
        (lambda: hf.Gallery.create(tmp_path / "b").index(), "index: expected a gallery with somebody in it, got an"),
        (lambda: hf.Gallery().index(), "index: expected a gallery with somebody in it, got an empty one"),
        (lambda: hf.Gallery.open(tmp_path / "none"), "expected a gallery at .*none, got none"),
        (lambda: hf.Gallery.open(tmp_path), "expected a gallery at .*, got a folder that is none"),
        (lambda: hf.Gallery.open("a\0b"), "expected a gallery at .*, got none"),
    ):
        with pytest.raises(hf.HarmonicFaceError, match=message) as caught:
            wrong()
        assert "\n" not in str(caught.value)
    memory.save(tmp_path / "c.safetensors")
    with pytest.raises(hf.HarmonicFaceError, match=r"client: expected a gallery in a folder, got .*c\.safetensors"):
        hf.Gallery.open(tmp_path / "c.safetensors", client=object())  # type: ignore[arg-type]
    assert not (tmp_path / "b").exists()


def test_a_folder_of_something_else_is_no_gallery(tmp_path: Path, kept: hf.Gallery, path: Path) -> None:
    version = ArrayFolder(path).version()
    other = ArrayFolder.create(tmp_path / "other", version.kinds, {"format": "shoes"})
    for wrong in (lambda: hf.Gallery.open(other.path), lambda: kept.save(other.path)):
        with pytest.raises(hf.HarmonicFaceError, match="expected a harmonicface gallery, got a folder of 'shoes'"):
            wrong()
    other.describe({**version.about, "version": "5"})
    with pytest.raises(hf.HarmonicFaceError, match="expected version 4 of the gallery format in a folder, got '5'"):
        hf.Gallery.open(other.path)
    other.describe(version.about)
    with pytest.raises(hf.HarmonicFaceError, match="expected a gallery that agrees with itself"):
        hf.Gallery.open(other.path)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("model", "magic"), ("model", "default"), ("threshold", 2), ("margin", 0.5), ("shortlist", "7"),
        ("dtype", "float16"), ("dtype", "float64"), ("stops", [3]), ("stops", "3"), ("sample", 1.5), ("stops", None),
    ],
)  # fmt: skip
def test_words_that_contradict_the_arrays(path: Path, kept: hf.Gallery, key: str, value: object) -> None:
    folder = ArrayFolder(path)
    folder.describe({**folder.version().about, key: value})
    with pytest.raises(hf.HarmonicFaceError, match="expected a gallery that agrees with itself, got one that does not"):
        hf.Gallery.open(path)


def test_rows_are_checked_when_they_are_read(path: Path, kept: hf.Gallery) -> None:
    folder = ArrayFolder(path)

    def scaled(entry: Entry) -> Entry:
        rows = entry.arrays["rows"] * np.float32(0.9 if entry.key == "sofia" else 1)
        return Entry(entry.key, {**entry.arrays, "rows": rows}, entry.about)

    folder.revise(scaled)
    gallery = hf.Gallery.open(path)
    assert gallery.names == tuple(PEOPLE)
    for wrong in (lambda: gallery.match(PHOTO), lambda: gallery.pictures_of("sofia")):
        with pytest.raises(hf.HarmonicFaceError, match="'sofia': expected orthonormal rows, got some that are not"):
            wrong()
    assert [damage.keys for damage in gallery.verify()] == [("sofia",)]
    gallery.remove("sofia")
    assert gallery.match(PHOTO).name == "emmy"
    with pytest.raises(hf.HarmonicFaceError, match="'x': expected 1 to 4 rows, got 5"):
        check_rows(np.ones((5, 4), np.float32), "x")


def test_a_damaged_shard_leaves_the_others_usable(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gallery = filled(hf.Gallery.create(path, "harmonic9"), ["ada"])
    monkeypatch.setattr("harmonicface.store.writing.taken_in", lambda *_: 0)
    for name in ("emmy", "sofia"):
        gallery.enroll(name, PEOPLE[name])
    shard = sorted(path.glob("*.safetensors"))[-2]
    shard.write_bytes(shard.read_bytes()[:-1])
    with pytest.warns(UserWarning, match="1 damaged files, 1 people are left out: see `verify`"):
        opened = hf.Gallery.open(path)
    assert opened.names == ("ada", "sofia")
    assert [(one.file, one.keys) for one in opened.damaged] == [(shard.name, ("emmy",))]
    assert opened.match(PHOTO).candidates[0].name in ("ada", "sofia")
    assert [damage.keys for damage in opened.verify()] == [("emmy",)]
    assert gallery.damaged == hf.Gallery().damaged == ()


def test_many_are_written_by_the_piece(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(roll, "PIECE", 3 * 9 * SIZE * SIZE * 4)
    gallery, pieces = hf.Gallery.create(path, "harmonic9"), []
    add = PeopleInFolder.add

    def counted(self: PeopleInFolder, people: list) -> None:  # type: ignore[type-arg]
        pieces.append(len(people))
        add(self, people)

    monkeypatch.setattr(PeopleInFolder, "add", counted)
    sources = [(str(number), PEOPLE["ada"]) for number in range(7)]
    assert gallery.enroll_many(sources) == 7
    assert pieces == [3, 3, 1]
    assert hf.Gallery.open(path).names == tuple(str(number) for number in range(7))
    for wrong, message in ((("0", PEOPLE["ada"]), "got '0', who is"), (("a", PEOPLE["ada"]), "got 'a' twice")):
        with pytest.raises(hf.HarmonicFaceError, match=message):
            gallery.enroll_many([("a", PEOPLE["ada"]), wrong, ("b", PEOPLE["ada"])])
        assert gallery.names[-1] == "a"
        gallery.remove("a")
    assert gallery.enroll_many([]) == 0


def test_a_gallery_on_object_storage_is_only_read(
    path: Path, kept: hf.Gallery, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("fsspec")
    monkeypatch.setenv("HARMONICFACE_CACHE", str(tmp_path / "copies"))
    gallery = hf.Gallery.open(f"file://{path}")
    assert gallery.path == next((tmp_path / "copies").iterdir())
    assert gallery.match(PHOTO).candidates == kept.match(PHOTO).candidates
    assert gallery.verify() == ()
    monkeypatch.setattr(PeopleInFolder, "learned", None)  # what is refused is not worked for
    for write in (
        lambda: gallery.enroll("mary", PEOPLE["ada"]),
        lambda: gallery.remove("ada"),
        lambda: gallery.rename("ada", "mary"),
        gallery.index,
        gallery.compact,
        gallery.save,
    ):
        with pytest.raises(hf.HarmonicFaceError, match=r"expected a folder on a POSIX file system, .* only read"):
            write()
    assert hf.Gallery.open(path).names == gallery.names == tuple(PEOPLE)


def test_a_gallery_on_object_storage_is_copied_again_when_it_has_changed(
    path: Path, kept: hf.Gallery, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("fsspec")
    monkeypatch.setenv("HARMONICFACE_CACHE", str(tmp_path / "copies"))
    gallery = hf.Gallery.open(f"file://{path}")
    first = gallery.path
    kept.rename("emmy", "Emmy Noether")
    with pytest.raises(hf.HarmonicFaceError, match="only read"):
        gallery.remove("emmy")
    assert len(list((tmp_path / "copies").iterdir())) == 1  # nothing is copied for what is refused
    assert gallery.names == tuple(PEOPLE)
    gallery.refresh()
    assert gallery.path != first and gallery.names == kept.names
    assert gallery.match(PHOTO).candidates == kept.match(PHOTO).candidates
    now = gallery.path
    gallery.refresh()
    assert gallery.path == now
    path.rename(tmp_path / "elsewhere")
    with pytest.raises(hf.HarmonicFaceError, match="expected a gallery at file://"):
        gallery.refresh()
    assert gallery.names == kept.names


def test_with_a_client_others_search_and_enrol(path: Path, kept: hf.Gallery, monkeypatch: pytest.MonkeyPatch) -> None:
    client, asked = object(), []

    def shelf(where: str, by: object, manifest: Manifest) -> Shelf:
        assert (where, by) == (str(path), client)
        asked.append(manifest.generation)
        parts = ArrayFolder(where).version().parts
        return Shelf.of_parts(parts, np.cumsum([0, *map(len, parts)])[:-1].tolist())

    def enrolments(by: object, sources: Iterable[hf.Surface], frame: Frame, model: Model) -> Iterator[Enrolment]:
        assert by is client
        return (enrolment_of(source, frame, model) for source in sources)

    monkeypatch.setattr(people_in_version, "SharedShelf", shelf)
    monkeypatch.setattr(people_in_version, "enrolments", enrolments)
    gallery = hf.Gallery.open(path, client=client)  # type: ignore[arg-type]
    assert gallery.match(PHOTO).candidates == kept.match(PHOTO).candidates
    assert len(gallery.match_many([PHOTO] * 3)) == 3
    assert len(asked) == 1
    assert gallery.enroll_many([("mary", PEOPLE["ada"]), ("hedy", PEOPLE["emmy"])]) == 2
    assert [one.name for one in gallery.match(PHOTO).candidates[:2]] == ["emmy", "hedy"]
    assert len(asked) == 2


def test_a_basis_that_is_none(path: Path, kept: hf.Gallery) -> None:
    kept.index(people=3)
    folder = ArrayFolder(path)
    common = dict(folder.version().common)
    folder.describe(common={**common, "basis": common["basis"] * 1.1})
    gallery = hf.Gallery.open(path)
    with pytest.raises(hf.HarmonicFaceError, match=r"people, basis: rows: expected orthonormal rows"):
        gallery.match(PHOTO)


def test_opening_reads_no_rows(path: Path, kept: hf.Gallery, monkeypatch: pytest.MonkeyPatch) -> None:
    kept.index(people=3)
    for what in ("entry", "find", "key"):
        monkeypatch.setattr(f"harmonicface.store.part.Part.{what}", None)
    monkeypatch.setattr("harmonicface.store.shard.Shard.directory", None)
    monkeypatch.setattr("harmonicface.gallery.enrolled.people_in_version.SharedBasis", None)
    assert len(hf.Gallery.open(path)) == 4


def test_what_a_folder_says_of_an_infinite_margin() -> None:
    about = About.of(Rule("harmonic9", margin=np.inf))
    assert about.margin is None
    assert about.rule().margin == np.inf


def names_of(number: int) -> tuple[str, str]:
    return f"person {number}", f"renamed {number}"


def enrol_until_killed(path: Path, first: int, told: Connection) -> None:
    """Enrol one after the other, give every third another name, take every fourth out three later; tell each."""
    gallery, number = hf.Gallery.open(path), first
    while True:
        gallery.enroll(names_of(number)[0], PEOPLE["ada"])
        if number % 3 == 2:
            gallery.rename(*names_of(number))
        if number % 4 == 3:
            gallery.remove([name for name in names_of(number - 3) if name in gallery])
        told.send(number)
        number += 1


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs a system with fork")
def test_a_killed_writer_loses_nobody(path: Path, kept: hf.Gallery) -> None:
    kept.index(people=3)
    start, rng, interrupted, first = multiprocessing.get_context("forkserver"), random.Random(0), set(), 0
    start.set_forkserver_preload(["harmonicface"])
    for _ in range(KILLS):
        receiver, sender = start.Pipe(duplex=False)
        writer = start.Process(target=enrol_until_killed, args=(path, first, sender))
        writer.start()
        sender.close()
        last = receiver.recv()
        time.sleep(rng.uniform(0, 0.1))
        writer.kill()
        with suppress(EOFError):
            while True:
                last = receiver.recv()
        writer.join()
        interrupted.add(last + 1)
        gallery = hf.Gallery.open(path)
        assert gallery.verify() == ()
        there = set(gallery.names)
        for number in range(last + 1):
            if not interrupted & {number, number + 3}:
                gone = number % 4 == 0 and number + 3 <= last
                assert there & set(names_of(number)) == (set() if gone else {names_of(number)[number % 3 == 2]})
        assert gallery.match(PHOTO).candidates[0].name == "emmy"
        gallery.save()  # the next write sweeps away what the dead one left
        assert {one.name for one in path.iterdir()} == ArrayFolder(path).version().manifest.files | {"manifest.json"}
        first = last + 1 + bool(there & set(names_of(last + 1)))
