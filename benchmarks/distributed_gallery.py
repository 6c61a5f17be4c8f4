"""What do more processes cost a gallery, and what if one dies? Two Dask workers beside one process, same answers.

python benchmarks/distributed_gallery.py [--quick] [--folder DIR] [--json FILE]

20,000 people are morphs of 400 of the generator's (`bench.morphs`); the folder takes 3.4 GB of temporary space. Half of
the 200 photographs show somebody who is enrolled, the others one of the 400, who are not; all have 5 % noise. Every
answer is compared with that of one process. The workers share this machine: what is measured is what Dask costs, not
what more machines give. The gallery is kept in DIR, if one is named, for the next time.
"""

from __future__ import annotations

import logging
import os
import signal
import tempfile
import threading
import time
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np
from distributed import Client, LocalCluster
from numpy.typing import NDArray

import harmonicface as hf
from harmonicface.bench.command_line import benchmark_parser, finish
from harmonicface.bench.measure import Record
from harmonicface.bench.morphs import morphs
from harmonicface.bench.timing import Call, Stopwatch, best, once, record
from harmonicface.gallery.distributed.share import shares_of
from harmonicface.gallery.distributed.shared_shelf import SharedShelf
from harmonicface.gallery.search.cascade import Found
from harmonicface.gallery.search.shelf import Shelf
from harmonicface.gallery.search.sketch import COLUMNS, form_columns
from harmonicface.recognition.subspace import unit_photo

SIZE = 64
BATCH = 64
WORKERS = 2
NOISE = 0.05
DIFFER = "answers that differ from one process"
Units = NDArray[np.float64]


def records(quick: bool, folder: Path | None = None) -> Iterator[Record]:
    """Ask one process, then the workers, then the workers while one of them dies."""
    people, pool, queries = (1_200, 60, 40) if quick else (20_000, 400, 200)
    size = f"{people} people {SIZE}x{SIZE}"
    with tempfile.TemporaryDirectory() as place:
        path = str((folder or Path(place)) / f"{people} people.gallery")
        units = _made(path, people, list(hf.synthetic_people(pool, SIZE, seed=0)), queries)
        (share,) = shares_of(path, 1)
        alone = share.shelf()
        expected = _asked(alone, units)
        quiet = {"silence_logs": logging.CRITICAL, "dashboard_address": ":0"}
        with LocalCluster(n_workers=WORKERS, threads_per_worker=1, **quiet) as cluster, Client(cluster) as client:
            client.wait_for_workers(WORKERS, timeout=60)
            opening, shelf = once(Call(lambda: SharedShelf(path, client), SharedShelf.__init__))
            note = f"bytes: copied into the memory of the {WORKERS} workers together; the rest stays in the files"
            yield record("give the workers their shares", size, opening, bytes=alone.nbytes, note=note)
            yield from _questions(alone, shelf, units, expected, size)
            yield _killed(client, shelf, units, expected, size)
    yield from _first_bound(100_000 if quick else 1_000_000)


def _made(path: str, people: int, pool: list[hf.Surface], queries: int) -> Units:
    """Make the gallery, and unit photographs of those who are in it and of those who are not."""
    rng, every = np.random.default_rng(0), 2 * people // queries
    if not Path(path).exists():
        named = ((f"person {number}", person) for number, person in enumerate(morphs(pool, people)))
        hf.Gallery.create(path, "harmonic9").enroll_many(named)
    gallery = hf.Gallery.open(path)
    photographs = [_photograph(person, rng) for person in islice(morphs(pool, people), 0, None, every)]
    photographs += [_photograph(pool[number % len(pool)], rng) for number in range(queries - len(photographs))]
    mask = gallery.mask
    assert mask is not None
    return np.stack([unit_photo(photo[mask], int(mask.sum())) for photo in photographs])[rng.permutation(queries)]


def _photograph(person: hf.Surface, rng: np.random.Generator) -> NDArray[np.floating]:
    """Return a picture under one lamp, as a camera takes it."""
    towards = rng.normal(size=3) * [1.0, 1.0, 0.0] + [0.0, 0.0, 1.0]
    return hf.photograph(hf.render(person, hf.lights.directional(towards)), rng, noise=NOISE)


