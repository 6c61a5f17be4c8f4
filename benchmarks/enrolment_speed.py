"""How fast are people enrolled, in how much memory? And what if a gallery outgrows what its index was learned from.

python benchmarks/enrolment_speed.py [--quick] [--json FILE]

20,000 people are morphs of 400 of the generator's (`bench.morphs`), made while they are enrolled; the time of making
them is taken off. The first 1,000, from whom the shared basis is learned, are morphs of 46 of the 400, all others of
the other 354, so that the gallery outgrows its sample as far as can be. It takes 3.4 GB of temporary space, twice that
while the basis is learned anew.
"""

from __future__ import annotations

import logging
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from distributed import Client, LocalCluster
from numpy.typing import NDArray

import harmonicface as hf
from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.measure import Record
from harmonicface.bench.morphs import morphs
from harmonicface.bench.timing import Call, Stopwatch, Timing, best, once, record
from harmonicface.gallery.distributed.share import shares_of
from harmonicface.gallery.distributed.workers import in_order
from harmonicface.gallery.search.cascade import Found
from harmonicface.gallery.search.index import LEARNED_AT, Index
from harmonicface.gallery.search.shelf import Shelf
from harmonicface.recognition.subspace import unit_photo

SIZE = 64
RELATED = 46  # of the people of whom the first are morphs: they have 1,035 pairs
QUERIES = 40
NOISE = 0.05
DIFFER = "answers that differ from those of the other basis"
Units = NDArray[np.float64]


class Crowd:
    """Named morphs, and the time that making them takes.

    Parameters
    ----------
    pool
        Of whom they are morphs.
    count
        How many.
    """

    def __init__(self, pool: list[hf.Surface], count: int) -> None:
        self._pool, self._count = pool, count
        self.seconds = 0.0
        self.cpu = 0.0

    def people(self) -> Iterator[tuple[str, hf.Surface]]:
        """Yield names and Surfaces."""
        first = min(LEARNED_AT[0], self._count)
        kinds = (morphs(self._pool[:RELATED], first), morphs(self._pool[RELATED:], max(1, self._count - first)))
        number = 0
        for some, behind in zip(kinds, (first, self._count), strict=True):
            while number < behind:
                start, cpu = time.perf_counter(), time.process_time()
                person = next(some)
                self.seconds += time.perf_counter() - start
                self.cpu += time.process_time() - cpu
                yield f"person {number}", person
                number += 1


def records(quick: bool) -> Iterator[Record]:
    """Enrol, learn, and ask."""
    count, drawn = (1_600, 90) if quick else (20_000, 400)
    pool = list(hf.synthetic_people(drawn, SIZE, seed=0))
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "people.gallery"
        yield from _enrolled(path, pool, count)
        yield from _outgrown(path, pool, count)
    yield from _default(pool, 40 if quick else 400)


