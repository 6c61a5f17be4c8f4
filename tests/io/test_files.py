"""A file is replaced whole or not at all."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.files import replacing


def test_a_finished_file_takes_its_place(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    with replacing(path) as temporary:
        temporary.write_text("new")
        assert path.read_text() == "old"
        assert (temporary.suffix, temporary.parent) == (".txt", tmp_path)
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [tmp_path / "a.txt"]


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_an_exception_leaves_the_old_file_and_nothing_else(tmp_path, error):
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(error), replacing(path) as temporary:
        temporary.write_text("half")
        raise error
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [tmp_path / "a.txt"]


def test_an_exception_leaves_no_new_file(tmp_path):
    with pytest.raises(RuntimeError), replacing(tmp_path / "a.txt"):
        raise RuntimeError
    assert list(tmp_path.iterdir()) == []


def test_others_may_read_it_as_the_umask_says(tmp_path):
    old = os.umask(0o027)
    try:
        with replacing(tmp_path / "a.txt") as temporary:
            temporary.write_text("x")
    finally:
        os.umask(old)
    assert stat.S_IMODE((tmp_path / "a.txt").stat().st_mode) == 0o640


def test_a_missing_folder_is_refused(tmp_path):
    with pytest.raises(HarmonicFaceError, match=r"cannot write .*nowhere"), replacing(tmp_path / "nowhere" / "a.txt"):
        pass


def test_a_folder_of_that_name_is_refused(tmp_path):
    (tmp_path / "a.txt").mkdir()
    with pytest.raises(HarmonicFaceError, match="cannot write"), replacing(tmp_path / "a.txt") as temporary:
        Path(temporary).write_text("x")
    assert list(tmp_path.iterdir()) == [tmp_path / "a.txt"]
