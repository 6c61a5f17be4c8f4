"""Whoever is acknowledged stays: a process that enrols is killed again and again, when it begins a gallery too."""

from __future__ import annotations

import multiprocessing
import random
import signal
import time
from contextlib import suppress
from pathlib import Path

import harmonicface as hf
from harmonicface.gallery.disk.checkup import checkup
from harmonicface.store.folder import ArrayFolder
from harmonicface.store.manifest import NAME

SERVER = multiprocessing.get_context("forkserver")  # processes that have the package loaded
SERVER.set_forkserver_preload(["harmonicface"])
KILLS, BEGUN_ANEW = 12, 4
ENROLLING = """
import harmonicface as hf
person = hf.Surface.load(surface)
gallery = hf.Gallery.open(path) if path.exists() else hf.Gallery.create(path)
told.send(first - 1)
for number in range(first, 1000):
    gallery.enroll(f"person {number}", person)
    told.send(number)
    if number % 5 == 4:
        gallery.rename(f"person {number}", f"{number}")
        gallery.compact()
"""


def acknowledged(path: Path, surface: Path, first: int, seconds: float) -> int:
    """Kill a process that enrols from a number on; return the number after the last that it acknowledged."""
    receiver, sender = SERVER.Pipe(duplex=False)
    known = {"path": path, "surface": surface, "first": first, "told": sender}
    process = SERVER.Process(target=exec, args=(ENROLLING, known), daemon=True)
    process.start()
    sender.close()
    done = int(receiver.recv()) + 1
    time.sleep(seconds)
    process.kill()
    with suppress(EOFError):
        while True:
            done = int(receiver.recv()) + 1
    process.join()
    receiver.close()
    assert process.exitcode == -signal.SIGKILL
    return done


def test_a_process_that_enrols_is_killed(tmp_path) -> None:
    hf.synthetic_person(1, 24).save(tmp_path / "person.npz")
    person, rng, there = hf.Surface.load(tmp_path / "person.npz"), random.Random(0), 0
    for kill in range(KILLS):
        path = tmp_path / f"{kill // BEGUN_ANEW}" / "people"
        if kill % BEGUN_ANEW == 0:
            path.parent.mkdir()
            there = 0
        done = acknowledged(path, tmp_path / "person.npz", there, rng.uniform(0, 0.1))
        names = ArrayFolder(path).version().keys if path.exists() else ()
        assert [int(name.rpartition(" ")[2]) for name in names] == list(range(len(names)))
        assert done <= len(names) <= done + 1
        assert not path.exists() or checkup(path) == ()
        gallery = hf.Gallery.open(path) if path.exists() else hf.Gallery.create(path)
        gallery.enroll(f"person {len(names)}", person)
        there = len(gallery)
        assert {one.name for one in path.iterdir()} == ArrayFolder(path).version().manifest.files | {NAME}
        assert list(path.parent.iterdir()) == [path]
