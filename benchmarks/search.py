"""How much faster is the exact search than reading everybody? Beside the float32 product of all rows, same answers.

Run it as `python benchmarks/search.py [--quick] [--people N] [--drawn N] [--ict FOLDER] [--folder DIR] [--json FILE]`.
Every person is made by the generator, one by one (36 ms of one core each, 160 ms for ICT heads), and kept in DIR if it
is given; with --drawn fewer are, and the others are morphs between random pairs of them (`morph`). Up to 50,000 people
are kept in memory as float32 (2.6 GB for 20,000), more in a file of float16 that is mapped, and scanned block by block.

Every answer is compared with that of the scan, and differing stops the benchmark. The shared basis is learned from
4,000 people chosen at random among those of whom no photograph is asked for, weighted by their singular values.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

import harmonicface as hf
from harmonicface.bench.command_line import benchmark_parser, finish
from harmonicface.bench.crowds import SYNTHETIC, ict_crowd
from harmonicface.bench.measure import Record
from harmonicface.bench.timing import Call, Stopwatch, best, once, record
from harmonicface.gallery.search.cascade import Found, search, search_many
from harmonicface.gallery.search.crowd import Company, crowd
from harmonicface.gallery.search.pixels import Pixels
from harmonicface.gallery.search.shared_basis import SharedBasis
from harmonicface.gallery.search.sketch import COLUMNS, Sketch, sketches
from harmonicface.recognition.subspace import Subspace, unit_photo

SIZE, RANK = 64, 9
CHUNK = 200
ASKED = 4  # of each chunk; the first was looked at when the search was built, and is not asked for here
SAMPLE = 4_000
FLOOR = 1e-3  # weight of the weakest modes beside all
BATCH, ALONE = 64, 8
THRESHOLD = 0.1  # the default of galleries that compare distances
ROUNDING = 2e-3  # of the scan's squares: whoever is so near the last place is measured exactly
IN_MEMORY = 50_000  # people
BLOCK = 2_000  # people whose float16 rows become float32 together
LIGHTS = ("one lamp", "natural")
NOISES = (0.0, 0.05)
CURVE = (1_000, 5_000)
QUESTIONS = (("exact top-1", 1, 1.0), (f"all within {THRESHOLD}", None, THRESHOLD), ("exact top-5", 5, 1.0))
SHORTLIST = ("exact top-50", 50, 1.0)
Units = NDArray[np.float64]
Rows = NDArray[np.floating]


@dataclass(frozen=True)
class People:
    """Everybody's rows one after the other, and what a search needs beside them."""

    array: Rows
    sketches: Sequence[Sketch]
    basis: SharedBasis
    kind: str

    @cached_property
    def companies(self) -> tuple[Company, ...]:
        """Everybody's sketches."""
        return crowd(self.sketches, self.sketches[0].stops)

    @cached_property
    def pixels(self) -> Pixels:
        """Everybody's rows, one by one."""
        defects = np.array([one.defect for one in self.sketches])
        return Pixels(lambda who: self.array[RANK * who : RANK * who + RANK], defects, self.array.shape[1])

    @property
    def size(self) -> str:
        """How many they are."""
        return f"{len(self.sketches)} {self.kind}people {SIZE}x{SIZE}"

    def first(self, count: int) -> People:
        """Return the first ones alone."""
        return People(self.array[: RANK * count], self.sketches[:count], self.basis, self.kind)

    def asked(self, unit: Units, top: int | None, distance: float) -> tuple[object, ...]:
        """Return the arguments of a search."""
        return self.companies, self.pixels, self.basis, unit, top, distance

    def answer(
        self, unit: Units, closeness: NDArray[np.float32], top: int | None, distance: float
    ) -> list[tuple[float, int]]:
        """Return the scan's answer, measured exactly near the last place."""
        last = 1 - distance**2 if top is None else np.partition(closeness, -top)[-top]
        near = np.flatnonzero(closeness >= last - ROUNDING)
        exact = sorted((distance_from(self.array[RANK * who : RANK * who + RANK], unit), int(who)) for who in near)
        return [one for one in exact if one[0] <= distance][:top]

    def read(self, found: Found) -> int:
        """Return the bytes that a search has read."""
        forms, stages = self.companies[0].forms.nbytes, len(found.survivors) - 1
        columns = [4 * stop for stop in self.companies[0].stops[:stages]] + [self.array[0].nbytes]
        return forms + sum(RANK * who * width for who, width in zip(found.survivors, columns, strict=True))


