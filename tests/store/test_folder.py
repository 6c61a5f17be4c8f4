"""ArrayFolder: what it says it does, alone, with other writers, with readers, and when it is killed."""

from __future__ import annotations

import errno
import multiprocessing
import os
import random
import signal
import time
from contextlib import suppress
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from harmonicface.errors import HarmonicFaceError
from harmonicface.store.entry import Entry, Kind
from harmonicface.store.folder import ArrayFolder
from harmonicface.store.manifest import NAME, SHARD_NAME

PERSON = 150_000


def test_what_is_appended_is_there(folder, make, number) -> None:
    assert folder.append(make(n) for n in range(100)) == 100
    assert folder.append([]) == 0
    assert [number(entry) for entry in ArrayFolder(folder.path).version().entries()] == list(range(100))


def test_single_entries_make_few_shards(folder, make, number) -> None:
    for n in range(70):
        folder.append([make(n)])
    assert [number(entry) for entry in folder.version().entries()] == list(range(70))
    assert len(folder.version().parts) <= 10
    assert len(list(folder.path.iterdir())) == len(folder.version().parts) + 2
    assert folder.verify() == ()


def test_many_entries_are_written_by_the_piece(folder, make) -> None:
    def entries():
        for n in range(30):
            if n == 20:
                assert len(folder.version()) >= 10
            yield make(n)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        folder.append(entries(), shard_bytes=500)
    version = folder.version()
    assert version.keys == tuple(f"entry {n}" for n in range(len(version)))
    assert 20 < len(version) <= 30
    with pytest.raises(HarmonicFaceError, match="shard_bytes: expected an integer of at least 1"):
        folder.append([], shard_bytes=0)


def test_an_entry_that_does_not_fit_takes_its_piece_with_it(filled, make) -> None:
    before = filled.version().keys
    with pytest.raises(HarmonicFaceError, match=r"'bad': expected arrays \['marks', 'rows', 'sizes'\]"):
        filled.append([make(30), Entry("bad", {})])
    assert filled.version().keys == before


def test_a_key_that_is_taken(filled, make) -> None:
    before = filled.version().keys
    with pytest.raises(HarmonicFaceError, match="key: expected one that is not in the folder yet, got 'entry 12'"):
        filled.append([make(30), make(12)])
    with pytest.raises(HarmonicFaceError, match="key: expected one that is not in the folder yet, got 'entry 12'"):
        filled.rename("entry 1", "entry 12")
    assert filled.version().keys == before


def test_remove_and_rename(filled, number) -> None:
    filled.remove("entry 3")
    filled.remove(name for name in ("entry 0", "entry 19"))
    filled.rename("entry 4", "four")
    filled.rename("four", "vier")
    filled.rename("vier", "vier")
    filled.rename("entry 5", "entry 4")
    filled.remove("entry 4")
    filled.remove([])
    expected = [1, 2, 4, *range(6, 19), 20]
    assert [number(entry) for entry in filled.version().entries()] == expected
    assert number(filled.version().entry("vier")) == 4
    for gone in ("entry 3", "entry 4", "entry 5", "four"):
        assert gone not in filled.version()


def test_a_key_that_is_free_again(filled, make, number) -> None:
    filled.remove("entry 3")
    filled.append([make(33, "entry 3")])
    assert number(filled.version().entry("entry 3")) == 33
    assert filled.version().keys[-1] == "entry 3"


def test_nobody_of_that_key(filled) -> None:
    before = (filled.path / NAME).read_bytes()
    for call in (
        lambda: filled.remove("ada"),
        lambda: filled.remove(["entry 1", "ada"]),
        lambda: filled.rename("ada", "emmy"),
    ):
        with pytest.raises(HarmonicFaceError, match="key: expected one that is in the folder, got 'ada', which is not"):
            call()
    with pytest.raises(HarmonicFaceError, match="remove: expected every key once, got 'entry 1' twice"):
        filled.remove(["entry 1", "entry 1"])
    with pytest.raises(HarmonicFaceError, match="key: expected a text"):
        filled.rename("entry 1", "")
    assert (filled.path / NAME).read_bytes() == before


