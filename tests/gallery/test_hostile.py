"""Folders that somebody made to do harm: each is refused in one line or answers rightly, and a checkup tells of it."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
import re
import resource
import shutil
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import harmonicface as hf
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.disk.checkup import checkup
from harmonicface.store import writing
from harmonicface.store.batch import Batch
from harmonicface.store.entry import Entry
from harmonicface.store.folder import ArrayFolder
from harmonicface.store.manifest import NAME, write_manifest
from harmonicface.store.tensors import packed

NAMES = ("ada", "emmy", "sofia")
PEOPLE = dict(zip(NAMES, hf.synthetic_people(len(NAMES), 24, seed=1), strict=True))
PHOTO = hf.render(PEOPLE["emmy"], hf.lights.directional([1, 1, 2]))
Attack = Callable[[Path], None]


@pytest.fixture(scope="module", params=["default", "harmonic9", "with an index"])
def whole(request, tmp_path_factory) -> Path:
    """Return a gallery of three people, which is to be copied."""
    path = tmp_path_factory.mktemp("galleries") / request.param
    gallery = hf.Gallery.create(path, "harmonic9" if request.param == "with an index" else request.param)
    for name, person in PEOPLE.items():
        gallery.enroll(name, person)
    if request.param == "with an index":
        gallery.index()
    return path


@pytest.fixture
def path(whole, tmp_path) -> Path:
    """Return a gallery of three people."""
    return shutil.copytree(whole, tmp_path / "people")


def rewrite(path: Path, change: Callable[[dict[str, Any]], object]) -> None:
    """Change what the manifest says, with a right checksum."""
    content = json.loads((path / NAME).read_bytes().splitlines()[0])
    change(content)
    seal(path, json.dumps(content).encode())


def seal(path: Path, line: bytes) -> None:
    """Write a manifest's line with a right checksum."""
    (path / NAME).write_bytes(line + b'\n{"sha256":"' + hashlib.sha256(line).hexdigest().encode() + b'"}\n')


def replaced(path: Path, name: str, **arrays: Callable[[np.ndarray], np.ndarray]) -> None:
    """Put other arrays in the place of somebody's, with right checksums and without being asked."""
    folder = ArrayFolder(path)
    entry = folder.version().entry(name)
    other = {key: arrays.get(key, np.asarray)(array.copy()) for key, array in entry.arrays.items()}
    folder.remove(name)
    put(path, Entry(name, other, entry.about))


def put(path: Path, entry: Entry) -> None:
    """Add an entry that `append` would refuse."""
    with writing.alone(path, {}) as version:
        writing.put(path, version, Batch([entry]))


def about(path: Path, **words: Any) -> None:
    """Change what is said of the gallery."""
    rewrite(path, lambda content: content["about"].update(words))


def common(path: Path, **arrays: np.ndarray) -> None:
    """Change the gallery's own arrays."""
    ArrayFolder(path).describe(common={**ArrayFolder(path).version().common, **arrays})


def first_shard(content: dict[str, Any]) -> dict[str, Any]:
    return content["shards"][0]


def terabytes(path: Path) -> None:
    """Let a shard's header claim terabytes, and the manifest agree with it."""
    manifest = ArrayFolder(path).version().manifest
    record = manifest.shards[0].record
    file = path / record.file
    content = file.read_bytes()
    head = re.sub(rb'("shape":\[)(\d+)(,576\])', rb"\g<1>9000000000\g<3>", content[: record.directory_start])
    assert head != content[: record.directory_start]
    head = (len(head) - 8).to_bytes(8, "little") + head[8:]
    file.write_bytes(head + content[record.directory_start :])
    claimed = dataclasses.replace(
        record,
        nbytes=file.stat().st_size,
        header=hashlib.sha256(head).hexdigest(),
        directory_start=len(head),
    )
    listed = dataclasses.replace(manifest.shards[0], record=claimed)
    write_manifest(path, dataclasses.replace(manifest, shards=(listed, *manifest.shards[1:])))


def outside(path: Path, name: str) -> None:
    """Let the manifest speak of a file somewhere else."""
    file = first_shard(json.loads((path / NAME).read_bytes().splitlines()[0]))["file"]
    (path.parent / "outside.safetensors").write_bytes((path / file).read_bytes())
    rewrite(path, lambda content: first_shard(content).update(file=name))


def link(path: Path, file: str | None = None) -> None:
    """Let a file be a link to one somewhere else."""
    name = file or ArrayFolder(path).version().manifest.shards[0].record.file
    (path / name).rename(path.parent / "elsewhere")
    (path / name).symlink_to(path.parent / "elsewhere")