def _questions(alone: Shelf, shelf: SharedShelf, units: Units, expected: list[Found], size: str) -> Iterator[Record]:
    """Time questions one by one and together, each process in turn."""
    for top, distance, question in ((1, 1.0, "exact top-1"), (5, 1.0, "exact top-5"), (None, 0.1, "all within 0.1")):
        ours, peer = Stopwatch(SharedShelf.search), Stopwatch(Shelf.search)
        pairs = [
            (ours.run(lambda: shelf.search(unit, top, distance)), peer.run(lambda: alone.search(unit, top, distance)))  # noqa: B023
            for unit in units
        ]
        start = time.process_time()
        for unit in units:
            alone.search(unit, top, distance)
        each = 1e3 * (time.process_time() - start) / len(units)
        left = _left([one for _, one in pairs], len(alone))
        note = f"median of {len(units)} photographs; alone, {each:.1f} ms of processor in the mean; {left}"
        yield record(
            f"single query, {question}, on workers",
            size,
            ours.timing(),
            peer.timing(),
            error=_differ(*zip(*pairs, strict=True)),
            unit=DIFFER,
            note=note,
        )
    batch = units[:BATCH]
    ours, found = once(Call(lambda: shelf.search_many(batch), SharedShelf.search_many))
    peer, _ = once(Call(lambda: alone.search_many(batch), Shelf.search_many))
    wrong = _differ(found, expected[:BATCH])
    yield record(f"{len(batch)} queries, exact top-1, on workers", size, ours, peer, error=wrong, unit=DIFFER)


def _killed(client: Client, shelf: SharedShelf, units: Units, expected: list[Found], size: str) -> Record:
    """Ask every photograph while one worker is killed in the middle of one of them."""
    process = next(iter(client.run(os.getpid).values()))
    found, seconds = [], []
    for number, unit in enumerate(units):
        start = time.perf_counter()
        if number == len(units) // 3:
            threading.Timer(float(np.median(seconds)) / 2, os.kill, (process, signal.SIGKILL)).start()
        found.append(shelf.search(unit))
        seconds.append(time.perf_counter() - start)
    timing, _ = once(Call(lambda: shelf.search(units[0]), SharedShelf.search))
    assert process not in client.run(os.getpid).values()
    return record(
        "single query while a worker is killed",
        size,
        Call(lambda: None, SharedShelf.search).timing(float(np.median(seconds))),
        timing,
        error=_differ(found, expected),
        unit=DIFFER,
        note=f"median of {len(units)} photographs, the longest {max(seconds):.2f} s; beside one afterwards",
    )


def _first_bound(people: int) -> Iterator[Record]:
    """Time what a search does with everybody: one product of the quadratic forms, here of random numbers."""
    columns = form_columns(COLUMNS)
    rng, rows = np.random.default_rng(0), columns * (columns + 1) // 2 + 2
    forms = rng.random((rows, people), np.float32)
    for queries in (1, BATCH):
        asked, seconds = rng.random((rows, queries), np.float32), []
        for _ in range(5):
            start = time.process_time()
            forms.T @ asked  # as in `cascade.search_many`
            seconds.append(time.process_time() - start)
        timing = best(lambda: forms.T @ asked, 3)  # noqa: B023
        each = 1e9 * min(seconds) / (people * queries)
        note = f"{rows} numbers a person; {each:.1f} ns of processor for each person and photograph"
        yield record(f"first bound, {queries} photographs", f"{people} people", timing, bytes=forms.nbytes, note=note)


def _asked(shelf: Shelf, units: Units) -> list[Found]:
    """Return the answers of one process."""
    return [shelf.search(unit) for unit in units]


def _left(found: list[Found], people: int) -> str:
    """Say how many people the bounds leave, in the mean."""
    stages = max(len(one.survivors) for one in found)
    counts = [one.survivors + one.survivors[-1:] * (stages - len(one.survivors)) for one in found]
    shares = ", ".join(f"{100 * share / people:.2f}" for share in np.mean(counts, axis=0))
    return f"{shares} % survive {stages} bounds, {np.mean([one.measured for one in found]):.1f} people are measured"


def _differ(found: list[Found], expected: list[Found]) -> int:
    """Return how many answers name others or say other distances."""
    return sum(
        (one.people, one.distances) != (other.people, other.distances)
        for one, other in zip(found, expected, strict=True)
    )


if __name__ == "__main__":
    parser = benchmark_parser(__doc__, "1,200 people and 40 photographs")
    parser.add_argument("--folder", type=Path, help="keep the gallery here, and use the one that is there")
    options = parser.parse_args()
    finish(records(options.quick, options.folder), options.json, seed=0)
