"""Named arrays on disk: back bit for bit, or refused; replaced whole or not at all."""

from __future__ import annotations

import json
import pickle
import resource
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.testing import assert_array_equal
from safetensors.numpy import save_file

from harmonicface.errors import HarmonicFaceError
from harmonicface.store import archive
from harmonicface.store.archive import DIGEST, read_arrays, write_arrays

ARRAYS = {
    "rows": np.random.default_rng(0).normal(size=(3, 7)).astype(np.float32),
    "mask": np.eye(5, dtype=np.bool_),
    "sizes": np.array([3, 1], np.int64),
}
ABOUT = {"format": "a test", "names": 'ada, "emmy", \N{SNOWMAN}'}


@pytest.fixture
def path(tmp_path: Path) -> Path:
    write_arrays(tmp_path / "some.arrays", ARRAYS, ABOUT)
    return tmp_path / "some.arrays"


def refused(path: Path) -> str:
    """Return the one line with which the file is refused."""
    with pytest.raises(HarmonicFaceError) as caught:
        read_arrays(path)
    message = str(caught.value)
    assert "\n" not in message
    assert str(path) in message
    assert "expected" in message
    return message


def test_what_is_written_is_read(path: Path) -> None:
    arrays, about = read_arrays(path)
    assert about == ABOUT
    assert set(arrays) == set(ARRAYS)
    for name, array in ARRAYS.items():
        assert arrays[name].dtype == array.dtype
        assert_array_equal(arrays[name], array)


@settings(deadline=None, max_examples=30)
@given(
    st.dictionaries(
        st.text(st.characters(codec="utf-8"), min_size=1, max_size=8).filter(lambda name: name != DIGEST),
        hnp.arrays(
            st.sampled_from([np.float32, np.float64, np.int64, np.uint8, np.bool_]),
            hnp.array_shapes(min_dims=1, max_dims=3, min_side=0, max_side=4),
        ),
        max_size=4,
    )
)
def test_any_arrays_come_back_bit_for_bit(tmp_path_factory: pytest.TempPathFactory, arrays: dict) -> None:
    file = tmp_path_factory.getbasetemp() / "any.arrays"
    write_arrays(file, arrays, {})
    found, about = read_arrays(file)
    assert about == {}
    assert {name: (a.dtype, a.shape, a.tobytes()) for name, a in found.items()} == {
        name: (a.dtype, a.shape, a.tobytes()) for name, a in arrays.items()
    }


def test_every_cut_is_refused(path: Path) -> None:
    data = path.read_bytes()
    for length in range(len(data)):
        path.write_bytes(data[:length])
        refused(path)


def test_every_byte_that_is_changed_is_noticed(path: Path) -> None:
    data = path.read_bytes()
    for place in range(len(data)):
        for flip in (0x01, 0x20, 0xFF):
            path.write_bytes(data[:place] + bytes([data[place] ^ flip]) + data[place + 1 :])
            refused(path)


def test_bytes_behind_the_end_are_refused(path: Path) -> None:
    path.write_bytes(path.read_bytes() + b"\0")
    refused(path)


def test_one_byte_of_data_that_is_changed_is_called_so(path: Path) -> None:
    data = bytearray(path.read_bytes())
    data[-1] ^= 1
    path.write_bytes(data)
    assert "expected the checksum it was written with, got a file that was changed" in refused(path)


def test_a_foreign_file_of_the_same_format(tmp_path: Path) -> None:
    save_file(ARRAYS, tmp_path / "foreign.safetensors")
    message = refused(tmp_path / "foreign.safetensors")
    assert "expected a whole file of named arrays, got a damaged or foreign one" in message


class Trap:
    """Leaves a mark if anybody unpickles it."""

    mark = ""

    def __reduce__(self) -> tuple[Callable[..., object], tuple[object, ...]]:
        return Path(self.mark).touch, ()


