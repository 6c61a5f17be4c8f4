"""How much faster is the exact search than reading everybody? Beside the float32 product of all rows, same answers.

Run it as `python benchmarks/search.py [--quick] [--people N] [--ict FOLDER] [--folder DIR] [--json FILE]`. Every person
is made by the generator, one by one (36 ms of one core each; 20,000 take 6 minutes of two cores), and kept in DIR if it
is given: 2.6 GB for 20,000. Every answer is compared with that of the scan, and differing stops the benchmark. The
shared basis is learned from the first 1,000 people's rows, weighted by their singular values; no photograph is seen.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import harmonicface as hf
from harmonicface.bench.crowds import SYNTHETIC, ict_crowd
from harmonicface.bench.measure import Record, print_records, write_records
from harmonicface.gallery.search.batches import search_many
from harmonicface.gallery.search.cascade import Found, search
from harmonicface.gallery.search.crowd import Company, crowd
from harmonicface.gallery.search.pixels import Pixels
from harmonicface.gallery.search.shared_basis import SharedBasis
from harmonicface.gallery.search.sketch import COLUMNS, sketch
from harmonicface.recognition.subspace import Subspace, unit_photo

SIZE = 64
CHUNK = 200
ASKED = 4  # of each chunk
SAMPLE = 1_000
FLOOR = 1e-3  # weight of the weakest modes beside all
BATCH = 64
THRESHOLD = 0.1  # the default of galleries that compare distances
ROUNDING = 2e-3  # of the scan's squares: whoever is so near the last place is measured exactly
LIGHTS = ("one lamp", "natural")
NOISES = (0.0, 0.05)
Units = NDArray[np.float64]


@dataclass(frozen=True)
class People:
    """Everybody's rows one after the other, and what a search needs beside them."""

    array: NDArray[np.float32]
    starts: NDArray[np.intp]
    companies: tuple[Company, ...]
    pixels: Pixels
    basis: SharedBasis

    def scan(self, units: Units) -> NDArray[np.float32]:
        """Return everybody's |Q y|^2 for unit photographs (q, p) by one product, (n, q)."""
        products = self.array @ units.T.astype(np.float32)
        return np.add.reduceat(np.square(products, out=products), self.starts[:-1], axis=0)

    def answer(self, unit: Units, closeness: NDArray[np.float32], top: int | None, distance: float) -> list[object]:
        """Return the scan's answer, measured exactly near the last place."""
        last = 1 - distance**2 if top is None else np.partition(closeness, -top)[-top]
        near = np.flatnonzero(closeness >= last - ROUNDING)
        exact = sorted((self.pixels.distance(int(who), unit), int(who)) for who in near)
        return [one for one in exact if one[0] <= distance][:top]


def make_chunk(job: tuple[str | None, int, str]) -> None:
    """Make some people, and photographs of the first of them, and write them."""
    ict, number, place = job
    draw = (ict_crowd(ict) if ict else SYNTHETIC).draw
    mask = next(iter(draw(1, SIZE, 0))).mask
    rows, energies, photos = [], [], []
    rng = np.random.default_rng(number)
    for index, person in enumerate(draw(CHUNK, SIZE, number)):
        images = np.zeros((9, *mask.shape), np.float32)
        images[:, person.mask] = hf.harmonic_images(person)
        subspace = Subspace.of(images[:, mask])
        rows.append(subspace.rows)
        values = 1 / np.square(subspace.to_coefficients).sum(axis=1)
        energies.append(values / values.sum() + FLOOR)
        if index < ASKED:
            towards = rng.normal(size=3) * [1.0, 1.0, 0.0] + [0.0, 0.0, 1.0]
            lights = hf.lights.directional(towards), hf.lights.natural(int(rng.integers(1 << 30)))
            photos.append([hf.render(person, light)[mask] for light in lights])
    ranks = [len(one) for one in rows]
    np.savez(place, rows=np.concatenate(rows), ranks=ranks, energies=np.concatenate(energies), photos=photos)


