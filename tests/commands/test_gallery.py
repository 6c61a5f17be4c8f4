"""harmonicface gallery: what it says of a gallery, what it finds damaged, what it takes out and copies."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import harmonicface as hf
from harmonicface.errors import HarmonicFaceError
from harmonicface.store.folder import ArrayFolder
from tests.command import Run, runner

NAMES = ("ada", "emmy", "sofia", "maria")
PEOPLE = tuple(hf.synthetic_people(len(NAMES), 24, seed=1))
PAGE = Path(__file__).parents[2] / "docs" / "galleries.md"


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    return runner(monkeypatch, capsys, "gallery")


@pytest.fixture
def refused(run: Run) -> Callable[..., str]:
    """Run what cannot be done; return the one line that says why."""

    def called(*arguments: object) -> str:
        answer = run(*arguments)
        assert (answer.code, answer.out) == (2, "")
        assert answer.err.startswith("harmonicface: ")
        assert answer.err.count("\n") == 1, answer.err
        return answer.err

    return called


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Return a gallery of two shards: three people, and one."""
    path = tmp_path / "people"
    gallery = hf.Gallery.create(path)
    for name, person in zip(NAMES, PEOPLE, strict=True):
        gallery.enroll(name, person)
    return path


def shard_of(path: Path, name: str) -> tuple[Path, int]:
    """Return the file that has somebody's rows, and where in it they begin."""
    part, index = ArrayFolder(path).version().place(name)
    file = path / part.listed.record.file
    return file, file.read_bytes().index(part.entry(index).arrays["rows"].tobytes())


def flip(file: Path, place: int) -> None:
    """Change one bit of a file."""
    content = bytearray(file.read_bytes())
    content[place] ^= 4
    file.write_bytes(content)


def test_info(run, path) -> None:
    answer = run("info", path)
    assert (answer.code, answer.err) == (0, "")
    assert f"{path}: 4 people, format 4, " in answer.out
    assert "36 rows of 576 pixels of 24 x 24, float32" in answer.out
    assert "model default, threshold 6, shortlist 50" in answer.out
    assert "no index" in answer.out
    assert "compact" not in answer.out
    hf.Gallery.open(path).remove("emmy")
    assert "of removed people: `harmonicface gallery compact` frees them" in run("info", path).out


def test_info_as_json(run, path) -> None:
    gallery = hf.Gallery.open(path)
    gallery.remove("emmy")
    found = json.loads(run("info", path, "--json").out)
    files = sum(file.stat().st_size for file in path.iterdir())
    assert found["bytes"] == files
    assert (found["people"], found["rows"], found["dtype"], found["version"]) == (3, 27, "float32", "4")
    assert (found["shape"], found["pixels"], found["index"], found["damaged"]) == ([24, 24], 576, None, 0)
    assert (found["model"], found["threshold"]) == (gallery.model, gallery.threshold)
    assert found["bytes_per_person"] == (files - found["removed_bytes"]) / 3
    part, index = ArrayFolder(path).version().place("ada")
    assert found["removed_bytes"] == part.entry(index).nbytes  # as much as of each of the others
    freed = gallery.compact()
    after = json.loads(run("info", path, "--json").out)
    assert after["removed_bytes"] == 0
    assert found["removed_bytes"] <= freed <= found["removed_bytes"] + 5000  # and her line in both directories


def test_info_of_an_empty_gallery_and_of_a_file(run, path, tmp_path) -> None:
    hf.Gallery.create(tmp_path / "nobody", mask=np.ones((24, 24), np.bool_))
    found = json.loads(run("info", tmp_path / "nobody", "--json").out)
    assert (found["people"], found["rows"], found["bytes_per_person"]) == (0, 0, 0)
    assert "0 people" in run("info", tmp_path / "nobody").out
    file = tmp_path / "people.safetensors"
    hf.Gallery.open(path).save(file)
    found = json.loads(run("info", file, "--json").out)
    assert (found["people"], found["rows"], found["version"], found["shards"]) == (4, 36, "3", 0)
    assert found["bytes"] == file.stat().st_size
    assert "format 3, one file" in run("info", file).out


def test_info_of_an_index(run, path) -> None:
    hf.Gallery.open(path).index(seed=3)
    index = json.loads(run("info", path, "--json").out)["index"]
    assert (index["rows"], index["sample"], index["sketched"]) == (index["stages"][-1], 4, 4)
    said = f"index: {index['rows']} rows learned from 4 people, looked at in stages of {index['stages'][0]}"
    assert said in run("info", path).out
    assert "; 4 of 4 are sketched" in run("info", path).out


def test_everybody_removed_and_somebody_again(run, path) -> None:
    assert run("remove", path, *NAMES).out.endswith("holds 0 people\n")
    assert run("compact", path).code == 0
    assert run("verify", path).code == 0
    assert "0 people" in run("info", path).out
    assert run("export", path, path.parent / "out").code == 2
    gallery = hf.Gallery.open(path)
    with pytest.raises(HarmonicFaceError, match="expected a gallery with somebody in it, got an empty one"):
        gallery.match(np.ones((24, 24)))
    gallery.enroll("ada", PEOPLE[0])
    assert hf.Gallery.open(path).match(hf.render(PEOPLE[0], hf.lights.natural(1))).candidates[0].name == "ada"


