"""A gallery's file: the same answers bit for bit, or one line that says what is wrong with it."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from safetensors.numpy import save_file

import harmonicface as hf
from harmonicface.store.archive import read_arrays, write_arrays

SHAPE = (10, 9)


def surface(seed: int) -> hf.Surface:
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(*SHAPE, 3)).astype(np.float32)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    return hf.Surface(normals, rng.uniform(0.1, 1, SHAPE).astype(np.float32))


def small_gallery() -> hf.Gallery:
    mask = np.ones(SHAPE, np.bool_)
    mask[0] = False
    gallery = hf.Gallery("harmonic9", mask=mask, threshold=0.25, margin=1.5, shortlist=7)
    for seed, name in enumerate(["ada", 'emmy "E" n\u00f6ther', "\u2603"]):
        gallery.enroll(name, surface(seed))
    gallery.enroll("wall", hf.Surface(np.tile([0.0, 0.0, 1.0], (*SHAPE, 1)), np.ones(SHAPE)))
    gallery.enroll("photographed", np.random.default_rng(7).uniform(0, 1, (4, *SHAPE)))
    return gallery


PHOTOS = np.random.default_rng(8).uniform(0, 1, (6, *SHAPE))


@pytest.fixture
def path(tmp_path: Path) -> Path:
    small_gallery().save(tmp_path / "people.safetensors")
    return tmp_path / "people.safetensors"


def refused(path: Path) -> str:
    with pytest.raises(hf.HarmonicFaceError) as caught:
        hf.Gallery.open(path)
    message = str(caught.value)
    assert "\n" not in message
    assert str(path) in message
    assert "expected" in message
    return message


def same_answers(first: hf.Gallery, second: hf.Gallery) -> None:
    rng = np.random.default_rng(0)
    for photo in PHOTOS:
        for mask in (None, rng.uniform(size=SHAPE) < 0.8):
            one, other = first.match(photo, top=9, mask=mask), second.match(photo, top=9, mask=mask)
            assert one.candidates == other.candidates
            assert (one.name, one.distance, one.margin) == (other.name, other.distance, other.margin)
            assert (one.light is None) == (other.light is None)
            if one.light is not None and other.light is not None:
                assert_array_equal(one.light.values, other.light.values)


@pytest.mark.parametrize("model", ["linear3", "ambient4", "harmonic9"])
def test_an_opened_gallery_answers_the_same_bit_for_bit(tmp_path: Path, model: str) -> None:
    gallery = hf.Gallery(model)
    for seed in range(3):
        gallery.enroll(str(seed), surface(seed))
    gallery.save(tmp_path / "people.safetensors")
    opened = hf.Gallery.open(tmp_path / "people.safetensors")
    assert opened.model == model
    same_answers(gallery, opened)


def test_everything_about_a_gallery_comes_back(path: Path) -> None:
    gallery, opened = small_gallery(), hf.Gallery.open(path)
    assert opened.names == gallery.names
    assert (opened.threshold, opened.margin, opened.shortlist, opened.model) == (0.25, 1.5, 7, "harmonic9")
    assert_array_equal(opened.mask, gallery.mask)
    same_answers(gallery, opened)


def test_an_infinite_margin_comes_back(tmp_path: Path) -> None:
    gallery = small_gallery()
    gallery.margin = np.inf
    gallery.save(tmp_path / "people.safetensors")
    assert hf.Gallery.open(tmp_path / "people.safetensors").margin == np.inf


def test_an_opened_gallery_can_grow_and_shrink_and_be_saved_in_its_place(path: Path) -> None:
    opened, expected = hf.Gallery.open(path), small_gallery()
    for gallery in (opened, expected):
        gallery.remove("wall")
        gallery.enroll("grace", surface(9))
    opened.save(path)
    same_answers(hf.Gallery.open(path), expected)


def test_every_cut_is_refused(path: Path) -> None:
    data = path.read_bytes()
    for length in [*range(0, 1200), *range(1200, len(data), 37), len(data) - 1]:
        path.write_bytes(data[:length])
        refused(path)


def test_every_byte_of_the_header_and_bytes_of_the_data_are_watched(path: Path) -> None:
    data = path.read_bytes()
    header = 8 + int.from_bytes(data[:8], "little")
    places = [*range(header), *np.random.default_rng(0).integers(header, len(data), 200)]
    for place in places:
        for flip in (0x01, 0x80):
            path.write_bytes(data[:place] + bytes([data[place] ^ flip]) + data[place + 1 :])
            refused(path)


def test_no_gallery() -> None:
    with pytest.raises(hf.HarmonicFaceError, match=r"expected a gallery at none\.gallery, got none"):
        hf.Gallery.open("none.gallery")


def test_a_folder(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    assert refused(tmp_path).endswith("got a folder that is none")
    with pytest.raises(hf.HarmonicFaceError, match=r"cannot make the folder .*: Directory not empty"):
        small_gallery().save(tmp_path)
    with pytest.raises(hf.HarmonicFaceError, match=r"save: expected a new path or a gallery's, got .*of another kind"):
        small_gallery().save(tmp_path / "notes.txt")
    assert [one.name for one in tmp_path.iterdir()] == ["notes.txt"]
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_a_foreign_file_of_the_same_format(tmp_path: Path) -> None:
    save_file({"rows": np.ones((2, 2), np.float32)}, tmp_path / "weights.safetensors")
    assert "damaged or foreign" in refused(tmp_path / "weights.safetensors")


def changed(path: Path, change: Callable[[dict, dict, dict], None]) -> str:
    """Change a gallery's parts, write them with a right checksum, and return how the file is refused."""
    arrays, header = read_arrays(path)
    arrays = {name: array.copy() for name, array in arrays.items()}
    about = json.loads(header["about"])
    change(arrays, about, header)
    if "about" in header and header["about"] != "[":
        header["about"] = json.dumps(about)
    write_arrays(path, arrays, header)
    return refused(path)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("format", "harmonicface atlas", "expected a harmonicface gallery, got a file of 'harmonicface atlas'"),
        ("format", None, "expected a harmonicface gallery, got a file of 'another kind'"),
        ("version", "4", "expected version 1, 2, 3 of the gallery format, got 4"),
        ("version", None, "expected version 1, 2, 3 of the gallery format, got None"),
        ("about", None, "expected a gallery that agrees with itself"),
        ("about", "[", "expected a gallery that agrees with itself"),
    ],
)
def test_headers_of_others(path: Path, key: str, value: str | None, message: str) -> None:
    def change(_arrays: dict, _about: dict, header: dict) -> None:
        del header[key]
        if value is not None:
            header[key] = value

    assert message in changed(path, change)


