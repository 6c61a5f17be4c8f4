"""Does a folder keep what it has acknowledged? Killed writers, flipped bytes, two writers at once, a reader beside one.

Run it as `python benchmarks/store_crash.py [--quick] [--json FILE]`; it writes where temporary files go (TMPDIR). It
ends with an error where something was lost, mixed, left behind or not found.
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

from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.measure import Record
from harmonicface.store.entry import Entry, Kind
from harmonicface.store.folder import ArrayFolder
from harmonicface.store.manifest import NAME

ROWS = Kind(np.dtype("f4"), (400,))
REMOVED_AFTER = 4  # every fifth entry is removed by the fourth after it
COMPACTED_EVERY = 100
LONGEST_LIFE = 0.15  # seconds from a writer's first acknowledgement to its end: some ten writes
FLIPS = 200
SERVER = multiprocessing.get_context("forkserver")


def entry(who: str, number: int) -> Entry:
    """Return an entry whose arrays and words tell its number."""
    return Entry(f"{who} {number}", {"rows": np.full((1 + number % 9, 400), number, np.float32)}, {"number": number})


def tells_its_number(found: Entry) -> bool:
    """Tell whether an entry is as it was written."""
    return bool((found.arrays["rows"] == found.about["number"]).all())


def write(path: Path, who: str, first: int, until: float, told: Connection) -> None:
    """Append numbers until a time, tell each when it is acknowledged; remove every fifth, compact now and then."""
    folder, number = ArrayFolder(path), first
    while time.monotonic() < until:
        folder.append([entry(who, number)])
        if number % 5 == REMOVED_AFTER:
            folder.remove(f"{who} {number - REMOVED_AFTER}")
        if number % COMPACTED_EVERY == COMPACTED_EVERY - 1:
            folder.compact()
        told.send(number)
        number += 1


class Writer:
    """A process that writes numbers and acknowledges them."""

    def __init__(self, folder: ArrayFolder, who: str, first: int = 0, seconds: float = 1e6) -> None:
        self._told, told = SERVER.Pipe(duplex=False)
        self._process = SERVER.Process(target=write, args=(folder.path, who, first, time.monotonic() + seconds, told))
        self._process.start()
        told.close()

    def wait(self) -> int:
        """Wait for the next number."""
        return int(self._told.recv())

    def rest(self) -> list[int]:
        """Return all numbers until its end."""
        found = []
        with suppress(EOFError):
            while True:
                found.append(self.wait())
        self._process.join()
        return found

    def kill(self) -> list[int]:
        """Kill it, and return the numbers that it acknowledged before."""
        self._process.kill()
        return self.rest()


def kept(who: str, done: int) -> set[str]:
    """Return whom a writer keeps that has acknowledged all numbers below `done`."""
    return {f"{who} {n}" for n in range(done) if n % 5 or n + REMOVED_AFTER >= done}


def strays(folder: ArrayFolder) -> set[str]:
    """Return the files that are none of the folder's."""
    return {one.name for one in folder.path.iterdir()} - folder.version().manifest.files - {NAME}


def killed(path: Path, kills: int) -> Record:
    """Kill a writer again and again at random moments, and look each time."""
    folder, start = ArrayFolder.create(path, {"rows": ROWS}), time.perf_counter()
    done = left = early = lost = damaged = stray = 0
    rng = random.Random(0)
    for _ in range(kills):
        writer = Writer(folder, "a", done)
        first = writer.wait()
        time.sleep(rng.uniform(0, LONGEST_LIFE))
        done = [first, *writer.kill()][-1] + 1
        version = ArrayFolder(path).version()
        found, expected = set(version.keys), kept("a", done)
        going = f"a {done - REMOVED_AFTER}" if done % 5 == REMOVED_AFTER else ""  # removed, but not acknowledged
        coming = f"a {done}"  # there, but not acknowledged
        lost += len(expected - {going} - found) + len(found - expected - {coming})
        damaged += len(folder.verify()) + sum(not tells_its_number(one) for one in version.entries())
        left += len(strays(folder))
        folder.describe({"done": done})  # the next write
        stray += len(strays(folder))
        if coming in found:
            early += 1
            folder.remove(coming)
        if going in expected - found:
            folder.append([entry("a", done - REMOVED_AFTER)])
    return Record(
        "killed writers",
        f"{kills} kills, {done} acknowledged entries",
        time.perf_counter() - start,
        error=lost + damaged + stray,
        unit="entries lost, back again or damaged, and stray files after the next write",
        seed=0,
        note=f"{left} stray files before the next write; {early} entries were there before they were acknowledged",
    )


