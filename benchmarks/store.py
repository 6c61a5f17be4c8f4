"""What does keeping people on disk cost? A folder of arrays beside one plain file of the same bytes.

Run it as `python benchmarks/store.py [--quick] [--json FILE]`; it needs 1.8 GB where temporary files go (TMPDIR), with
--quick a tenth. Nothing is enrolled: the entries are what nine modes of 64 x 64 pixels take.
"""

from __future__ import annotations

import os
import resource
import tempfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.measure import Record
from harmonicface.bench.timing import Call, Stopwatch, best, once, record
from harmonicface.store.entry import Entry, Kind
from harmonicface.store.folder import ArrayFolder
from harmonicface.store.version import Version

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
    plain, _ = once(Call(partial(one_plain_file, people, place / "plain"), about="of the same bytes"))
    before = resident()
    ours, _ = once(partial(folder.append, entries(0, people)))
    risen = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 - before
    yield record("append many", size, ours, plain, bytes=risen, note="memory: how far it rose")

    nbytes = folder.version().nbytes
    reading, _ = once(Call(partial(sums_of_rows, folder), about=f"{nbytes / 1e9:.2f} GB"))
    before = resident()
    ours, version = once(partial(newly_opened, folder.path))
    yield record("open", size, ours, reading, bytes=resident() - before, note="memory: how far it rose")
    ours, _ = once(partial(version.entry, f"person {people // 2}"))
    yield record("find one", size, ours, note="the first time: the directories are read")
    ours, damages = once(folder.verify)
    yield record("verify", size, ours, error=len(damages), unit="damaged shards")

    written, singles = _written(), Stopwatch(ArrayFolder.append)
    for number in range(people, people + SINGLE):
        singles.run(lambda number=number: folder.append(entries(number, number + 1)))
    times = (_written() - written) / (folder.version().nbytes - nbytes)
    alone = best(Call(partial(one_plain_file, 1, place / "plain"), about="of one entry"), repeats=20)
    note = f"mean of {SINGLE}; after them {len(folder.version().parts)} shards, each byte was written {times:.1f} times"
    yield record("append one", size, singles.timing(np.mean), alone, note=note)

    ours, _ = once(partial(folder.rename, "person 3", "somebody"))
    yield record("rename one", size, ours)
    ours, _ = once(partial(folder.remove, "person 4"))
    yield record("remove one", size, ours)
    ours, freed = once(folder.compact)
    yield record("compact", size, ours, note=f"after that; {freed} bytes freed")


def one_plain_file(people: int, path: Path) -> None:
    """Write entries behind each other into one file, and flush it to the disk."""
    with path.open("wb") as stream:
        for entry in entries(0, people):
            for array in entry.arrays.values():
                stream.write(array.data)
        stream.flush()
        os.fsync(stream.fileno())
    path.unlink()


def newly_opened(path: Path) -> Version:
    """Open a folder as a process does that has not seen it."""
    return ArrayFolder(path).version()


def sums_of_rows(folder: ArrayFolder) -> list[float]:
    """Read all rows once."""
    return [float(np.sum(part.shard.arrays["rows"])) for part in folder.version().parts]


def _written() -> int:
    """Return how many bytes this process has given to the system to write."""
    lines = Path("/proc/self/io").read_text(encoding="ascii").split("\n")
    return int(next(line for line in lines if line.startswith("wchar")).split()[1])


if __name__ == "__main__":
    run_benchmark(__doc__, records, "1,000 entries instead of 10,000", seed=0)
