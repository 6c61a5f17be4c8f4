"""Half of the people are unknown: how many of the others are identified where 1 % of strangers raise an alarm.

Yale B, subsets 1 to 4, random splits of the people into enrolled and unknown. The threshold comes from enrolled people
only, from the photographs that they were enrolled from (`Gallery.calibrate`), which are not searched with. The way to
predict strangers was chosen on people 1 to 5. Run it as `python benchmarks/open_set.py [--quick] [--json FILE]`.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from harmonicface.bench.measure import Record, print_records, write_records
from harmonicface.bench.yale_b import enrolled_people
from harmonicface.bench.yale_contenders import ClassifierContender
from harmonicface.datasets.yale_b import YalePerson, load_yale_b
from harmonicface.gallery.gallery import Gallery
from harmonicface.recognition.identification import OpenSet, identification_curve, open_set

DATA = Path(os.environ.get("HARMONICFACE_DATA", Path(__file__).parents[2] / "shared" / "data")) / "yaleb"
GROUPS = {"all": range(1, 12), "1-5": range(1, 6), "6-11": range(6, 12)}
FPIR = 0.01
PEERS = ("tan_triggs", "lbph", "gradient_angle", "harmonic9", "eigenfaces_minus3")

Table = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Searches:
    """Scores of searches with enrolled people, who is in the photographs, and which photographs they are."""

    scores: Table  # (searches, enrolled)
    people: NDArray[np.int64]  # numbers of the data set

    def of(self, numbers: Sequence[int]) -> Searches:
        """Return the searches of some people."""
        chosen = np.isin(self.people, numbers)
        return Searches(self.scores[chosen], self.people[chosen])


@dataclass(frozen=True)
class Outcome:
    """What a split gave: at the calibrated threshold, and at the one that strangers themselves would set."""

    calibrated: OpenSet | None
    identified: float  # at 1 % of false alarms as measured


def chosen_photographs(face: YalePerson, one: bool) -> NDArray[np.bool_]:
    """Return which photographs a person is enrolled from: subset 1, or the most frontal light."""
    return np.arange(len(face.angles)) == face.angles.argmin() if one else face.subsets == 1


def splits(faces: Sequence[YalePerson], count: int) -> Iterator[tuple[list[YalePerson], list[YalePerson]]]:
    """Divide people into enrolled and unknown, the smaller half enrolled."""
    for seed in range(count):
        order = np.random.default_rng(seed).permutation(len(faces))
        half = len(faces) // 2
        yield [faces[i] for i in order[:half]], [faces[i] for i in order[half:]]


def searched(gallery: Gallery, faces: Sequence[YalePerson], one: bool, times: list[float]) -> Searches:
    """Search for people by their photographs of subsets 1 to 4, without those that anybody is enrolled from."""
    scores, people = [], []
    for face in faces:
        enrolled = chosen_photographs(face, one) & (str(face.number) in gallery)
        for photo in face.photographs[(face.subsets <= 4) & ~enrolled]:
            start = time.perf_counter()
            scores.append(gallery.search_scores(photo).scores)
            times.append(time.perf_counter() - start)
            people.append(face.number)
    return Searches(np.array(scores), np.array(people))


def judged(known: Searches, unknown: Searches, enrolled: Sequence[int], threshold: float | None) -> Outcome:
    """Count."""
    right = np.array([list(enrolled).index(number) for number in known.people])
    best = unknown.scores.max(axis=1)
    curve = identification_curve(known.scores, right, best)
    calibrated = None if threshold is None else open_set(known.scores, right, best, threshold)
    return Outcome(calibrated, float(curve.tmr[curve.fmr <= FPIR].max()))


def ours(faces: Sequence[YalePerson], count: int, one: bool, renderings: bool) -> Record:
    """Enrol, calibrate and search in every split."""
    everybody = Gallery()
    for face in faces:
        photographs = face.photographs[chosen_photographs(face, one)]
        lights = None if one else face.lights[chosen_photographs(face, one)]
        everybody.enroll(str(face.number), photographs, lights=lights)
    outcomes: dict[str, list[Outcome]] = {group: [] for group in GROUPS}
    times: list[float] = []
    thresholds, promised = [], []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "everybody.gallery"
        everybody.save(path)
        for enrolled, unknown in splits(faces, count):
            gallery = Gallery.open(path)
            for face in unknown:
                gallery.remove(str(face.number))
            names = [int(name) for name in gallery.names]
            own = [
                (photo, str(face.number))
                for face in enrolled
                for photo in face.photographs[chosen_photographs(face, one)]
            ]
            given = (
                {} if renderings else {"photographs": [photo for photo, _ in own], "names": [name for _, name in own]}
            )
            found = gallery.calibrate(FPIR, **given)  # type: ignore[arg-type]
            thresholds.append(found.threshold)
            promised.append(found.expected[10 * len(gallery)])
            known, strangers = (searched(gallery, some, one, times) for some in (enrolled, unknown))
            for group, members in GROUPS.items():
                parts = known.of(members), strangers.of(members)
                if len(parts[0].people) and len(parts[1].people):
                    outcomes[group].append(judged(*parts, names, found.threshold))
    kind = "one photograph" if one else "subset 1"
    how = "renderings" if renderings else "their photographs"
    return Record(
        name=f"open set, enrolled from {kind}, calibrated on {how}",
        size=f"{len(faces) // 2} of {len(faces)} people, {count} splits",
        seconds=float(np.median(times)),
        error=100 - 100 * mean_identified(outcomes["all"]),
        note=f"error: % of searches for enrolled people that do not identify them; {described(outcomes)}; "
        f"threshold {np.mean(thresholds):.2f} +- {np.std(thresholds):.2f}; with 10 times as many people expected "
        f"{100 * np.mean(promised):.1f} % false alarms",
    )


def mean_identified(outcomes: Sequence[Outcome]) -> float:
    """Return the mean share of enrolled people's searches that identify them at the calibrated threshold."""
    return float(np.mean([one.calibrated.identified for one in outcomes if one.calibrated]))