def flipped(path: Path) -> Record:
    """Flip one bit of a shard, again and again; each time somebody has to notice, and nobody else to be accused."""
    folder, start = ArrayFolder.create(path, {"rows": ROWS}), time.perf_counter()
    folder.append(entry("a", number) for number in range(100))
    (file,) = folder.version().manifest.files
    content, rng = (path / file).read_bytes(), random.Random(0)
    missed, named = 0, []
    for _ in range(FLIPS):
        place = rng.randrange(len(content))
        (path / file).write_bytes(
            content[:place] + bytes([content[place] ^ 1 << rng.randrange(8)]) + content[place + 1 :]
        )
        damages = folder.verify()
        missed += [damage.file for damage in damages] != [file]
        named += [len(damage.keys) for damage in damages]
    (path / file).write_bytes(content)
    missed += len(folder.verify())
    alone, nobody = named.count(1), named.count(0)
    return Record(
        "flipped bytes",
        f"{FLIPS} bytes of a shard of {len(content)}",
        time.perf_counter() - start,
        error=missed,
        unit="flips that were not found",
        seed=0,
        note=f"{alone} of them named the one person whose bytes they were, {nobody} struck one of the two directories, "
        f"{FLIPS - alone - nobody} the header",
    )


def two_writers(path: Path, seconds: float) -> Record:
    """Let two writers write at once."""
    folder, start = ArrayFolder.create(path, {"rows": ROWS}), time.perf_counter()
    writers = {who: Writer(folder, who, 0, seconds) for who in "ab"}
    done = {who: len(writer.rest()) for who, writer in writers.items()}
    expected = kept("a", done["a"]) | kept("b", done["b"])
    lost = len(expected ^ set(folder.version().keys))
    return Record(
        "two writers at once",
        f"{done['a']} and {done['b']} entries",
        time.perf_counter() - start,
        error=lost + len(folder.verify()) + len(strays(folder)),
        unit="entries lost or damaged, and stray files",
    )


def reader(path: Path, writes: int) -> Record:
    """Open a folder again and again beside a writer; no version may be a mix, and old ones stay what they were."""
    folder, start = ArrayFolder.create(path, {"rows": ROWS}), time.perf_counter()
    writer = Writer(folder, "a")
    looks, mixed, generations, newest = 0, 0, set(), -1
    old: list[tuple[object, list[int]]] = []
    while newest + 1 < writes:
        version = ArrayFolder(path).version()
        found = [int(key[2:]) for key in version.keys]
        newest = max(found, default=-1)
        gone = set(range(newest + 1)) - set(found)
        mixed += found != sorted(found)
        mixed += not set(range(0, newest - REMOVED_AFTER, 5)) <= gone <= set(range(0, newest, 5))
        old = [*old[-20:], (version, found)]
        for one, numbers in old[:: max(1, len(old) - 1)]:  # the oldest that is held, and the newest
            entries = list(one.entries())
            mixed += [entry.about["number"] for entry in entries] != numbers or not all(map(tells_its_number, entries))
        looks += 1
        generations.add(version.generation)
    writer.kill()
    return Record(
        "a reader beside a writer",
        f"{writes} writes",
        time.perf_counter() - start,
        error=mixed,
        unit="versions that were mixed or changed",
        note=f"{looks} versions opened, {len(generations)} of them different",
    )


def records(quick: bool) -> Iterator[Record]:
    """Try all four."""
    kills, seconds, writes = (40, 5.0, 200) if quick else (500, 30.0, 1000)
    SERVER.set_forkserver_preload(["harmonicface.store.folder"])
    with tempfile.TemporaryDirectory() as name:
        place, wrong = Path(name), 0.0
        for trial in (
            lambda: killed(place / "killed", kills),
            lambda: flipped(place / "flipped"),
            lambda: two_writers(place / "two", seconds),
            lambda: reader(place / "reader", writes),
        ):
            record = trial()
            wrong += record.error or 0
            yield record
    if wrong:
        raise SystemExit("something was lost, mixed, left behind or not found")


if __name__ == "__main__":
    run_benchmark(__doc__, records, "40 kills, 5 seconds and 200 writes instead of 500, 30 and 1,000")