def _enrolled(path: Path, pool: list[hf.Surface], count: int) -> Iterator[Record]:
    """Enrol everybody into a folder."""
    crowd, gallery = Crowd(pool, count), hf.Gallery.create(path, "harmonic9")
    steps = sorted({count // 10, count // 2, count})
    before, highest = _memory(), [0]
    peaks = {}

    def progress(done: int) -> None:
        if done % 20 == 0 or done == count:
            highest[0] = max(highest[0], _memory() - before)
        if done in steps:
            peaks[done] = highest[0]

    cpu = time.process_time()
    timing, _ = once(Call(lambda: gallery.enroll_many(crowd.people(), progress), hf.Gallery.enroll_many))
    cpu = time.process_time() - cpu - crowd.cpu
    each = replace(timing, seconds=(timing.seconds - crowd.seconds) / count)
    images = np.zeros((9, pool[0].mask.size), np.float32)
    images[:, pool[0].mask.ravel()] = hf.harmonic_images(pool[0])
    qr = best(Call(partial(np.linalg.qr, images.T), about="of her nine images"))
    memory = ", ".join(f"{peak / 2**20:.0f} MiB at {done}" for done, peak in peaks.items())
    yield record(
        "enrol one person into a folder",
        f"{count} people {SIZE}x{SIZE}",
        each,
        qr,
        bytes=peaks[count],
        note=(
            f"{1 / each.seconds:.0f} people a second, index and fsync with it, {1e3 * cpu / count:.2f} ms of processor "
            f"each; memory rose by {memory} people"
        ),
    )


def _outgrown(path: Path, pool: list[hf.Surface], count: int) -> Iterator[Record]:
    """Ask with a basis of the first people's relatives, learn another one of everybody, ask again."""
    size = f"{count} people {SIZE}x{SIZE}"
    gallery = hf.Gallery.open(path)
    sample = [gallery._people.subspace(place) for place in range(min(LEARNED_AT[0], count))]
    learning, index = once(Call(partial(Index.learned, sample, 0)))
    note = f"from {len(sample)} people; bytes: of the basis"
    yield record("learn the shared basis", size, learning, bytes=index.basis.rows.nbytes, note=note)
    units = _photographs(path, pool, count)
    first, found = _asked(path, units)
    again, _ = once(Call(gallery.index))
    note = f"a sample of {min(LEARNED_AT[-1], count)} of {count}, everybody sketched and written anew"
    yield record("learn it anew in a folder", size, again, note=note)
    second, others = _asked(path, units)
    wrong = sum(one.people != other.people for one, other in zip(found, others, strict=True))
    yield record(
        "single query, exact top-1, the basis of everybody",
        size,
        second,
        first,
        error=wrong,
        unit=DIFFER,
        note=f"{_left(others, count)}; beside that of relatives of {RELATED} among them: {_left(found, count)}",
    )


def _asked(path: Path, units: Units) -> tuple[Timing, list[Found]]:
    """Return the median time of a search, and the answers."""
    (share,) = shares_of(str(path), 1)
    shelf, watch = share.shelf(), Stopwatch(Shelf.search)
    shelf.search(units[0])
    found = [watch.run(lambda: shelf.search(unit)) for unit in units]  # noqa: B023
    return watch.timing(), found


def _photographs(path: Path, pool: list[hf.Surface], count: int) -> Units:
    """Return photographs of people who are enrolled, under one lamp, as a camera takes them."""
    rng, every, photographs = np.random.default_rng(0), count // QUERIES, []
    for number, (_, person) in enumerate(Crowd(pool, count).people()):
        if number % every == every - 1:
            towards = rng.normal(size=3) * [1.0, 1.0, 0.0] + [0.0, 0.0, 1.0]
            photo = hf.photograph(hf.render(person, hf.lights.directional(towards)), rng, noise=NOISE)
            photographs.append(unit_photo(photo.ravel(), photo.size))
    return np.stack(photographs)


def _left(found: list[Found], count: int) -> str:
    """Say how many people the first bound leaves."""
    return f"{100 * np.mean([one.survivors[0] for one in found]) / count:.2f} % survive the first bound"


def _default(pool: list[hf.Surface], count: int) -> Iterator[Record]:
    """Enrol with the default model, whose templates take most of the time, here and on two workers."""
    people = [(f"person {number}", person) for number, person in enumerate(morphs(pool, count))]
    mask = np.ones((SIZE, SIZE), np.bool_)
    quiet = {"silence_logs": logging.CRITICAL, "dashboard_address": ":0"}
    with (
        tempfile.TemporaryDirectory() as place,
        LocalCluster(n_workers=2, threads_per_worker=1, **quiet) as cluster,
        Client(cluster) as client,
    ):
        client.wait_for_workers(2, timeout=60)
        list(in_order(client, abs, range(100)))  # the workers import the package
        hf.Gallery.create(f"{place}/here", mask=mask)
        hf.Gallery.create(f"{place}/there", mask=mask)
        here, there = hf.Gallery.open(f"{place}/here"), hf.Gallery.open(f"{place}/there", client)
        spent = [time.process_time()]
        alone, _ = once(Call(lambda: here.enroll_many(people), hf.Gallery.enroll_many, about="in one process"))
        spent.append(time.process_time())
        shared, _ = once(Call(lambda: there.enroll_many(people), hf.Gallery.enroll_many, about="on two workers"))
        spent.append(time.process_time())
        each, writer = 1e3 * np.diff(spent) / count
        yield record(
            "enrol one person with the default model, on workers",
            f"{count} people {SIZE}x{SIZE}",
            replace(shared, seconds=shared.seconds / count),
            replace(alone, seconds=alone.seconds / count),
            note=(
                f"{count / shared.seconds:.0f} people a second on two workers, {count / alone.seconds:.0f} without; "
                f"{each:.1f} ms of processor each, {writer:.1f} ms of which in the process that asks and writes"
            ),
        )


def _memory() -> int:
    """Return the bytes of this process that are not pages of files."""
    for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
        if line.startswith("RssAnon"):
            return int(line.split()[1]) * 1024
    return 0


if __name__ == "__main__":
    run_benchmark(__doc__, records, "1,600 people instead of 20,000, 40 instead of 400 by default", seed=0)
