"""Half of the people are unknown: how many of the others are identified where 1 % of strangers raise an alarm.

Yale B, subsets 1 to 4, random splits of the people into enrolled and unknown. The threshold comes from enrolled people
only, from the photographs that they were enrolled from (`Gallery.calibrate`), which are not searched with. The way to
predict strangers was chosen on people 1 to 5.

python benchmarks/open_set.py [--quick] [--json FILE]
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.measure import Record
from harmonicface.bench.timing import Stopwatch, record
from harmonicface.bench.yale_b import enrolled_people
from harmonicface.bench.yale_contenders import ClassifierContender
from harmonicface.datasets.yale_b import YalePerson, load_yale_b
from harmonicface.gallery.gallery import Gallery
from harmonicface.gallery.looks.second_look import SecondLook, second_look
from harmonicface.recognition.identification import OpenSet, identification_curve, open_set
from harmonicface.recognition.intervals import rate

DATA = Path(os.environ.get("HARMONICFACE_DATA", Path(__file__).parents[2] / "shared" / "data")) / "yaleb"
GROUPS = {"all": range(1, 12), "1-5": range(1, 6), "6-11": range(6, 12)}
FPIR = 0.01
UNIT = "% of searches for enrolled people that do not identify them"
PEERS = ("tan_triggs", "lbph", "gradient_angle", "harmonic9", "eigenfaces_minus3")

MEASURES = ("patterns", "surprises", "rendered", "closeness")

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


@dataclass(frozen=True, eq=False)
class Look:
    """A photograph of somebody, whether she is enrolled from it, and how alike everybody is."""

    number: int
    photo: NDArray[np.float32]
    enrolled: bool
    seen: SecondLook

    def scores(self, places: Sequence[int]) -> Table:
        """Return the scores as if only some people were enrolled."""
        measures = {name: getattr(self.seen, name) for name in MEASURES}
        part = {name: None if values is None else values[places] for name, values in measures.items()}
        return replace(self.seen, **part).scores


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


def looked(gallery: Gallery, faces: Sequence[YalePerson], one: bool, watch: Stopwatch) -> list[Look]:
    """Compare photographs of subsets 1 to 4 with everybody; how alike one person is does not depend on the others."""
    people, found = gallery._people, []
    portraits = [people.portrait(place) for place in range(len(gallery))]
    for face in faces:
        enrolled = chosen_photographs(face, one)
        for place in np.flatnonzero(face.subsets <= 4):
            photo = face.photographs[place]
            seen = watch.run(
                lambda photo=photo: second_look(people.photograph(*people.asked(photo, None)), portraits)  # type: ignore[misc]
            )
            found.append(Look(face.number, photo, bool(enrolled[place]), seen))
    return found


def searches(looks: Sequence[Look], faces: Sequence[YalePerson], enrolled: Sequence[YalePerson]) -> Searches:
    """Return the scores in a gallery of some people; their photographs that they are enrolled from are left out."""
    places = [place for place, face in enumerate(faces) if face in enrolled]
    names = [face.number for face in enrolled]
    asked = [look for look in looks if not (look.number in names and look.enrolled)]
    return Searches(np.array([look.scores(places) for look in asked]), np.array([look.number for look in asked]))


def through_match(gallery: Gallery, looks: Sequence[Look], seed: int) -> tuple[int, int, int, int]:
    """Search with every tenth photograph as users do, which also looks elsewhere: right, known, named, strangers."""
    right, known, named, strangers = 0, 0, 0, 0
    for look in looks[seed % 10 :: 10]:
        if str(look.number) not in gallery:
            named, strangers = named + (gallery.match(look.photo).name is not None), strangers + 1
        elif not look.enrolled:
            right, known = right + (gallery.match(look.photo).name == str(look.number)), known + 1
    return right, known, named, strangers


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
    watch = Stopwatch(second_look)
    looks = looked(everybody, faces, one, watch)
    thresholds, promised, matched, off = [], [], np.zeros(4, int), 0.0
    with tempfile.TemporaryDirectory() as folder:
        for seed, (enrolled, unknown) in enumerate(splits(faces, count)):
            path = Path(folder) / f"{seed}.gallery"  # each its own: who is taken out of a gallery on disk is gone there
            everybody.save(path)
            gallery = Gallery.open(path)
            for face in unknown:
                gallery.remove(str(face.number))
            members = [face for face in faces if face in enrolled]
            found = gallery.calibrate(FPIR, **({} if renderings else own_photographs(members, one)))  # type: ignore[arg-type]
            thresholds.append(found.threshold)
            promised.append(found.expected[10 * len(gallery)])
            names = [face.number for face in members]
            asked = searches(looks, faces, members)
            by_gallery = gallery.search_scores(looks[-1 - seed].photo, among=[str(name) for name in names]).scores
            columns = [place for place, face in enumerate(faces) if face in members]
            off = max(off, float(np.abs(looks[-1 - seed].scores(columns) - by_gallery).max()))
            matched += through_match(gallery, looks, seed)
            strangers = [face.number for face in unknown]
            for group, some in GROUPS.items():
                parts = asked.of([n for n in names if n in some]), asked.of([n for n in strangers if n in some])
                if len(parts[0].people) and len(parts[1].people):
                    outcomes[group].append(judged(*parts, names, found.threshold))
    kind = "one photograph" if one else "subset 1"
    how = "renderings" if renderings else "their photographs"
    right, known, named, others = matched
    return record(
        f"open set, enrolled from {kind}, calibrated on {how}",
        f"{len(faces) // 2} of {len(faces)} people, {count} splits",
        watch.timing(),
        error=100 - 100 * mean_identified(outcomes["all"]),
        unit=UNIT,
        seed=f"0 to {count - 1}",
        question="open set",
        note=f"{described(outcomes)}; "
        f"{interval(outcomes, looks)}; "
        f"threshold {np.mean(thresholds):.2f} +- {np.std(thresholds):.2f}; with 10 times as many people expected "
        f"{100 * np.mean(promised):.1f} % false alarms; by `match` on a tenth of the photographs {right} of {known} "
        f"identified, {named} of {others} strangers named; scores differ from those of the gallery by {off:.1e}",
    )


def own_photographs(faces: Sequence[YalePerson], one: bool) -> dict[str, list[object]]:
    """Return the photographs that people are enrolled from, and their names."""
    own = [(photo, str(face.number)) for face in faces for photo in face.photographs[chosen_photographs(face, one)]]
    return {"photographs": [photo for photo, _ in own], "names": [name for _, name in own]}


def interval(outcomes: dict[str, list[Outcome]], looks: Sequence[Look]) -> str:
    """Say the 95 % binomial intervals; splits share photographs, so that only different photographs count."""
    rates = [one.calibrated for one in outcomes["all"] if one.calibrated]
    alarms = float(np.mean([one.fpir.value for one in rates]))
    missed = 1 - mean_identified(outcomes["all"])
    said = [
        f"{kind} {rate(round(value * len(looks)), len(looks))}"
        for kind, value in (("missed", missed), ("alarms", alarms))
    ]
    return f"as if of {len(looks)} photographs, each once: {', '.join(said)}"


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
    distances, people, watch = [], [], Stopwatch()
    for face in faces:
        for photo in face.photographs[(face.subsets > 1) & (face.subsets <= 4)]:
            distances.append(watch.run(partial(method.distances, photo)))
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
    return record(
        f"open set, {name}, enrolled from subset 1",
        f"{len(faces) // 2} of {len(faces)} people, {count} splits",
        watch.timing(),
        error=100 - 100 * float(np.mean(found[best])),
        unit=UNIT,
        seed=f"0 to {count - 1}",
        question="open set",
        note="where 1 % of strangers' searches raise an alarm, as measured on these strangers; "
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


if __name__ == "__main__":
    run_benchmark(__doc__, records, "3 splits and one peer", needs=DATA)
