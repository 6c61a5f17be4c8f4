"""Shards: mapped, checked against what the manifest says, and refused in one line otherwise."""

from __future__ import annotations

import dataclasses
import os
import resource
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from safetensors import safe_open

from harmonicface.errors import HarmonicFaceError
from harmonicface.store.batch import Batch
from harmonicface.store.entry import Kind
from harmonicface.store.plain_file import NotOpenedError
from harmonicface.store.shard import Record, Shard, damaged_entries, write_shard
from harmonicface.store.tensors import checksum


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "0000000000.safetensors"


@pytest.fixture
def record(path, kinds, make) -> Record:
    return write_shard(path, kinds, [Batch([make(1), make(2)]), Batch([make(3)])])


def fault(path: Path, record: Record, kinds: dict[str, Kind]) -> str:
    """Return with what a shard refuses to show its arrays."""
    shard = Shard(path, record, kinds)
    with pytest.raises(HarmonicFaceError) as caught:
        _ = shard.arrays
    assert str(caught.value) == shard.fault
    assert "\n" not in shard.fault
    assert str(path) in shard.fault
    return shard.fault


def rewritten(path: Path, record: Record, old: bytes, new: bytes) -> Record:
    """Change bytes of the header, and let the record agree."""
    content = path.read_bytes()
    assert len(old) == len(new)
    assert old in content[: record.directory_start]
    path.write_bytes(content.replace(old, new, 1))
    head = np.frombuffer(path.read_bytes()[: record.directory_start], np.uint8)
    return dataclasses.replace(record, header=checksum(head))


def test_what_is_written_is_mapped(path, record, kinds, make) -> None:
    shard = Shard(path, record, kinds)
    assert shard.fault is None
    assert record.nbytes == path.stat().st_size
    for index, number in enumerate((1, 2, 3)):
        for name, array in shard.entry(index).items():
            assert_array_equal(array, make(number).arrays[name])
            assert array.flags.aligned
            assert not array.flags.writeable
    assert shard.directory.key(2) == "entry 3"
    assert not damaged_entries(shard, np.arange(3))


def test_the_library_reads_it(path, record, make) -> None:
    with safe_open(path, "np") as file:
        assert file.metadata() == {"format": "harmonicface shard", "version": "1"}
        assert_array_equal(file.get_tensor("entries.rows"), np.concatenate([make(n).arrays["rows"] for n in (1, 2, 3)]))


def test_what_is_mapped_outlives_the_file_and_being_forgotten(path, record, kinds, make) -> None:
    shard = Shard(path, record, kinds)
    path.unlink()
    shard.forget()
    assert_array_equal(shard.entry(1)["rows"], make(2).arrays["rows"])


def test_a_missing_a_longer_and_a_shorter_file(path, record, kinds) -> None:
    content = path.read_bytes()
    path.unlink()
    assert "expected a file that can be mapped, got: No such file or directory" in fault(path, record, kinds)
    path.write_bytes(content + b"x")
    assert f"expected {record.nbytes} bytes, got {record.nbytes + 1}" in fault(path, record, kinds)
    path.write_bytes(content[:-1])
    assert f"expected {record.nbytes} bytes, got {record.nbytes - 1}" in fault(path, record, kinds)


def test_links_and_pipes_are_not_opened(path, record, kinds, tmp_path) -> None:
    path.rename(tmp_path / "elsewhere")
    path.symlink_to(tmp_path / "elsewhere")
    assert "symbolic links" in fault(path, record, kinds)
    path.unlink()
    os.mkfifo(path)
    assert "expected a plain file" in fault(path, record, kinds)


def test_no_more_files_can_be_opened(path, record, kinds) -> None:
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    held = []
    resource.setrlimit(resource.RLIMIT_NOFILE, (64, hard))
    try:
        with pytest.raises(NotOpenedError, match="got: Too many open files"):
            for _ in range(100):
                held.append(Shard(path, record, kinds))  # noqa: PERF401 - kept when it raises
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    assert held
    assert not any(shard.fault for shard in held)