@pytest.mark.parametrize("name", ["mask", "rows", "to_coefficients", "shapes"])
def test_missing_parts(path: Path, name: str) -> None:
    assert "agrees with itself" in changed(path, lambda arrays, *_: arrays.pop(name))


@pytest.mark.parametrize("name", ["model", "threshold", "margin", "people"])
def test_missing_words(path: Path, name: str) -> None:
    assert "agrees with itself" in changed(path, lambda _, about, __: about.pop(name))


def put(name: str, value: Callable[[np.ndarray], np.ndarray]) -> Callable[[dict, dict, dict], None]:
    def change(arrays: dict, _about: dict, _header: dict) -> None:
        arrays[name] = np.ascontiguousarray(value(arrays[name]))

    return change


def say(name: str, value: object) -> Callable[[dict, dict, dict], None]:
    def change(_arrays: dict, about: dict, _header: dict) -> None:
        about[name] = value

    return change


CONTRADICTIONS = {
    "a row too few": put("rows", lambda rows: rows[:-1]),
    "a pixel too few": put("rows", lambda rows: rows[:, :-1]),
    "rows in double": put("rows", lambda rows: rows.astype(np.float64)),
    "a row of NaN": put("rows", lambda rows: np.where(np.arange(len(rows))[:, None] == 2, np.nan, rows)),
    "a number of infinity": put("to_coefficients", lambda matrix: np.full_like(matrix, np.inf)),
    "a number too few": put("to_coefficients", lambda matrix: matrix[:-1]),
    "a number too many": put("to_coefficients", lambda matrix: np.append(matrix, 0.0)),
    "a mask of numbers": put("mask", lambda mask: mask.astype(np.uint8)),
    "a flat mask": put("mask", lambda mask: mask.ravel()),
    "another mask": put("mask", lambda mask: ~mask),
    "shapes of one number": put("shapes", lambda shapes: shapes[:, 0]),
    "shapes of floats": put("shapes", lambda shapes: shapes.astype(np.float64)),
    "a person too few": put("shapes", lambda shapes: shapes[:-1]),
    "negative shapes": put("shapes", lambda shapes: -shapes),
    "empty shapes": put("shapes", lambda shapes: shapes[:0]),
    "one of her twice": say("people", [["ada", "surface"]] * 5),
    "a name too few": say("people", [["ada", "surface"], ["emmy", "surface"]]),
    "people without sources": say("people", ["ada", "emmy", "a", "b", "c"]),
    "sources of another kind": say("people", [[str(number), "hearsay"] for number in range(5)]),
    "nobody": say("people", []),
    "people of another kind": say("people", 5),
    "no such model": say("model", "magic"),
    "a model of another kind": say("model", ["harmonic9"]),
    "a threshold above one": say("threshold", 2),
    "a threshold of text": say("threshold", "0.2"),
    "no threshold": say("threshold", None),
    "a margin below one": say("margin", 0.5),
    "a margin of NaN": say("margin", float("nan")),
    "a margin of text": say("margin", "wide"),
    "a shortlist of one": say("shortlist", 1),
    "a shortlist of half a person": say("shortlist", 7.5),
    "a shortlist of text": say("shortlist", "7"),
}