def test_everybody_removed(filled, make) -> None:
    filled.remove(filled.version().keys)
    assert len(filled.version()) == 0
    assert [path.name for path in filled.path.iterdir() if SHARD_NAME.fullmatch(path.name)] == [
        "0000000000.safetensors"
    ]
    filled.append([make(1)])
    assert filled.version().keys == ("entry 1",)


def test_about_and_common_are_replaced(filled) -> None:
    filled.describe({"what": [1, 2]})
    assert filled.version().about == {"what": [1, 2]}
    assert filled.version().common["mask"].dtype == np.bool_
    filled.describe(common={"basis": np.ones((2, 3))})
    assert set(filled.version().common) == {"basis"}
    assert filled.version().about == {"what": [1, 2]}
    with pytest.raises(HarmonicFaceError, match="about: expected what JSON can say"):
        filled.describe({"what": object()})


@pytest.mark.parametrize(
    "kinds",
    [
        {},
        {"rows": 3},
        {"": Kind(np.dtype("f4"))},
        {"a/b": Kind(np.dtype("f4"))},
        {"x" * 65: Kind(np.dtype("f4"))},
        {f"x{n}": Kind(np.dtype("f4")) for n in range(65)},
    ],
)
def test_kinds_that_are_none(tmp_path, kinds) -> None:
    with pytest.raises(HarmonicFaceError, match="kinds: expected a Kind by the name of each array"):
        ArrayFolder.create(tmp_path / "folder", kinds)
    assert not (tmp_path / "folder").exists()


def test_a_folder_that_is_taken_or_cannot_be(filled, tmp_path, kinds) -> None:
    with pytest.raises(HarmonicFaceError, match=r"create: expected a new or an empty folder, got .* with files"):
        ArrayFolder.create(filled.path, kinds)
    (tmp_path / "file").write_text("x")
    for path in (tmp_path / "file", tmp_path / "none" / "folder", tmp_path / "a\0b"):
        with pytest.raises(HarmonicFaceError, match="cannot make the folder"):
            ArrayFolder.create(path, kinds)


def test_what_a_killed_maker_left_is_in_nobodys_way(tmp_path, kinds) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / ".0000000000.partial-a_b0.safetensors").write_bytes(b"x")
    folder = ArrayFolder.create(tmp_path / "folder", kinds)
    assert [path.name for path in folder.path.iterdir()] == [NAME]


def test_a_folder_that_has_lost_its_manifest_is_not_emptied(filled, kinds) -> None:
    (filled.path / NAME).unlink()
    before = sorted(filled.path.iterdir())
    with pytest.raises(HarmonicFaceError, match="create: expected a new or an empty folder"):
        ArrayFolder.create(filled.path, kinds)
    with pytest.raises(HarmonicFaceError, match="expected a harmonicface store"):
        filled.compact()
    assert sorted(filled.path.iterdir()) == before


def test_a_full_disk_changes_nothing(filled, make, monkeypatch) -> None:
    before = sorted(filled.path.iterdir())

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "write", full)
    with pytest.raises(HarmonicFaceError, match=r"cannot write .*: No space left on device"):
        filled.append([make(30)])
    monkeypatch.undo()
    assert sorted(filled.path.iterdir()) == before
    assert len(ArrayFolder(filled.path).version()) == 21


def test_a_disk_that_is_full_at_any_moment_changes_nothing(filled, make, monkeypatch) -> None:
    """Refuse the first byte, the second piece, ... of everything that is written, shards and manifests."""
    before, number, failures = sorted(filled.path.iterdir()), 30, 0
    real_write, real_bytes = os.write, Path.write_bytes

    for moment in range(10):
        left = [moment]

        def full(*arguments, left=left, real=None):
            left[0] -= 1
            if left[0] < 0:
                raise OSError(errno.ENOSPC, "No space left on device")
            return real(*arguments)

        monkeypatch.setattr(os, "write", partial(full, real=real_write))
        monkeypatch.setattr(Path, "write_bytes", lambda *arguments: full(*arguments, real=real_bytes))
        try:
            filled.append([make(number)])
        except HarmonicFaceError as error:
            failures += 1
            assert "No space left on device" in str(error)
            assert sorted(filled.path.iterdir()) == before
            assert len(ArrayFolder(filled.path).version()) == 21
        else:
            break
        finally:
            monkeypatch.undo()
    assert failures >= 5  # header, three arrays, directory, manifest
    assert len(ArrayFolder(filled.path).version()) == 22