ATTACKS: dict[str, Attack] = {
    "a manifest that points above": lambda path: outside(path, "../outside.safetensors"),
    "a manifest that points anywhere": lambda path: outside(path, str(path.parent / "outside.safetensors")),
    "a file twice": lambda path: rewrite(path, lambda content: content["shards"].append(content["shards"][0])),
    "a shard that is a link": link,
    "a manifest that is a link": lambda path: link(path, NAME),
    "a pipe as manifest": lambda path: ((path / NAME).unlink(), os.mkfifo(path / NAME)),
    "a header of terabytes": terabytes,
    "a shard of more people": lambda path: rewrite(path, lambda content: first_shard(content).update(entries=10**15)),
    "a directory of terabytes": lambda path: rewrite(
        path, lambda content: first_shard(content).update(directory_bytes=10**13)
    ),
    "kinds of terabytes": lambda path: rewrite(path, lambda content: content["kinds"]["rows"].update(shape=[2**39])),
    "kinds that are none": lambda path: rewrite(path, lambda content: content.update(kinds=[])),
    "a nested manifest": lambda path: seal(path, b"[" * 100_000),
    "a number of many digits": lambda path: seal(path, b'{"generation":' + b"9" * 10_000 + b"}"),
    "another format": lambda path: about(path, format="other"),
    "a later version": lambda path: about(path, version="5"),
    "a later store": lambda path: rewrite(path, lambda content: content.update(version=2)),
    "an unknown model": lambda path: about(path, model="__import__('os')"),
    "no number as threshold": lambda path: about(path, threshold="0.1"),
    "NaN as threshold": lambda path: about(path, threshold=float("nan")),
    "a negative threshold": lambda path: about(path, threshold=-1),
    "a margin below 1": lambda path: about(path, margin=0.5),
    "a shortlist of terabytes": lambda path: about(path, shortlist=1e300),
    "another dtype": lambda path: about(path, dtype="float64"),
    "the other dtype": lambda path: about(path, dtype="float16"),
    "stages without a basis": lambda path: about(path, stops=[16, 32]),
    "a basis of fewer people than none": lambda path: about(path, sample=-1),
    "stages of terabytes": lambda path: about(path, stops=[2**62]),
    "no words": lambda path: rewrite(path, lambda content: content.update(about={})),
    "a mask of numbers": lambda path: common(path, mask=np.ones((24, 24))),
    "a mask of one row": lambda path: common(path, mask=np.ones(576, np.bool_)),
    "a mask of other pixels": lambda path: common(path, mask=np.eye(24, dtype=np.bool_)),
    "an empty mask": lambda path: common(path, mask=np.zeros((24, 24), np.bool_)),
    "more arrays": lambda path: common(path, more=np.eye(3, 576)),
    "NaN in rows": lambda path: replaced(path, "emmy", rows=lambda rows: rows * np.float32(np.nan)),
    "infinity in rows": lambda path: replaced(path, "emmy", rows=lambda rows: np.full_like(rows, np.inf)),
    "long rows": lambda path: replaced(path, "emmy", rows=lambda rows: rows * np.float32(1.01)),
    "a stranger's long rows": lambda path: replaced(path, "ada", rows=lambda rows: rows * np.float32(2)),
    "rows twice": lambda path: replaced(path, "ada", rows=lambda rows: np.concatenate([rows, rows[:1]])),
    "rows of 0": lambda path: replaced(path, "ada", rows=lambda rows: 0 * rows),
    "no rows": lambda path: replaced(path, "ada", rows=lambda rows: rows[:0]),
    "more rows than pixels": lambda path: replaced(path, "ada", rows=lambda rows: np.tile(rows, (100, 1))),
    "coefficients that do not fit": lambda path: replaced(path, "emmy", to_coefficients=lambda numbers: numbers[:-1]),
    "no coefficients": lambda path: replaced(path, "emmy", to_coefficients=lambda numbers: numbers[:0]),
    "NaN in coefficients": lambda path: replaced(path, "emmy", to_coefficients=lambda numbers: numbers * np.nan),
    "an unknown source": lambda path: unknown_source(path),
    "a name of a megabyte": lambda path: named(path, "x" * 2**20),
    "a name with separators": lambda path: named(path, "../../etc/passwd"),
    "a name on two lines": lambda path: named(path, "ada\nemmy"),
    "a renamed person with separators": lambda path: rewrite(
        path, lambda content: first_shard(content).update(renamed=[[0, "../ada"]])
    ),
    "a renamed person of a megabyte": lambda path: rewrite(
        path, lambda content: first_shard(content).update(renamed=[[0, "x" * 2**20]])
    ),
    "somebody twice": lambda path: put(path, ArrayFolder(path).version().entry("ada")),
}


