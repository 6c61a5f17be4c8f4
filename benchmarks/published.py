"""The published errors on Yale B beside those of our classifiers: ten people, subsets 1 to 4, 450 photographs.

Trained on the seven photographs of subset 1, which count as queries too, as in the papers; nine points of light from
real images are trained on nine photographs a person, which do not. Nothing was chosen: lamps, scales and components are
the defaults.

The crop decides much. The papers show faces closely cropped; the data set is cropped wider, with outline and some hair.
Both are measured, "the face alone" being rows 48 to 160 and columns 36 to 132 of 192 x 168, at 42 x 36 pixels: there
methods that compare photographs do as was published, and those of nine dimensions worse.

python benchmarks/published.py [--quick] [--json FILE]
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.measure import Record
from harmonicface.bench.published import DIFFERENCES, Published, published
from harmonicface.bench.table import WRONG
from harmonicface.bench.timing import Stopwatch, record
from harmonicface.datasets.yale_b import load_yale_b
from harmonicface.recognition.estimators.base import FaceClassifier
from harmonicface.recognition.estimators.nine_points import nearest_to_nine
from harmonicface.recognition.estimators.registry import FROM_SURFACES, estimator

DATA = Path(os.environ.get("HARMONICFACE_DATA", Path(__file__).parents[2] / "shared" / "data")) / "yaleb"
FACE = np.s_[:, 48:160, 36:132]
SMALL = (42, 36)
WIDE = "as cropped"
SUBSETS = "1-4"
NAMES = {"harmonic_shadowed_fixed": "harmonic_shadowed"}
TIMED = 20  # single queries
FEW_SECONDS = ("cone_cast",)  # left out by --quick


@dataclass(frozen=True, eq=False)
class Table:
    """Photographs as the rows of a table."""

    about: str
    shape: tuple[int, int]
    pixels: NDArray[np.float32]
    people: NDArray[np.int64]
    lights: NDArray[np.float64]
    subsets: NDArray[np.int64]


def tables() -> tuple[Table, Table]:
    """Read the ten people; as cropped, and the face alone."""
    faces = load_yale_b(DATA, people=range(1, 11))
    photographs = np.concatenate([face.photographs for face in faces])
    people = np.concatenate([np.full(len(face.files), face.number) for face in faces])
    lights = np.concatenate([face.lights for face in faces])
    subsets = np.concatenate([face.subsets for face in faces])
    small = [cv2.resize(photo, SMALL[::-1], interpolation=cv2.INTER_AREA) for photo in photographs[FACE]]

    def table(about: str, images: NDArray[np.float32]) -> Table:
        shape = (images.shape[1], images.shape[2])
        return Table(about, shape, images.reshape(len(images), -1), people, lights, subsets)

    return table(WIDE, photographs), table("the face alone", np.stack(small))


def fitted(name: str, table: Table, training: NDArray[np.bool_], registration: bool) -> FaceClassifier:
    """Return a classifier that has learned the training photographs."""
    registered = {"registration": True} if registration else {}
    classifier = estimator(name, table.shape, **registered)
    pixels, people, lights = table.pixels[training], table.people[training], table.lights[training]
    if name in FROM_SURFACES:
        return classifier.fit(pixels, people, lights=lights)
    return classifier.fit(pixels, people)


def chosen(table: Table, row: Published) -> NDArray[np.bool_]:
    """Return which photographs are learned: subset 1, or the nine nearest to the nine points of light."""
    if row.train == "subset1":
        return np.asarray(table.subsets == 1)
    training = np.zeros(len(table.people), bool)
    for person in np.unique(table.people):
        own = np.flatnonzero(table.people == person)
        training[own[nearest_to_nine(table.lights[own])]] = True
    return training


def measured(row: Published, table: Table, registration: bool = False) -> Record:
    """Measure one method."""
    training = chosen(table, row)
    asked = table.subsets <= 4
    if row.train != "subset1":
        asked &= ~training
    classifier = fitted(NAMES.get(row.ours, row.ours), table, training, registration)
    wrong = classifier.predict(table.pixels[asked]) != table.people[asked]
    queries = table.pixels[asked][:: max(1, int(asked.sum()) // TIMED)]
    watch = Stopwatch(classifier.predict)
    for query in queries:
        watch.run(partial(classifier.predict, query[None]))
    theirs, found = row.rate(SUBSETS), float(wrong.mean())
    place = "below" if found < theirs.low else "above" if found > theirs.high else "inside"
    by_subset = " / ".join(f"{100 * np.mean(wrong[table.subsets[asked] == subset]):.1f}" for subset in (1, 2, 3, 4))
    height, width = table.shape
    how = f"{table.about}, {height} x {width}" + (", registered" if registration else "")
    note = f"{wrong.sum()} of {len(wrong)}; subsets 1 to 4: {by_subset}; published {theirs}: {place}"
    if place != "inside" and table.about == WIDE and row.ours in DIFFERENCES:
        note += f": {DIFFERENCES[row.ours]}"
    question = f"{table.about}{', registered' if registration else ''}"
    return record(row.ours, how, watch.timing(), error=100 * found, unit=WRONG, question=question, note=note)


def records(quick: bool) -> Iterator[Record]:
    """Yield everything; `quick` leaves out what takes minutes."""
    wide, face = tables()
    rows = [*published("subset1"), *(row for row in published("nine-lights") if row.ours == "nine_points_real")]
    for table in (face,) if quick else (wide, face):
        for row in rows:
            if not (quick and row.ours in FEW_SECONDS):
                yield measured(row, table)
    if not quick:
        for row in rows:
            if NAMES.get(row.ours, row.ours) in FROM_SURFACES:
                yield measured(row, wide, registration=True)


if __name__ == "__main__":
    run_benchmark(__doc__, records, "the face alone, without the sampled cone", needs=DATA)