class Model(RuleBasedStateMachine):
    """A folder does what a dict does, whatever is done to it."""

    def __init__(self) -> None:
        super().__init__()
        Model.count += 1
        kinds = {"a": Kind(np.dtype("i8"), (700,)), "b": Kind(np.dtype("u1"))}
        self.folder = ArrayFolder.create(Model.place / str(Model.count), kinds)
        self.expected: dict[str, int] = {}
        self.versions: list[tuple[object, dict[str, int]]] = []
        self.number = 0

    count = 0
    place = Path()

    def entry(self, number: int) -> Entry:
        return Entry(
            f"e{number}",
            {"a": np.full((number % 3, 700), number), "b": np.full(number % 5, number % 256, np.uint8)},
            {"n": number},
        )

    @rule(count=st.integers(1, 4))
    def append(self, count: int) -> None:
        added = range(self.number, self.number + count)
        self.folder.append([self.entry(n) for n in added])
        self.expected.update({f"e{n}": n for n in added})
        self.number += count

    @precondition(lambda self: self.expected)
    @rule(data=st.data())
    def remove(self, data: st.DataObject) -> None:
        key = data.draw(st.sampled_from(list(self.expected)))
        self.folder.remove(key)
        del self.expected[key]

    @precondition(lambda self: self.expected)
    @rule(data=st.data())
    def rename(self, data: st.DataObject) -> None:
        key = data.draw(st.sampled_from(list(self.expected)))
        self.number += 1
        self.folder.rename(key, f"r{self.number}")
        self.expected = {f"r{self.number}" if k == key else k: n for k, n in self.expected.items()}

    @rule(nbytes=st.sampled_from([1, 10_000, 1 << 28]))
    def compact(self, nbytes: int) -> None:
        self.folder.compact(nbytes)

    @rule()
    def open(self) -> None:
        self.versions.append((self.folder.version(), dict(self.expected)))

    @rule()
    def another_process(self) -> None:
        self.folder = ArrayFolder(self.folder.path)

    @invariant()
    def all_versions_are_what_they_were(self) -> None:
        for version, expected in [*self.versions[-3:], (self.folder.version(), self.expected)]:
            assert list(version.keys) == list(expected)
            for found, (key, n) in zip(version.entries(), expected.items(), strict=True):
                assert (found.key, found.about) == (key, {"n": n})
                for name, array in self.entry(n).arrays.items():
                    assert np.array_equal(found.arrays[name], array)

    def teardown(self) -> None:
        assert self.folder.verify() == ()


def test_it_does_what_a_dict_does(tmp_path) -> None:
    Model.place = tmp_path
    machine = Model.TestCase
    machine.settings = settings(max_examples=12, stateful_step_count=25, deadline=None)
    machine().runTest()


WRITER = """
import numpy as np
from harmonicface.store.entry import Entry
from harmonicface.store.folder import ArrayFolder
folder = ArrayFolder(path)
for number in range(first, behind):
    folder.append([Entry(f"{who} {number}", {"rows": np.full((2, 9), number, np.float32)}, {"number": number})])
    if number % 5 == 4:
        folder.remove(f"{who} {number - 4}")
    if number % 50 == 49:
        folder.compact()
    told.send(number)
"""
SERVER = multiprocessing.get_context("forkserver")  # processes that have the package loaded
SERVER.set_forkserver_preload(["harmonicface.store.folder"])


def small(tmp_path: Path) -> ArrayFolder:
    return ArrayFolder.create(tmp_path / "folder", {"rows": Kind(np.dtype("f4"), (9,))})


