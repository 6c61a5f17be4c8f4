"""A file is replaced whole or not at all."""

from __future__ import annotations

import errno
import os
import signal
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.files import alone_in, replacing


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


KILLED = """
import os, signal, sys
from harmonicface.io.files import alone_in, replacing
with replacing(sys.argv[1]) as temporary:
    temporary.write_text("half")
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_what_a_killed_writer_leaves_is_removed_by_the_next(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    assert subprocess.run([sys.executable, "-c", KILLED, str(path)], check=False).returncode == -signal.SIGKILL
    assert path.read_text() == "old"
    assert len(list(tmp_path.iterdir())) == 2
    with replacing(path) as temporary:
        temporary.write_text("new")
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_the_temporary_file_of_a_living_writer_is_left_alone(tmp_path):
    path = tmp_path / "a.txt"
    with replacing(path) as first:
        first.write_text("first")
        with replacing(path) as second:
            second.write_text("second")
        assert first.read_text() == "first"
    assert path.read_text() == "first"


def test_a_link_stays_a_link(tmp_path):
    target, link = tmp_path / "a.txt", tmp_path / "link.txt"
    target.write_text("old")
    link.symlink_to(target)
    with replacing(link) as temporary:
        temporary.write_text("new")
    assert (link.is_symlink(), target.read_text()) == (True, "new")


@pytest.mark.parametrize("name", ["a\0b", "x" * 5000])
def test_a_name_that_no_file_can_have(tmp_path, name):
    with pytest.raises(HarmonicFaceError, match="cannot write"), replacing(tmp_path / name):
        pass


COUNTING = """
import sys
from pathlib import Path
from harmonicface.io.files import alone_in
path = Path(sys.argv[1])
for _ in range(40):
    with alone_in(path.parent):
        path.write_text(str(int(path.read_text()) + 1))
"""


def test_two_writers_lose_nothing(tmp_path):
    path = tmp_path / "count"
    path.write_text("0")
    writers = [subprocess.Popen([sys.executable, "-c", COUNTING, str(path)]) for _ in range(2)]
    assert [writer.wait() for writer in writers] == [0, 0]
    assert path.read_text() == "80"
    assert list(tmp_path.iterdir()) == [path]


def test_only_a_folder_is_locked(tmp_path):
    with pytest.raises(HarmonicFaceError, match="expected a folder"), alone_in(tmp_path / "nowhere"):
        pass


def test_a_file_system_without_locks(tmp_path, monkeypatch):
    def refusing(*_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr("fcntl.flock", refusing)
    with pytest.raises(HarmonicFaceError, match=r"cannot lock the folder .*: No locks available"), alone_in(tmp_path):
        pass