INDEX_ATTACKS: dict[str, Attack] = {
    "NaN in the basis": lambda path: forged_basis(path, lambda basis: basis * np.nan),
    "a basis that is not orthonormal": lambda path: forged_basis(path, lambda basis: 1.01 * basis),
    "a basis of other pixels": lambda path: forged_basis(path, lambda basis: basis[:, :-1]),
    "a basis of fewer rows": lambda path: forged_basis(path, lambda basis: basis[:-1]),
    "a basis of float32": lambda path: forged_basis(path, lambda basis: basis.astype(np.float32)),
    "NaN in a sketch": lambda path: replaced(path, "emmy", sketch_form=lambda form: form * np.float32(np.nan)),
    "NaN in the doubts": lambda path: replaced(path, "emmy", sketch_doubts=lambda doubts: doubts * np.float32(np.nan)),
    "a defect without end": lambda path: replaced(path, "emmy", sketch_defect=lambda defect: defect + 1e300),
    "two forms": lambda path: replaced(path, "emmy", sketch_form=lambda form: np.tile(form, (2, 1))),
    "two forms of one, none of the other": lambda path: shifted(path),
    "a sketch of fewer rows": lambda path: replaced(path, "ada", sketch_numbers_0=lambda numbers: numbers[:-1]),
    "no levels": lambda path: replaced(path, "ada", sketch_levels=lambda levels: levels[:0]),
}


def forged_basis(path: Path, change: Callable[[np.ndarray], np.ndarray]) -> None:
    version = ArrayFolder(path).version()
    basis = np.ascontiguousarray(change(version.common["basis"]))
    content = packed({**version.common, "basis": basis}, {"format": "harmonicface common", "version": "1"})
    said = version.manifest.common
    (path / said.file).write_bytes(content)
    head = content[: 8 + int.from_bytes(content[:8], "little")]
    digests = {"digest": hashlib.sha256(content).hexdigest(), "header": hashlib.sha256(head).hexdigest()}
    rewrite(path, lambda manifest: manifest["common"].update(nbytes=len(content), **digests))


def shifted(path: Path) -> None:
    """Let one person of a shard have two forms and another none, so that all in all there are enough."""
    folder = ArrayFolder(path)
    entries = [folder.version().entry(name) for name in ("ada", "emmy")]
    forms = np.concatenate([entry.arrays["sketch_form"].copy() for entry in entries])
    for entry, some in zip(entries, (forms, forms[:0]), strict=True):
        arrays = {**entry.arrays, "sketch_form": some}
        folder.remove(entry.key)
        put(path, dataclasses.replace(entry, arrays={name: array.copy() for name, array in arrays.items()}))


def unknown_source(path: Path) -> None:
    folder = ArrayFolder(path)
    entry = folder.version().entry("emmy")
    folder.remove("emmy")
    folder.append([dataclasses.replace(entry, about={"source": ["nowhere"]})])


def named(path: Path, name: str) -> None:
    """Add somebody with another name."""
    entry = ArrayFolder(path).version().entry("ada")
    put(path, dataclasses.replace(entry, key=name))


def attacked(path: Path, attack: Attack) -> None:
    """Attack a gallery: it is refused in one line or answers rightly, and a checkup tells of it."""
    attack(path)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        try:
            match = hf.Gallery.open(path).match(PHOTO)
        except HarmonicFaceError as error:
            assert "expected" in str(error)
            assert "\n" not in str(error)
            assert len(str(error)) < 1000
        else:
            assert match.name in ("emmy", None)
            assert np.isfinite([one.distance for one in match.candidates]).all()
    assert all(one.category is UserWarning and "\n" not in str(one.message) for one in warned)
    found = checkup(path)
    assert found
    assert all("\n" not in damage.reason and len(damage.reason) < 1000 for damage in found)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 200_000  # KiB


@pytest.mark.parametrize("attack", ATTACKS.values(), ids=list(ATTACKS))
def test_it_is_refused_in_one_line_or_answered_rightly(path, attack) -> None:
    attacked(path, attack)


@pytest.mark.parametrize("whole", ["with an index"], indirect=True)
@pytest.mark.parametrize("attack", INDEX_ATTACKS.values(), ids=list(INDEX_ATTACKS))
def test_an_index_is_refused_in_one_line_or_answers_rightly(path, attack) -> None:
    attacked(path, attack)


@pytest.mark.parametrize("whole", ["with an index"], indirect=True)
def test_a_sketch_of_somebody_else_is_found(path) -> None:
    version = ArrayFolder(path).version()
    others = {name: array for name, array in version.entry("ada").arrays.items() if name.startswith("sketch_")}
    replaced(path, "emmy", **{name: lambda _, array=array: array.copy() for name, array in others.items()})
    (damage,) = checkup(path)
    assert damage.keys == ("emmy",)
    assert "expected a sketch of her rows, got another one" in damage.reason


def test_what_they_attack_is_well(path) -> None:
    assert checkup(path) == ()
    assert hf.Gallery.open(path).match(PHOTO).name == "emmy"


def test_a_manifest_is_not_bigger_than_memory(path) -> None:
    (path / NAME).unlink()
    with (path / NAME).open("wb") as stream:
        stream.truncate(1 << 40)
    with pytest.raises(HarmonicFaceError, match="expected a file of at most"):
        hf.Gallery.open(path)
    (damage,) = checkup(path)
    assert damage.file == NAME