class Writer:
    """A process that writes numbers and says which are done."""

    def __init__(self, folder: ArrayFolder, who: str, first: int, behind: int) -> None:
        self._told, told = SERVER.Pipe(duplex=False)
        known = {"path": folder.path, "who": who, "first": first, "behind": behind, "told": told}
        self.process = SERVER.Process(target=exec, args=(WRITER, known), daemon=True)
        self.process.start()
        told.close()

    def wait(self) -> int:
        """Wait until a number is done."""
        return int(self._told.recv())

    def rest(self) -> list[int]:
        """Wait for the end, and return the numbers that were done until then."""
        numbers = []
        with suppress(EOFError):
            while True:
                numbers.append(self.wait())
        self.process.join()
        self._told.close()
        return numbers


def expected_keys(who: str, done: int) -> set[str]:
    """Return whom a writer that acknowledged so many numbers keeps."""
    return {f"{who} {n}" for n in range(done) if n % 5 or n + 4 >= done}


def test_everybody_acknowledged_survives_a_writer_that_is_killed_30_times(tmp_path) -> None:
    folder, done = small(tmp_path), 0
    rng = random.Random(0)
    for _ in range(30):
        writer = Writer(folder, "a", done, 10**9)
        first = writer.wait()
        time.sleep(rng.uniform(0, 0.1))
        writer.process.kill()
        done = [first, *writer.rest()][-1] + 1
        assert writer.process.exitcode == -signal.SIGKILL
        found = set(ArrayFolder(folder.path).version().keys)
        assert found <= expected_keys("a", done) | {f"a {done}"}
        assert found >= expected_keys("a", done) - {f"a {done - 4}"}  # its removal may be under way
        assert folder.verify() == ()
        if f"a {done}" in found:  # appended, but not acknowledged
            folder.remove(f"a {done}")
        if f"a {done - 4}" in expected_keys("a", done) - found:
            folder.append([Entry(f"a {done - 4}", {"rows": np.full((2, 9), done - 4, np.float32)})])
        folder.describe({"done": done})
        assert {path.name for path in folder.path.iterdir()} == folder.version().manifest.files | {NAME}
    assert done > 30


def test_two_writers_lose_nothing(tmp_path) -> None:
    folder = small(tmp_path)
    writers = [Writer(folder, who, 0, 60) for who in "ab"]
    assert [writer.rest() for writer in writers] == [list(range(60))] * 2
    assert set(folder.version().keys) == expected_keys("a", 60) | expected_keys("b", 60)
    for who in "ab":
        ours = [key for key in folder.version().keys if key.startswith(who)]
        assert ours == sorted(ours, key=lambda key: int(key[2:]))
    assert folder.verify() == ()


def test_a_reader_never_sees_an_error_or_a_mix(tmp_path) -> None:
    folder = small(tmp_path)
    writer = Writer(folder, "a", 0, 120)
    looks = 0
    while writer.process.is_alive():
        version = ArrayFolder(folder.path).version()
        keys = [int(key[2:]) for key in version.keys]
        newest = max(keys, default=-1)
        missing = set(range(newest + 1)) - set(keys)
        assert keys == sorted(keys)
        assert missing <= set(range(0, newest, 5))
        assert set(range(0, newest - 4, 5)) <= missing
        for entry in version.entries():
            assert (entry.arrays["rows"] == entry.about["number"]).all()
        looks += 1
    assert writer.rest() == list(range(120))
    assert looks > 20
    assert set(folder.version().keys) == expected_keys("a", 120)


def resident() -> int:
    """Return the bytes of memory of this process that are in use."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def test_opening_takes_no_memory_and_compaction_little(tmp_path) -> None:
    kinds = {"rows": Kind(np.dtype("f4"), (PERSON // 36,))}
    folder = ArrayFolder.create(tmp_path / "folder", kinds)
    rows = np.ones((9, PERSON // 36), np.float32)
    folder.append((Entry(str(n), {"rows": rows}) for n in range(1000)), shard_bytes=1 << 24)
    before = resident()
    version = ArrayFolder(folder.path).version()
    assert len(version) == 1000
    assert resident() - before < 5e6
    assert folder.verify() == ()
    folder.remove([str(n) for n in range(0, 1000, 3)])
    folder.compact()
    assert resident() - before < 60e6
