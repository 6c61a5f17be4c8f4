"""What does keeping people on disk cost? A folder of arrays beside one plain file of the same bytes.

Run it as `python benchmarks/store.py [--quick] [--json FILE]`; it needs 1.8 GB where temporary files go (TMPDIR), with
--quick a tenth. Nothing is enrolled: the entries are what nine modes of 64 x 64 pixels take.
"""

from __future__ import annotations

import os
import resource
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.measure import Record
from harmonicface.store.entry import Entry, Kind
from harmonicface.store.folder import ArrayFolder

KINDS = {"rows": Kind(np.dtype("f4"), (4096,)), "sketch": Kind(np.dtype("f2"), (128,))}
BASE = {
    "rows": np.random.default_rng(0).normal(size=(9, 4096)).astype(np.float32),
    "sketch": np.ones((9, 128), np.float16),
}
SINGLE = 300


def entries(first: int, behind: int) -> Iterator[Entry]:
    """Yield entries of nine rows that differ in one number."""
    for number in range(first, behind):
        rows = BASE["rows"].copy()
        rows[0, 0] = number
        yield Entry(f"person {number}", {"rows": rows, "sketch": BASE["sketch"]}, {"source": "surface"})


def resident() -> int:
    """Return the bytes of this process that are in memory."""
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * os.sysconf("SC_PAGE_SIZE")


def records(quick: bool) -> Iterator[Record]:
    """Time what a folder does in a place that is removed afterwards."""
    with tempfile.TemporaryDirectory() as place:
        yield from of_folder(1_000 if quick else 10_000, Path(place))


def of_folder(people: int, place: Path) -> Iterator[Record]:
    """Time what a folder does, one after the other."""
    size = f"{people} people of {sum(a.nbytes for a in BASE.values())} bytes"
    folder = ArrayFolder.create(place / "folder", KINDS)
    plain = _plain(people, place / "plain")
    before = resident()
    seconds = _seconds(lambda: folder.append(entries(0, people)))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 - before
    peer = "one file of the same bytes, fsync at the end"
    note = "bytes: how far memory rose"
    yield Record("append many", size, seconds, bytes=peak, peer=peer, peer_seconds=plain, note=note)
    nbytes = folder.version().nbytes
    reading = _seconds(lambda: [np.sum(part.shard.arrays["rows"]) for part in folder.version().parts])
    folder = ArrayFolder(folder.path)  # forgets what it has mapped
    before = resident()
    start = time.perf_counter()
    version = ArrayFolder(folder.path).version()
    seconds, grown = time.perf_counter() - start, resident() - before
    peer = f"summing the rows of {nbytes / 1e9:.2f} GB once"
    yield Record("open", size, seconds, bytes=grown, peer=peer, peer_seconds=reading, note=note)
    seconds = _seconds(lambda: version.entry(f"person {people // 2}"))
    yield Record("find one", size, seconds, note="the first time: the directories are read")
    seconds = _seconds(folder.verify)
    yield Record("verify", size, seconds, error=len(folder.verify()), note="error: damaged shards")
    written = _written()
    seconds = _seconds(lambda: [folder.append(one) for one in _ones(people)]) / SINGLE
    times = (_written() - written) / (folder.version().nbytes - nbytes)
    note = f"{len(folder.version().parts)} shards after {SINGLE}; each byte was written {times:.1f} times"
    peer = "one plain file of one entry, fsync"
    alone = _seconds(lambda: [_plain(1, place / "plain") for _ in range(20)]) / 20
    yield Record("append one", size, seconds, peer=peer, peer_seconds=alone, note=note)
    yield Record("rename one", size, _seconds(lambda: folder.rename("person 3", "somebody")))
    yield Record("remove one", size, _seconds(lambda: folder.remove("person 4")))
    before = resident()
    seconds = _seconds(folder.compact)
    note = "after that; bytes: how far memory rose"
    yield Record("compact", size, seconds, bytes=resident() - before, note=note)


def _plain(people: int, path: Path) -> float:
    """Return the time of writing entries behind each other into one file."""
    start = time.perf_counter()
    with path.open("wb") as stream:
        for entry in entries(0, people):
            for array in entry.arrays.values():
                stream.write(array.data)
        stream.flush()
        os.fsync(stream.fileno())
    seconds = time.perf_counter() - start
    path.unlink()
    return seconds


def _ones(people: int) -> list[list[Entry]]:
    """Return further entries one by one."""
    return [[entry] for entry in entries(people, people + SINGLE)]


def _written() -> int:
    """Return how many bytes this process has given to the system to write."""
    lines = Path("/proc/self/io").read_text(encoding="ascii").split("\n")
    return int(next(line for line in lines if line.startswith("wchar")).split()[1])


def _seconds(call: object) -> float:
    """Return the time of a call."""
    start = time.perf_counter()
    call()  # type: ignore[operator]
    return time.perf_counter() - start


if __name__ == "__main__":
    run_benchmark(__doc__, records, "1,000 entries instead of 10,000")