def test_nothing_is_unpickled(tmp_path: Path) -> None:
    trap = Trap()
    trap.mark = str(tmp_path / "mark")
    file = tmp_path / "pickled.arrays"
    file.write_bytes(pickle.dumps(trap))
    refused(file)
    np.save(tmp_path / "pickled.npy", np.array([trap], dtype=object), allow_pickle=True)
    refused(tmp_path / "pickled.npy")
    assert not Path(trap.mark).exists()
    pickle.loads(file.read_bytes())  # the trap would have worked
    assert Path(trap.mark).exists()


def with_header(header: object, body: bytes = bytes(32)) -> bytes:
    text = header if isinstance(header, bytes) else json.dumps(header).encode()
    return len(text).to_bytes(8, "little") + text + body


def digest_at(begin: object, end: object) -> dict:
    return {DIGEST: {"dtype": "U8", "shape": [32], "data_offsets": [begin, end]}}


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"1234567",
        bytes(8),
        b"\xff" * 64,
        with_header(b"not json"),
        with_header(b"\xff\xfe"),
        with_header(b"[" * 100_000),
        with_header([]),
        with_header(3),
        with_header({}),
        with_header({DIGEST: 3}),
        with_header(digest_at(0, 31)),
        with_header(digest_at("0", "32")),
        with_header(digest_at(None, None)),
        with_header(digest_at(-40, -8)),
        with_header(digest_at(2**62, 2**62 + 32)),
        with_header(digest_at(10**400, 10**400 + 32)),
        with_header(digest_at(1, 33)),
        with_header(b'{"blake2b": {"data_offsets": [Infinity, Infinity]}}'),
        with_header(digest_at(0, 32)),
    ],
)
def test_headers_that_lie(tmp_path: Path, data: bytes) -> None:
    file = tmp_path / "lie.arrays"
    file.write_bytes(data)
    refused(file)


def test_a_right_checksum_does_not_make_a_wrong_header_right(tmp_path: Path) -> None:
    file = tmp_path / "lie.arrays"
    header = {**digest_at(0, 32), "rows": {"dtype": "F32", "shape": [1000], "data_offsets": [32, 36]}}
    file.write_bytes(with_header(header, bytes(36)))
    with file.open("r+b") as stream:
        start = archive._digest_start(stream)
        digest = archive._digest(stream, start)
        stream.seek(start)
        stream.write(digest)
    assert "damaged or foreign" in refused(file)


def test_no_words_about_the_arrays(tmp_path: Path) -> None:
    file = tmp_path / "silent.arrays"
    file.write_bytes(with_header({**digest_at(0, 32), "__metadata__": None}))
    with file.open("r+b") as stream:
        start = archive._digest_start(stream)
        digest = archive._digest(stream, start)
        stream.seek(start)
        stream.write(digest)
    assert read_arrays(file) == ({}, {})


def test_a_missing_file_and_a_folder(tmp_path: Path) -> None:
    assert refused(tmp_path / "none").endswith("got none")
    assert refused(tmp_path).endswith("got a folder")


def test_a_folder_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(HarmonicFaceError, match=r"cannot write .*some\.arrays: No such file or directory"):
        write_arrays(tmp_path / "none" / "some.arrays", ARRAYS, ABOUT)


def test_a_full_disk_leaves_the_old_file_and_no_other(path: Path) -> None:
    before = path.read_bytes()
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, hard))
    try:
        with pytest.raises(HarmonicFaceError, match=r"cannot write .*some\.arrays: ") as caught:
            write_arrays(path, {"large": np.zeros(10_000)}, ABOUT)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert "\n" not in str(caught.value)
    assert list(path.parent.iterdir()) == [path]
    assert path.read_bytes() == before


def test_an_interruption_leaves_the_old_file_and_no_other(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = path.read_bytes()

    def interrupted(file: Path, content: bytes) -> int:
        with file.open("wb") as stream:
            stream.write(content[:10])
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "write_bytes", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_arrays(path, ARRAYS, ABOUT)
    assert list(path.parent.iterdir()) == [path]
    assert path.read_bytes() == before