def test_what_is_no_gallery(refused, tmp_path) -> None:
    (tmp_path / "file").write_text("x")
    (tmp_path / "folder").mkdir()
    for command in ("info", "compact"):
        for name in ("none", "file", "folder", "a" * 300):
            assert "expected" in refused(command, tmp_path / name)
    for name, got in (("none", "none"), ("folder", "a folder that is none")):
        for command in ("info", "verify"):
            assert f"expected a gallery at {tmp_path / name}, got {got}" in refused(command, tmp_path / name)
        assert "expected" in refused("export", tmp_path / name, tmp_path / "out")
        assert "expected" in refused("rename", tmp_path / name, "ada", "emmy")
        assert "expected" in refused("remove", tmp_path / name, "ada")


def test_all_is_well(run, path, tmp_path) -> None:
    answer = run("verify", path)
    assert (answer.code, answer.out) == (0, f"{path}: all well\n")
    assert json.loads(run("verify", path, "--json").out) == {"gallery": str(path), "well": True, "damaged": []}
    file = tmp_path / "people.safetensors"
    hf.Gallery.open(path).save(file)
    assert run("verify", file).out == f"{file}: all well\n"


def test_a_damaged_person_is_named_and_nobody_else(run, path) -> None:
    file, place = shard_of(path, "emmy")
    flip(file, place + 1000)
    answer = run("verify", path)
    assert answer.code == 1
    assert f"damaged: {file}: expected finite arrays with the checksums they had" in answer.out
    assert answer.out.endswith(" people lost: emmy\n")
    assert "all well" not in answer.out
    answer = run("verify", path, "--json")
    (damage,) = json.loads(answer.out)["damaged"]
    assert (answer.code, damage["file"], damage["people"]) == (1, file.name, ["emmy"])
    assert run("remove", path, "emmy").out == f"1 person removed; {path} holds 3 people\n"
    assert run("compact", path).code == 0
    assert run("verify", path).code == 0
    assert hf.Gallery.open(path).names == ("ada", "sofia", "maria")


def test_a_shard_that_cannot_be_opened(run, path) -> None:
    file, _ = shard_of(path, "emmy")
    file.write_bytes(file.read_bytes()[:-1])
    (damage,) = json.loads(run("verify", path, "--json").out)["damaged"]
    assert "emmy" in damage["people"]
    assert json.loads(run("info", path, "--json").out)["damaged"] == 1
    assert "1 damaged shard left out" in run("info", path).out


def test_what_is_damaged_is_discarded_and_enrolled_again(run, path) -> None:
    file, _ = shard_of(path, "sofia")
    lost = {"emmy", *(name for name in NAMES if shard_of(path, name)[0] == file)}
    flip(*shard_of(path, "emmy"))
    file.write_bytes(file.read_bytes()[:-1])
    answer = run("verify", path, "--discard", "--json")
    assert answer.code == 1
    assert {name for one in json.loads(answer.out)["damaged"] for name in one["people"]} == lost
    gallery = hf.Gallery.open(path)
    assert set(gallery.names) == set(NAMES) - lost
    gallery.enroll("emmy", PEOPLE[1])
    gallery.compact()
    assert run("verify", path).code == 0


def test_rows_that_no_gallery_has_are_found_behind_right_checksums(run, path) -> None:
    folder = ArrayFolder(path)
    entry = folder.version().entry("emmy")
    arrays = {**entry.arrays, "rows": entry.arrays["rows"] * np.float32(1.1)}
    folder.remove("emmy")
    folder.append([dataclasses.replace(entry, arrays=arrays)])
    (damage,) = json.loads(run("verify", path, "--discard", "--json").out)["damaged"]
    assert damage["people"] == ["emmy"]
    assert "expected orthonormal rows, got some that are not" in damage["reason"]
    assert run("verify", path).code == 0
    assert hf.Gallery.open(path).names == ("ada", "sofia", "maria")


def test_names_that_people_do_not_have_are_printed_on_one_line(run, path) -> None:
    folder = ArrayFolder(path)
    folder.rename("ada", "a\nb" + "c" * 500)
    answer = run("verify", path)
    assert answer.code == 1
    assert len(answer.out.splitlines()) == 2
    assert answer.out.endswith("lost: 'a\\nb" + "c" * 75 + "\n")
    assert all(len(line) < 500 for line in answer.out.splitlines())


@pytest.mark.parametrize("name", ["manifest.json", "0000000000.safetensors"])
def test_what_cannot_be_opened_without_is_told_as_damage_too(run, path, name) -> None:
    flip(path / name, 100)  # the manifest; the mask
    answer = run("verify", path, "--json")
    (damage,) = json.loads(answer.out)["damaged"]
    assert (answer.code, damage["file"]) == (1, name)
    assert name in damage["reason"]