def test_another_header(path, record, kinds) -> None:
    rewritten(path, record, b'"F32"', b'"I32"')
    assert "expected the header it was written with" in fault(path, record, kinds)


def test_a_header_of_terabytes(path, record, kinds) -> None:
    content = path.read_bytes()
    path.write_bytes((10**12).to_bytes(8, "little") + content[8:])
    assert "expected a header of at most" in fault(path, record, kinds)


def test_an_array_of_terabytes(path, record, kinds) -> None:
    said = rewritten(path, record, b"[9,5]", b"[9e9]")
    assert "a type, a shape and a place" in fault(path, said, kinds)
    said = rewritten(path, said, b"[9e9]", b"[9,9]")
    assert "expected arrays one behind the other" in fault(path, said, kinds)


@pytest.mark.parametrize(("old", "new"), [(b'"F32"', b'"I32"'), (b"[9,5]", b"[5,9]")])
def test_a_wrong_type_or_shape(path, record, kinds, old, new) -> None:
    said = rewritten(path, record, old, new)
    assert "rows: expected rows of shape (5,) and float32, got" in fault(path, said, kinds)


def test_other_arrays(path, record, kinds) -> None:
    said = rewritten(path, record, b"entries.rows", b"entries.rowz")
    assert "expected arrays ['marks', 'rows', 'sizes'], got" in fault(path, said, kinds)


def test_no_second_directory(path, record, kinds) -> None:
    said = rewritten(path, record, b"directory again", b"directory_again")
    assert "expected two directories of" in fault(path, said, kinds)


def test_either_directory_may_be_lost(path, record, kinds) -> None:
    content = bytearray(path.read_bytes())
    content[record.directory_start + 300] ^= 1
    path.write_bytes(content)
    assert Shard(path, record, kinds).directory.key(0) == "entry 1"
    content[-record.directory_bytes + 300] ^= 1
    path.write_bytes(content)
    with pytest.raises(HarmonicFaceError, match="expected a directory of its entries, got two damaged ones"):
        _ = Shard(path, record, kinds).directory
    content[record.directory_start + 300] ^= 1
    path.write_bytes(content)
    assert Shard(path, record, kinds).directory.key(0) == "entry 1"


def test_a_directory_of_other_rows(path, record, kinds, make, tmp_path) -> None:
    other = write_shard(tmp_path / "other", kinds, [Batch([make(1), make(2), make(7)]), Batch([make(3)])])
    said = write_shard(tmp_path / "more", kinds, [Batch([make(1), make(2)]), Batch([make(2, "entry 3")])])
    assert other.entries != record.entries
    content = bytearray(path.read_bytes())
    directory = (tmp_path / "more").read_bytes()[-said.directory_bytes :]
    content[record.directory_start : record.directory_start + len(directory)] = directory
    path.write_bytes(content)
    mixed = dataclasses.replace(record, directory=said.directory)
    with pytest.raises(HarmonicFaceError, match=r"expected arrays of \[5, 8, 3\] rows, got \[6, 9, 3\]"):
        _ = Shard(path, mixed, kinds).directory


def test_an_entry_that_was_changed(path, record, kinds) -> None:
    content = bytearray(path.read_bytes())
    place = bytes(content).index(np.full(5, 2, np.float32).tobytes())
    content[place] ^= 1
    path.write_bytes(content)
    shard = Shard(path, record, kinds)
    assert damaged_entries(shard, np.arange(3)) == [1]
    assert damaged_entries(shard, np.array([0, 2])) == []


def test_a_folder_that_is_not_there(tmp_path, kinds, make) -> None:
    with pytest.raises(HarmonicFaceError, match="cannot write"):
        write_shard(tmp_path / "none" / "0000000000.safetensors", kinds, [Batch([make(1)])])
