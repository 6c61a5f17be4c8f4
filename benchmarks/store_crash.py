"""Does a folder keep what it has acknowledged? Killed writers, two writers at once, a reader beside a writer.

Run it as `python benchmarks/store_crash.py [--kills 500] [--seconds 30] [--writes 1000] [--folder DIR]`; it says what
happened, and ends with an error where something was lost, mixed or left behind.
"""

from __future__ import annotations

import argparse
import multiprocessing
import random
import tempfile
import time
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from harmonicface.store.entry import Entry, Kind
from harmonicface.store.folder import ArrayFolder
from harmonicface.store.manifest import NAME

ROWS = Kind(np.dtype("f4"), (400,))
REMOVED_AFTER = 4  # every fifth entry is removed by the fourth after it
COMPACTED_EVERY = 100
SERVER = multiprocessing.get_context("forkserver")


def write(path: Path, who: str, first: int, until: float, told: Connection) -> None:
    """Append numbers until a time, tell each when it is acknowledged; remove every fifth, compact now and then."""
    folder, number = ArrayFolder(path), first
    while time.monotonic() < until:
        rows = np.full((1 + number % 9, 400), number, np.float32)
        folder.append([Entry(f"{who} {number}", {"rows": rows}, {"number": number})])
        if number % 5 == REMOVED_AFTER:
            folder.remove(f"{who} {number - REMOVED_AFTER}")
        if number % COMPACTED_EVERY == COMPACTED_EVERY - 1:
            folder.compact()
        told.send(number)
        number += 1


def kept(who: str, done: int) -> set[str]:
    """Return whom a writer keeps that has acknowledged all numbers below `done`."""
    return {f"{who} {n}" for n in range(done) if n % 5 or n + REMOVED_AFTER >= done}


def started(folder: ArrayFolder, who: str, first: int, seconds: float) -> tuple[object, Connection]:
    """Start a writer."""
    receiver, sender = SERVER.Pipe(duplex=False)
    process = SERVER.Process(target=write, args=(folder.path, who, first, time.monotonic() + seconds, sender))
    process.start()
    sender.close()
    return process, receiver


def numbers(receiver: Connection) -> list[int]:
    """Return everything that a writer acknowledges until its end."""
    found = []
    with suppress(EOFError):
        while True:
            found.append(receiver.recv())
    return found


def killed(path: Path, kills: int) -> str:
    """Kill a writer again and again at random moments, and look each time."""
    folder, done, strays, unacknowledged = ArrayFolder.create(path, {"rows": ROWS}), 0, 0, 0
    rng = random.Random(0)
    for _ in range(kills):
        process, receiver = started(folder, "a", done, 1e6)
        first = receiver.recv()
        time.sleep(rng.uniform(0, 0.15))
        process.kill()  # type: ignore[attr-defined]
        done = [first, *numbers(receiver)][-1] + 1
        process.join()  # type: ignore[attr-defined]
        version = ArrayFolder(path).version()
        found, expected = set(version.keys), kept("a", done)
        under_way = f"a {done - REMOVED_AFTER}" if (done % 5) == REMOVED_AFTER else ""
        assert expected - {under_way} <= found <= expected | {f"a {done}"}, (expected - found, found - expected)
        for entry in version.entries():
            assert (entry.arrays["rows"] == entry.about["number"]).all()
        assert folder.verify() == ()
        strays += len({one.name for one in path.iterdir()} - version.manifest.files - {NAME})
        if f"a {done}" in found:
            unacknowledged += 1
            folder.remove(f"a {done}")
        if under_way in expected - found:
            rows = np.full((1, 400), done - REMOVED_AFTER, np.float32)
            folder.append([Entry(under_way, {"rows": rows}, {"number": done - REMOVED_AFTER})])
        folder.describe({"done": done})
        assert {one.name for one in path.iterdir()} == folder.version().manifest.files | {NAME}
    return (
        f"{kills} kills, {done} acknowledged entries: none lost, {unacknowledged} there before they were acknowledged, "
        f"verify always clean; {strays} files left by the dead, none after the next write"
    )


def two_writers(path: Path, seconds: float) -> str:
    """Let two writers write at once."""
    folder = ArrayFolder.create(path, {"rows": ROWS})
    writers = [started(folder, who, 0, seconds) for who in "ab"]
    done = [len(numbers(receiver)) for _, receiver in writers]
    assert set(folder.version().keys) == kept("a", done[0]) | kept("b", done[1])
    assert folder.verify() == ()
    return f"two writers for {seconds:.0f} s: {done[0]} and {done[1]} entries, none lost, verify clean"


def reader(path: Path, writes: int) -> str:
    """Open a folder again and again beside a writer; no version may be a mix."""
    folder = ArrayFolder.create(path, {"rows": ROWS})
    process, receiver = started(folder, "a", 0, 1e6)
    looks, generations, newest, old = 0, set(), -1, []
    while newest + 1 < writes:
        version = ArrayFolder(path).version()
        found = [int(key[2:]) for key in version.keys]
        newest = max(found, default=-1)
        gone = set(range(newest + 1)) - set(found)
        assert found == sorted(found)
        assert set(range(0, newest - REMOVED_AFTER, 5)) <= gone <= set(range(0, newest, 5)), (newest, gone)
        old = [*old[-20:], (version, found)]
        for one, numbers_of in old[:: max(1, len(old) - 1)]:  # the oldest that is held, and the newest
            assert [entry.about["number"] for entry in one.entries()] == numbers_of
            assert all((entry.arrays["rows"] == entry.about["number"]).all() for entry in one.entries())
        looks += 1
        generations.add(version.generation)
    process.kill()  # type: ignore[attr-defined]
    process.join()  # type: ignore[attr-defined]
    receiver.close()
    return f"a reader beside {writes} writes: {looks} versions opened, {len(generations)} different, no error, no mix"


def main() -> None:
    """Run all three."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=500)
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--writes", type=int, default=1000)
    parser.add_argument("--folder", help="where to write, on the disk that is to be tried")
    options = parser.parse_args()
    SERVER.set_forkserver_preload(["harmonicface.store.folder"])
    with tempfile.TemporaryDirectory(dir=options.folder) as place:
        print(killed(Path(place) / "killed", options.kills), flush=True)
        print(two_writers(Path(place) / "two", options.seconds), flush=True)
        print(reader(Path(place) / "reader", options.writes), flush=True)


if __name__ == "__main__":
    main()