def described(outcomes: dict[str, list[Outcome]]) -> str:
    """Say what came out for each group of people."""
    parts = []
    for group, some in outcomes.items():
        found = [one.calibrated for one in some if one.calibrated]
        worst, alarms = min(one.identified for one in found), np.mean([one.fpir.value for one in found])
        measured = np.mean([one.identified for one in some])
        parts.append(
            f"people {group}: identified {100 * mean_identified(some):.2f} % (worst split {100 * worst:.1f}) at "
            f"{100 * alarms:.2f} % false alarms; at 1 % as measured {100 * measured:.2f} %"
        )
    return "; ".join(parts)


def peer(name: str, faces: Sequence[YalePerson], count: int) -> Record:
    """Search with a method that has distances only, at the threshold that strangers themselves set, in its favour."""
    method = ClassifierContender(name)
    method.enroll(enrolled_people(faces, "subset1"))
    distances, people, times = [], [], []
    for face in faces:
        for photo in face.photographs[(face.subsets > 1) & (face.subsets <= 4)]:
            start = time.perf_counter()
            distances.append(method.distances(photo))
            times.append(time.perf_counter() - start)
            people.append(face.number)
    table, asked, numbers = np.array(distances), np.array(people), np.array([face.number for face in faces])
    found: dict[str, list[float]] = {"distance": [], "distance over that of the others": []}
    for enrolled, _ in splits(faces, count):
        names = [face.number for face in enrolled]
        part = table[:, [int(np.flatnonzero(numbers == name)[0]) for name in names]]
        others = (part.sum(axis=1, keepdims=True) - part) / (part.shape[1] - 1)
        for kind, scores in zip(found, (-part, -part / others), strict=True):
            known = np.isin(asked, names)
            outcome = judged(
                Searches(scores[known], asked[known]), Searches(scores[~known], asked[~known]), names, None
            )
            found[kind].append(outcome.identified)
    best = max(found, key=lambda kind: float(np.mean(found[kind])))
    return Record(
        name=f"open set, {name}, enrolled from subset 1",
        size=f"{len(faces) // 2} of {len(faces)} people, {count} splits",
        seconds=float(np.median(times)),
        error=100 - 100 * float(np.mean(found[best])),
        note="error: % of searches for enrolled people that do not identify them where 1 % of strangers' raise an "
        "alarm, as measured on these strangers; "
        + "; ".join(f"by {kind} {100 - 100 * np.mean(one):.2f}" for kind, one in found.items()),
    )


def records(quick: bool) -> Iterator[Record]:
    """Ours from seven photographs and from one, then others."""
    faces = load_yale_b(DATA, range(1, 12))
    count = 3 if quick else 20
    yield ours(faces, count, one=False, renderings=False)
    yield ours(faces, count, one=False, renderings=True)
    yield ours(faces, count, one=True, renderings=False)
    for name in PEERS[:1] if quick else PEERS:
        yield peer(name, faces, count)


def main() -> None:
    """Print the records, and write them if asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="3 splits and one peer")
    parser.add_argument("--json", help="write the records here")
    options = parser.parse_args()
    if not DATA.is_dir():
        print(f"skipped: the photographs of Yale B are not in {DATA} (set HARMONICFACE_DATA)")
        return
    found = []
    for record in records(options.quick):
        print_records([record])
        found.append(record)
    if options.json:
        write_records(options.json, found)


if __name__ == "__main__":
    main()