def distance_from(rows: Rows, unit: Units) -> float:
    """Return how far a photograph is from a person's span, by a least-squares fit of double precision."""
    double = rows.T.astype(np.float64)
    return float(np.linalg.norm(unit - double @ np.linalg.lstsq(double, unit)[0]))


def scan(array: Rows, units: Units) -> NDArray[np.float32]:
    """Return everybody's |Q y|^2 for unit photographs (q, p) by one product, or by one of each block, (n, q)."""
    single = units.T.astype(np.float32)
    step = len(array) if array.dtype == np.float32 else RANK * BLOCK
    parts = [np.asarray(array[start : start + step], np.float32) @ single for start in range(0, len(array), step)]
    squares = [np.square(part, out=part).reshape(-1, RANK, len(units)).sum(axis=1) for part in parts]
    return np.concatenate(squares)


def make_chunk(job: tuple[str | None, int, Path]) -> None:
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
        energies.append(energies_of(subspace))
        if index < ASKED:
            towards = rng.normal(size=3) * [1.0, 1.0, 0.0] + [0.0, 0.0, 1.0]
            lights = hf.lights.directional(towards), hf.lights.natural(int(rng.integers(1 << 30)))
            photos.append([hf.render(person, light)[mask] for light in lights])
    np.savez(place, rows=np.concatenate(rows), energies=np.concatenate(energies), photos=photos)


def energies_of(subspace: Subspace) -> NDArray[np.float64]:
    """Return the squares of the singular values of somebody's images, of sum 1, and a little more."""
    values = 1 / np.square(subspace.to_coefficients).sum(axis=1)
    return np.asarray(values / values.sum() + FLOOR)


def make_morphs(job: tuple[Path, Path, int, Path]) -> None:
    """Make people between those of two files, and write them."""
    first, second, number, place = job
    rng, one, other = np.random.default_rng(number), np.load(first), np.load(second)
    split = [np.split(chunk[name], CHUNK) for chunk in (one, other) for name in ("rows", "energies")]
    partners, shares = rng.permutation(CHUNK), rng.uniform(0.3, 0.7, CHUNK)
    between = [
        morph(split[0][index], split[1][index], split[2][partner], split[3][partner], shares[index])
        for index, partner in enumerate(partners)
    ]
    rows, energies = (np.concatenate(some) for some in zip(*between, strict=True))
    np.savez(place, rows=rows, energies=energies)


def morph(first: Rows, one: Rows, second: Rows, other: Rows, share: float) -> tuple[Rows, NDArray[np.float64]]:
    """Return a person between two: her images are a mean of theirs, turned so that they agree best."""
    images = np.sqrt(np.maximum(one - FLOOR, 0))[:, None] * first
    others = np.sqrt(np.maximum(other - FLOOR, 0))[:, None] * second
    left, _, right = np.linalg.svd(images @ others.T)
    between = Subspace.of((1 - share) * images + share * (left @ right @ others))
    return between.rows, energies_of(between)