@pytest.mark.parametrize("change", CONTRADICTIONS.values(), ids=CONTRADICTIONS)
def test_parts_that_contradict_each_other(path: Path, change: Callable[[dict, dict, dict], None]) -> None:
    assert "expected a gallery that agrees with itself, got one that does not" in changed(path, change)


def test_nobody_is_nothing_to_save(tmp_path: Path) -> None:
    with pytest.raises(hf.HarmonicFaceError, match="save: expected a gallery with somebody in it, got an empty one"):
        hf.Gallery().save(tmp_path / "people.safetensors")
    assert list(tmp_path.iterdir()) == []


def test_a_save_that_fails_leaves_the_old_file_and_no_other(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(file: Path, content: bytes) -> int:
        with file.open("wb") as stream:
            stream.write(content[:10])
        raise OSError(28, "No space left on device")

    before = path.read_bytes()
    gallery = hf.Gallery.open(path)
    gallery.enroll("grace", surface(9))
    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(hf.HarmonicFaceError, match=r"cannot write .*people\.safetensors: .*No space left on device"):
        gallery.save(path)
    assert path.read_bytes() == before
    assert list(path.parent.iterdir()) == [path]


def test_a_gallery_that_does_not_say_its_shortlist_has_the_usual_one(path: Path) -> None:
    arrays, header = read_arrays(path)
    about = {word: value for word, value in json.loads(header["about"]).items() if word != "shortlist"}
    write_arrays(path, arrays, {**header, "about": json.dumps(about)})
    assert hf.Gallery.open(path).shortlist == hf.Gallery().shortlist


@pytest.mark.parametrize("version", ["1", "2"])
def test_a_gallery_of_an_older_version_opens(path: Path, version: str) -> None:
    arrays, header = read_arrays(path)
    write_arrays(path, arrays, {**header, "version": version})
    same_answers(hf.Gallery.open(path), small_gallery())


TEMPLATES = {
    "no templates": lambda arrays, *_: arrays.pop("templates"),
    "a template too few": put("templates", lambda templates: templates[:-1]),
    "templates of another size": put("templates", lambda templates: templates[:, 1:]),
    "templates in float32": put("templates", lambda templates: templates.astype(np.float32)),
    "templates of NaN": put("templates", lambda templates: templates * np.float16(np.nan)),
    "templates beyond what patterns are": put("templates", lambda templates: templates + np.float16(10)),
    "a threshold of infinity": say("threshold", float("inf")),
}


@pytest.mark.parametrize("change", TEMPLATES.values(), ids=TEMPLATES)
def test_templates_that_do_not_fit(tmp_path: Path, change: Callable[[dict, dict, dict], None]) -> None:
    gallery = hf.Gallery()
    for index, person in enumerate(hf.synthetic_people(2, 24, seed=1)):
        gallery.enroll(str(index), person)
    gallery.save(tmp_path / "people.safetensors")
    assert "expected a gallery that agrees with itself" in changed(tmp_path / "people.safetensors", change)


def test_templates_of_an_older_version_are_refused(tmp_path: Path) -> None:
    gallery, path = hf.Gallery(), tmp_path / "people.safetensors"
    gallery.enroll("ada", hf.synthetic_person(1, 24))
    gallery.save(path)

    def change(_arrays: dict, _about: dict, header: dict) -> None:
        header["version"] = "2"

    assert "expected templates of version 3 of the gallery format, got those of 2: enrol" in changed(path, change)


def test_a_name_that_earlier_versions_let_be_is_told(path: Path) -> None:
    names = [["ada", "surface"], *([f"x/{number}", "surface"] for number in range(4))]
    assert "name: expected one without slashes, got 'x/0'" in changed(path, say("people", names))