def test_a_damaged_file(run, path, tmp_path) -> None:
    file = tmp_path / "people.safetensors"
    hf.Gallery.open(path).save(file)
    flip(file, 5000)
    answer = run("verify", file)
    assert answer.code == 1
    assert f"damaged: {file}: expected the checksum it was written with" in answer.out


def test_removed_and_compacted_bytes_are_gone(run, path) -> None:
    part, index = ArrayFolder(path).version().place("emmy")
    rows = part.entry(index).arrays["rows"].tobytes()
    assert run("remove", path, "emmy", "maria").out == f"2 people removed; {path} holds 2 people\n"
    assert any(rows in file.read_bytes() for file in path.iterdir())
    assert re.fullmatch(r".*: [\d.]+ KiB freed; it takes [\d.]+ KiB\n", run("compact", path).out)
    assert not any(rows in file.read_bytes() or b"emmy" in file.read_bytes() for file in path.iterdir())
    assert hf.Gallery.open(path).names == ("ada", "sofia")


def test_remove_takes_all_or_none(refused, run, path, tmp_path) -> None:
    assert "'eve'" in refused("remove", path, "ada", "eve")
    assert "each name once" in refused("remove", path, "ada", "ada")
    assert hf.Gallery.open(path).names == NAMES
    file = tmp_path / "people.safetensors"
    hf.Gallery.open(path).save(file)
    assert "'eve'" in refused("remove", file, "ada", "eve")
    assert run("remove", file, "ada").out == f"1 person removed; {file} holds 3 people\n"
    assert hf.Gallery.open(file).names == NAMES[1:]


def test_rename(run, refused, path, tmp_path) -> None:
    assert run("rename", path, "ada", "Ada Lovelace").out == f"ada is Ada Lovelace in {path}\n"
    assert "'ada'" in refused("rename", path, "ada", "eve")
    assert "'emmy'" in refused("rename", path, "Ada Lovelace", "emmy")
    assert "printable" in refused("rename", path, "emmy", "a\nb")
    assert hf.Gallery.open(path).names == ("Ada Lovelace", *NAMES[1:])
    file = tmp_path / "people.safetensors"
    hf.Gallery.open(path).save(file)
    assert run("rename", file, "emmy", "Emmy Noether").code == 0
    assert hf.Gallery.open(file).names == ("Ada Lovelace", "Emmy Noether", *NAMES[2:])


def test_export(run, path, tmp_path) -> None:
    photo = hf.render(PEOPLE[1], hf.lights.directional([1, 1, 2]))
    expected = hf.Gallery.open(path).match(photo)
    out, file, back = tmp_path / "half", tmp_path / "one.safetensors", tmp_path / "back"
    assert re.fullmatch(r".*half: 4 people, [\d.]+ KiB\n", run("export", path, out, "--dtype", "float16").out)
    assert json.loads(run("info", out, "--json").out)["dtype"] == "float16"
    assert abs(hf.Gallery.open(out).match(photo).distance - expected.distance) < 1e-3
    assert run("export", path, file, "--people", "maria, emmy").code == 0
    assert hf.Gallery.open(file).names == ("maria", "emmy")
    assert run("export", file, back).code == 0
    found = hf.Gallery.open(back).match(photo)
    assert (found.name, back.is_dir()) == ("emmy", True)


def test_export_takes_no_place_unasked(run, refused, path, tmp_path) -> None:
    out = tmp_path / "out"
    assert run("export", path, out, "--people", "ada").code == 0
    assert "expected a new path or --replace" in refused("export", path, out)
    assert hf.Gallery.open(out).names == ("ada",)
    assert run("export", path, out, "--replace").code == 0
    assert hf.Gallery.open(out).names == NAMES
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "file").write_text("x")
    refused("export", path, tmp_path / "other", "--replace")
    refused("export", path, path, "--replace", "--people", "ada")
    assert (tmp_path / "other" / "file").read_text() == "x"
    assert hf.Gallery.open(path).names == NAMES


def test_an_export_that_cannot_be(refused, path, tmp_path) -> None:
    assert "float16" in refused("export", path, tmp_path / "out", "--dtype", "float8")
    assert "'eve'" in refused("export", path, tmp_path / "out", "--people", "ada,eve")
    assert "float32" in refused("export", path, tmp_path / "out.safetensors", "--dtype", "float16")
    assert "cannot" in refused("export", path, tmp_path / "none" / "out")
    assert sorted(file.name for file in tmp_path.iterdir()) == ["people"]


def test_the_page_about_galleries_runs(run, monkeypatch, tmp_path, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    (example,) = re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    exec(compile(example, "example", "exec"), {})
    assert capsys.readouterr().out == "('Ada Lovelace', 'emmy') True ()\n"
    for line in re.findall(r"harmonicface gallery +(\w+) +people", PAGE.read_text("utf-8")):
        assert run(line, "--help").code == 0