def draw_people(count: int, drawn: int, ict: str | None, folder: Path) -> tuple[Rows, Rows, NDArray[np.float32]]:
    """Return everybody's rows and energies, and photographs (q, lights, p) of some of the first ones."""
    kind, chunks = "ict" if ict else "synthetic", drawn // CHUNK
    places = [folder / f"{kind} {number}.npz" for number in range(chunks)]
    more = [folder / f"{kind} {number} of {chunks}.npz" for number in range(chunks, count // CHUNK)]
    rng = np.random.default_rng(0)
    pairs = [
        (*(places[index] for index in rng.choice(chunks, 2, replace=False)), chunks + n, place)
        for n, place in enumerate(more)
    ]
    with ProcessPoolExecutor(2) as pool:
        list(pool.map(make_chunk, [(ict, number, place) for number, place in enumerate(places) if not place.exists()]))
        list(pool.map(make_morphs, [pair for pair in pairs if not pair[3].exists()]))
    photos = np.concatenate([np.load(place)["photos"] for place in places])
    shape = RANK * count, photos.shape[2]
    if count > IN_MEMORY:
        array = np.lib.format.open_memmap(folder / f"{kind} {count}.npy", "w+", np.float16, shape)
    else:
        array = np.empty(shape, np.float32)
    for number, place in enumerate((*places, *more)):
        array[RANK * CHUNK * number : RANK * CHUNK * (number + 1)] = np.load(place)["rows"]
    return array, np.concatenate([np.load(place)["energies"] for place in (*places, *more)]), photos


def enrol(array: Rows, energies: Rows, asked: Sequence[int], kind: str) -> tuple[People, list[Record]]:
    """Learn the shared basis, and sketch everybody, beside what the QR factorization of each alone takes."""
    count = len(array) // RANK
    others = np.setdiff1d(np.arange(count), asked)
    sample = np.sort(np.random.default_rng(0).choice(others, min(SAMPLE, len(others)), replace=False))
    rows = np.asarray(array.reshape(count, RANK, -1)[sample], np.float32).reshape(RANK * len(sample), -1)
    weights = energies.reshape(count, RANK)[sample].ravel()
    learning, basis = once(partial(SharedBasis.of, rows, weights, COLUMNS[-1]))
    size, found = f"{count} {kind}people {SIZE}x{SIZE}", []
    note = f"{len(basis.rows)} rows from {len(sample)} people"
    found.append(record("learn the shared basis", size, learning, bytes=basis.rows.nbytes, note=note))
    watch, everybody = Stopwatch(sketches), []
    for start in range(0, len(array), RANK * BLOCK):
        block = np.split(array[start : start + RANK * BLOCK], len(array[start : start + RANK * BLOCK]) // RANK)
        everybody += watch.run(lambda block=block: list(sketches(block, basis)))
    alone = best(Call(partial(qr_of_each, array[: 50 * RANK].astype(np.float32)), np.linalg.qr))
    one = everybody[0]
    kept = sum(some.nbytes for some in (one.form, *one.numbers, one.levels, one.doubts))
    each = watch.timing(lambda seconds: sum(seconds) / count)
    found.append(
        record("sketch one person", size, each, alone.times(1 / 50), bytes=kept, note="mean of all; the peer of 50")
    )
    return People(array, everybody, basis, kind), found


def qr_of_each(rows: Rows) -> None:
    """Factor the rows of each person."""
    for one in np.split(rows, len(rows) // RANK):
        np.linalg.qr(one.T)


def photographs(lit: NDArray[np.float32], noise: float) -> Units:
    """Return unit photographs of pictures, as a camera takes them if there is noise."""
    rng = np.random.default_rng(0)
    taken = [hf.photograph(one[None], rng, noise=noise)[0] if noise else one for one in lit]
    return np.stack([unit_photo(one, lit.shape[1]) for one in taken])


def ask(
    everybody: People, units: Units, tier: str, questions: Sequence[tuple[str, int | None, float]], together: bool
) -> Iterator[Record]:
    """Time questions about one photograph after the other, and about all together, against the scan."""
    about = f"of {everybody.array.shape[0]} x {everybody.array.shape[1]} {everybody.array.dtype}"
    product = Call(partial(scan, everybody.array, units), about=about)
    whole, peer_together = once(product)[::-1]
    for question, top, distance in questions:
        ours, theirs, answers = Stopwatch(search), Stopwatch(scan, about=about), []
        for number, unit in enumerate(units[:ALONE]):
            theirs.run(partial(scan, everybody.array, unit[None]))  # it also leaves nothing of ours in the caches
            answers.append(ours.run(partial(search, *everybody.asked(unit, top, distance))))
            compare(answers[-1], everybody.answer(unit, whole[:, number], top, distance))
        read = int(np.mean([everybody.read(one) for one in answers]))
        note = f"{tier}; {survivors(answers, len(everybody.sketches))}; reads {read / everybody.array.nbytes:.2%}"
        name, same = f"single query, {question}", {"error": 0.0, "unit": "wrong answers", "question": question}
        yield record(name, everybody.size, ours.timing(), theirs.timing(), bytes=read, note=note, **same)
        if together:
            many = Call(partial(search_many, *everybody.asked(units, top, distance)))
            timing, found = once(many)
            for number, (unit, one) in enumerate(zip(units, found, strict=True)):
                compare(one, everybody.answer(unit, whole[:, number], top, distance))
            timing = min(timing, once(many)[0], key=lambda one: one.seconds)
            peer_together = min(peer_together, once(product)[0], key=lambda one: one.seconds)
            name, note = f"{len(units)} queries, {question}", f"{tier}; {survivors(found, len(everybody.sketches))}"
            yield record(name, everybody.size, timing, peer_together, note=note, **same)


def compare(answer: Found, expected: list[tuple[float, int]]) -> None:
    """Stop if an answer is not the scan's: the same people, at distances that differ by rounding."""
    distances, who = zip(*expected, strict=True) if expected else ((), ())
    if who != answer.people or not np.allclose(distances, answer.distances, rtol=0, atol=1e-9):
        raise SystemExit(f"search: expected {expected}, got {answer}")


def survivors(answers: Sequence[Found], count: int) -> str:
    """Return how many people survive each stage, in percent, and are measured."""
    stages = max(len(one.survivors) for one in answers)
    padded = [one.survivors + one.survivors[-1:] * (stages - len(one.survivors)) for one in answers]
    shares = ", ".join(f"{100 * share / count:.2f}" for share in np.mean(padded, axis=0))
    measured = np.mean([one.measured for one in answers])
    return f"{shares} % survive {len(padded[0])} stages, {measured:.1f} measured"


def others(everybody: People, unit: Units) -> Iterator[Record]:
    """Time one question beside a least-squares fit of each person, and beside OpenCV, of few people and scaled."""
    ours = best(partial(search, *everybody.asked(unit, 1, 1.0)))
    some = np.asarray(everybody.array[: 200 * RANK], np.float32)
    fits = [partial(np.linalg.lstsq, rows.T, unit.astype(np.float32)) for rows in np.split(some, 200)]
    pictures = [
        cv2.normalize(np.resize(row, (SIZE, SIZE)), None, 0, 255, cv2.NORM_MINMAX, cv2.CV_8U) for row in some[::RANK]
    ]
    model = cv2.face.LBPHFaceRecognizer.create()
    model.train(pictures, np.arange(200))
    for peer in (
        Call(lambda: [fit() for fit in fits], np.linalg.lstsq),
        Call(lambda: model.predict(pictures[0]), model.predict),
    ):
        timing = best(peer, repeats=3)
        scaled = timing.times(len(everybody.sketches) / 200)
        note = "the peer's time is that of 200 people, scaled to all"
        yield record("single query, exact top-1", everybody.size, ours, scaled, note=note, question="of others")


def records(count: int, drawn: int, ict: str | None, folder: Path) -> Iterator[Record]:
    """Ask every question under every light."""
    array, energies, photos = draw_people(count, drawn, ict, folder)
    numbers = [index for index in range(len(photos)) if index % ASKED]
    numbers = [numbers[index] for index in np.linspace(0, len(numbers) - 1, min(BATCH, len(numbers))).astype(int)]
    asked = [number // ASKED * CHUNK + number % ASKED for number in numbers]
    kind = ("ict " if ict else "") + ("" if drawn == count else f"({drawn} drawn, others morphs) ")
    everybody, found = enrol(array, energies, asked, kind)
    yield from found
    units = np.empty(0)
    for number, light in enumerate(LIGHTS):
        for noise in NOISES:
            units = photographs(photos[numbers, number], noise)
            last = number == len(LIGHTS) - 1 and noise == NOISES[-1]
            yield from ask(everybody, units, f"{light}, {noise:.0%} noise", QUESTIONS + (SHORTLIST,) * last, True)
    yield from others(everybody, units[0])
    for few in CURVE:
        if few < count:
            yield from ask(everybody.first(few), units, "natural, 5% noise", QUESTIONS, False)


def main() -> None:
    """Print the records, and write them if asked."""
    parser = benchmark_parser(__doc__, "800 people instead of 20,000")
    parser.add_argument("--people", type=int, default=20_000, help=f"how many, in steps of {CHUNK}")
    parser.add_argument("--drawn", type=int, help="how many of them are drawn; the others are morphs; default: all")
    parser.add_argument("--ict", help="FaceXModel of ICT-FaceKit: its heads instead of the built-in people")
    parser.add_argument("--folder", type=Path, help="keep the people here, and use those that are there")
    options = parser.parse_args()
    count = 800 if options.quick else options.people
    with tempfile.TemporaryDirectory() as place:
        run: Callable[[], Iterator[Record]] = partial(
            records, count, min(options.drawn or count, count), options.ict, options.folder or Path(place)
        )
        finish(run(), options.json, "each chunk's number")


if __name__ == "__main__":
    main()