def people(count: int, ict: str | None, folder: Path, found: list[Record]) -> tuple[People, NDArray[np.float32]]:
    """Return everybody and photographs (q, lights, p) of some of them; enrolling them is recorded."""
    jobs = [
        (ict, number, str(folder / f"{'ict' if ict else 'synthetic'} {number}.npz")) for number in range(count // CHUNK)
    ]
    with ProcessPoolExecutor(2) as pool:
        list(pool.map(make_chunk, [job for job in jobs if not Path(job[2]).exists()]))
    chunks = [np.load(place) for _, _, place in jobs]
    photos = np.concatenate([chunk["photos"] for chunk in chunks])
    starts = np.cumsum([0, *np.concatenate([chunk["ranks"] for chunk in chunks])])
    energies = np.concatenate([chunk["energies"] for chunk in chunks])
    array = np.empty((starts[-1], photos.shape[2]), np.float32)
    for number, chunk in enumerate(chunks):
        array[starts[number * CHUNK] : starts[(number + 1) * CHUNK]] = chunk["rows"]
    sample, size = starts[min(SAMPLE, count)], f"{count} people {SIZE}x{SIZE}"
    start = time.perf_counter()
    basis = SharedBasis.of(array[:sample], energies[:sample], COLUMNS[-1])
    note = f"{len(basis.rows)} rows from {min(SAMPLE, count)} people"
    found.append(
        Record("learn the shared basis", size, time.perf_counter() - start, bytes=basis.rows.nbytes, note=note)
    )
    start = time.perf_counter()
    sketches = [sketch(array[a:b], basis) for a, b in pairwise(starts)]
    seconds = (time.perf_counter() - start) / count
    start = time.perf_counter()
    for a, b in pairwise(starts[:51]):
        np.linalg.qr(array[a:b].T)
    alone = (time.perf_counter() - start) / 50
    kept = sum(one.nbytes for one in (sketches[0].numbers, sketches[0].turns, sketches[0].squares, sketches[0].doubts))
    found.append(Record("sketch one person", size, seconds, bytes=kept, peer="QR of her rows", peer_seconds=alone))
    pixels = Pixels(
        lambda who: array[starts[who] : starts[who + 1]], np.array([one.defect for one in sketches]), array.shape[1]
    )
    return People(array, starts, crowd(sketches, COLUMNS[: len(sketches[0].squares)]), pixels, basis), photos


def photographs(lit: NDArray[np.float32], noise: float, count: int) -> Units:
    """Return unit photographs of pictures, as a camera takes them if there is noise."""
    rng = np.random.default_rng(0)
    taken = [hf.photograph(one[None], rng, noise=noise)[0] if noise else one for one in lit[:count]]
    return np.stack([unit_photo(one, lit.shape[1]) for one in taken])


def measure(
    everybody: People, units: Units, top: int | None, distance: float, about: tuple[str, str, str], found: list[Record]
) -> None:
    """Time one question, one photograph after the other and together, against the scan."""
    question, size, tier = about
    ours, theirs, answers = [], [], []
    for unit in units:
        seconds, closeness = _timed(lambda: everybody.scan(unit[None])[:, 0])  # noqa: B023
        theirs.append(seconds)
        arguments = everybody.companies, everybody.pixels, everybody.basis, unit, top, distance
        seconds, answer = _timed(lambda: search(*arguments))  # noqa: B023
        ours.append(seconds)
        _compare(answer, everybody.answer(unit, closeness, top, distance))
        answers.append(answer)
    note = f"{tier}; {_survivors(answers, len(everybody.starts) - 1)}"
    seconds, peer = float(np.median(ours)), float(np.median(theirs))
    read = everybody.companies[0].numbers[0].nbytes
    scan = f"float32 product with {everybody.array.shape[0]} x {everybody.array.shape[1]}"
    found.append(Record(f"single query, {question}", size, seconds, 0, read, scan, peer, note))
    batch = np.resize(units, (BATCH, units.shape[1]))
    peer, _ = _timed(lambda: everybody.scan(batch))
    seconds, together = _timed(
        lambda: search_many(everybody.companies, everybody.pixels, everybody.basis, batch, top, distance)
    )
    for number, one in enumerate(together):
        same = answers[number % len(units)]
        _compare(one, list(zip(same.distances, same.people, strict=True)))
    found.append(Record(f"{BATCH} queries, {question}", size, seconds, 0, None, scan, peer, tier))


def _compare(answer: Found, expected: list[object]) -> None:
    """Stop if an answer is not the scan's."""
    if list(zip(answer.distances, answer.people, strict=True)) != expected:
        raise SystemExit(f"search: expected {expected}, got {answer}")


def _survivors(answers: list[Found], count: int) -> str:
    """Return how many people survive each stage, in percent, and are measured."""
    stages = max(len(one.survivors) for one in answers)
    padded = [one.survivors + one.survivors[-1:] * (stages - len(one.survivors)) for one in answers]
    shares = ", ".join(f"{100 * share / count:.2f}" for share in np.mean(padded, axis=0))
    measured = np.mean([one.measured for one in answers])
    return f"{shares} % survive {len(padded[0])} stages, {measured:.1f} measured"


def _timed(call: Callable[[], object]) -> tuple[float, object]:
    """Return the time of a call and its result."""
    start = time.perf_counter()
    result = call()
    return time.perf_counter() - start, result


def records(count: int, ict: str | None, folder: Path) -> list[Record]:
    """Ask every question under every light."""
    found: list[Record] = []
    everybody, photos = people(count, ict, folder, found)
    size = f"{count} {'ict ' if ict else ''}people {SIZE}x{SIZE}"
    for number, light in enumerate(LIGHTS):
        for noise in NOISES:
            units = photographs(photos[:, number], noise, 16)
            tier = f"{light}, {100 * noise:g} % noise"
            measure(everybody, units, 1, 1.0, ("exact top-1", size, tier), found)
            measure(everybody, units, None, THRESHOLD, (f"all within {THRESHOLD}", size, tier), found)
            measure(everybody, units, 5, 1.0, ("exact top-5", size, tier), found)
    return found


def main() -> None:
    """Print the records, and write them if asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="800 people instead of 20,000")
    parser.add_argument("--people", type=int, default=20_000, help=f"how many, in steps of {CHUNK}")
    parser.add_argument("--ict", help="FaceXModel of ICT-FaceKit: its heads instead of the built-in people")
    parser.add_argument("--folder", type=Path, help="keep the people here, and use those that are there")
    parser.add_argument("--json", help="write the records here")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        found = records(800 if options.quick else options.people, options.ict, options.folder or Path(place))
    print_records(found)
    if options.json:
        write_records(options.json, found)


if __name__ == "__main__":
    main()
