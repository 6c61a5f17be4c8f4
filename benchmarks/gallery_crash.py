"""Does a gallery keep whom it has acknowledged? A process that enrols is killed again and again.

Run it as `python benchmarks/gallery_crash.py [--quick] [--json FILE]`; it writes where temporary files go (TMPDIR). It
ends with an error where somebody was lost, changed or left behind.
"""

from __future__ import annotations

import multiprocessing
import random
import tempfile
import time
from collections.abc import Iterator
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

import harmonicface as hf
from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.measure import Record
from harmonicface.gallery.disk.checkup import checkup
from harmonicface.store.folder import ArrayFolder
from harmonicface.store.manifest import NAME

SIZE, DIFFERENT = 24, 5
LONGEST_LIFE = 0.25  # seconds from the first enrolment's begin to the end: some ten enrolments
BEGUN_ANEW = 10  # kills, so that a gallery that is being made is struck too
SERVER = multiprocessing.get_context("forkserver")


def person(number: int) -> hf.Surface:
    """Return who has a number; there are five of them under as many names as are wanted."""
    return hf.synthetic_person(number % DIFFERENT, SIZE)


def enrol(path: Path, first: int, told: Connection) -> None:
    """Enrol people one by one, and tell of each when she is acknowledged."""
    everybody = [person(number) for number in range(DIFFERENT)]
    told.send(first - 1)
    gallery, number = hf.Gallery.open(path) if path.exists() else hf.Gallery.create(path), first
    while True:
        gallery.enroll(f"person {number}", everybody[number % DIFFERENT])
        told.send(number)
        number += 1


def acknowledged(path: Path, first: int, seconds: float) -> int:
    """Let a process enrol from a number on, kill it so long after it begins; return the number after its last."""
    receiver, sender = SERVER.Pipe(duplex=False)
    process = SERVER.Process(target=enrol, args=(path, first, sender))
    process.start()
    sender.close()
    done = int(receiver.recv()) + 1
    time.sleep(seconds)
    process.kill()
    with suppress(EOFError):
        while True:
            done = int(receiver.recv()) + 1
    process.join()
    return done


def strays(path: Path) -> int:
    """Return how many files are none of the gallery's, in its folder and beside it."""
    known = ArrayFolder(path).version().manifest.files | {NAME} if path.exists() else set()
    inside = {one.name for one in path.iterdir()} if path.exists() else set()
    return len(inside - known) + len(set(path.parent.iterdir()) - {path})


def killed(place: Path, kills: int) -> Record:
    """Kill a process that enrols at random moments; look each time who is there, and how."""
    start, rng = time.perf_counter(), random.Random(0)
    rows = [gallery_rows(number) for number in range(DIFFERENT)]
    done = people = wrong = stray = left = early = 0
    for kill in range(kills):
        path = place / str(kill // BEGUN_ANEW) / "people"
        if kill % BEGUN_ANEW == 0:
            path.parent.mkdir()
            done = 0
        acknowledged_now = acknowledged(path, done, rng.uniform(0, LONGEST_LIFE))
        found = list(ArrayFolder(path).version().entries()) if path.exists() else []
        there = [entry.key for entry in found]
        wrong += there[:acknowledged_now] != [f"person {number}" for number in range(acknowledged_now)]
        wrong += len(there) > acknowledged_now + 1
        wrong += sum(
            not np.array_equal(entry.arrays["rows"], rows[number % DIFFERENT]) for number, entry in enumerate(found)
        )
        wrong += len(checkup(path)) if path.exists() else 0
        early += len(there) > acknowledged_now
        left += strays(path)
        gallery = hf.Gallery.open(path) if path.exists() else hf.Gallery.create(path)
        gallery.enroll(f"person {len(there)}", person(len(there)))  # the next write
        stray += strays(path)
        people, done = people + len(there) + 1 - done, len(there) + 1
    return Record(
        "killed enrolments",
        f"{kills} kills, {people} people in {-(-kills // BEGUN_ANEW)} galleries",
        time.perf_counter() - start,
        error=wrong + stray,
        unit="people lost or changed, and stray files after the next enrolment",
        seed=0,
        note=f"{left} stray files before the next enrolment; {early} people were there before they were acknowledged",
    )


def gallery_rows(number: int) -> np.ndarray:
    """Return the rows of a person as a gallery keeps them."""
    with tempfile.TemporaryDirectory() as place:
        gallery = hf.Gallery.create(Path(place) / "one")
        gallery.enroll("one", person(number))
        return np.array(ArrayFolder(Path(place) / "one").version().entry("one").arrays["rows"])


def records(quick: bool) -> Iterator[Record]:
    """Try it in a place that is removed afterwards."""
    SERVER.set_forkserver_preload(["harmonicface.gallery.gallery"])
    with tempfile.TemporaryDirectory() as place:
        record = killed(Path(place), 20 if quick else 500)
        yield record
    if record.error:
        raise SystemExit("somebody was lost, changed or left behind")


if __name__ == "__main__":
    run_benchmark(__doc__, records, "20 kills instead of 500")
