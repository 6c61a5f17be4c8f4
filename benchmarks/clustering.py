"""Whose photographs are these? Groups of Yale B under all lights, beside sparse subspace clustering; error beside time.

Settings of all methods, the peers' too, were chosen on people 1 to 5 (`--choose` shows the peers' trials). Run it as
`python benchmarks/clustering.py [--quick] [--choose] [--json FILE]`.
"""

from __future__ import annotations

import argparse
import os
import time
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from sklearn.cluster import spectral_clustering
from sklearn.exceptions import ConvergenceWarning
from sklearn.linear_model import Lasso, orthogonal_mp_gram
from sklearn.metrics.cluster import contingency_matrix

from harmonicface.bench.measure import Record, print_records, write_records
from harmonicface.datasets.yale_b import IMAGE_SHAPE, load_yale_b
from harmonicface.recognition.clustering import HarmonicClustering

DATA = Path(os.environ.get("HARMONICFACE_DATA", Path(__file__).parents[2] / "shared" / "data")) / "yaleb"
REDUCED = (48, 42)  # as is usual for the peers, which learn from raw intensities
PENALTY = 0.1  # of the largest correlation
ATOMS = 3
Table = NDArray[np.float32]
Labels = NDArray[np.int_]


def photographs(people: Sequence[int]) -> tuple[Table, Labels]:
    """Return all photographs of some people, one a row, and who is in each."""
    faces = load_yale_b(DATA, people)
    who = np.repeat([face.number for face in faces], [len(face.files) for face in faces])
    return np.concatenate([face.photographs for face in faces]).reshape(len(who), -1), who


def error(labels: Labels, who: Labels) -> float:
    """Return the percentage of photographs in a wrong group, groups given to people as suits best."""
    counts = contingency_matrix(who, labels)
    return float(100 * (1 - counts[linear_sum_assignment(-counts)].sum() / len(who)))


def reduced(table: Table) -> Table:
    """Return the photographs at the size that the peers and cones are given."""
    small = [cv2.resize(row.reshape(IMAGE_SHAPE), REDUCED[::-1], interpolation=cv2.INTER_AREA) for row in table]
    return np.stack(small).reshape(len(table), -1)


def ssc_lasso(table: Table, count: int, penalty: float = PENALTY) -> Labels:
    """Sparse subspace clustering: each photograph is a sparse combination of all others (Elhamifar & Vidal 2013)."""
    rows = unit(table).astype(np.float64)
    weights = np.zeros((len(rows), len(rows)))
    for i, row in enumerate(rows):
        others = np.arange(len(rows)) != i
        most = np.abs(rows[others] @ row).max() / len(row)
        model = Lasso(alpha=penalty * most, fit_intercept=False, max_iter=200, tol=1e-3)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)
            weights[i, others] = model.fit(rows[others].T, row).coef_
    return groups(weights, count)


def ssc_omp(table: Table, count: int, atoms: int = ATOMS) -> Labels:
    """Do the same with a few others each, found greedily (You, Robinson & Vidal 2016)."""
    rows = unit(table).astype(np.float64)
    gram = rows @ rows.T
    weights = np.zeros(gram.shape)
    for i in range(len(rows)):
        others = np.arange(len(rows)) != i
        weights[i, others] = orthogonal_mp_gram(gram[np.ix_(others, others)], gram[others, i], n_nonzero_coefs=atoms)
    return groups(weights, count)


def groups(weights: NDArray[np.float64], count: int) -> Labels:
    """Return the spectral clusters of the graph that combinations make."""
    largest = np.abs(weights).max(axis=1, keepdims=True)
    scaled = np.abs(weights) / np.where(largest > 0, largest, 1)
    graph = scaled + scaled.T
    graph += 1e-6 * graph.mean()
    return np.asarray(spectral_clustering(graph, n_clusters=count, random_state=0))


def unit(table: Table) -> Table:
    """Return rows of length 1."""
    return table / np.linalg.norm(table, axis=1, keepdims=True)


def timed(method: Callable[[], Labels], who: Labels) -> tuple[float, float, int]:
    """Return wall time, error in % and how many groups there are."""
    start = time.perf_counter()
    labels = method()
    return time.perf_counter() - start, error(labels, who), len(np.unique(labels))


def records(people: Sequence[int]) -> list[Record]:
    """Group the photographs of some people by every method, the number of people told and not."""
    table, who = photographs(people)
    small, count, shape = reduced(table), len(people), IMAGE_SHAPE
    size = f"{count} people ({min(people)}-{max(people)}), {len(who)} photographs"
    matrix = 8 * len(who) ** 2
    peers: dict[str, Callable[[], Labels]] = {
        "sparse subspace clustering, lasso": lambda: ssc_lasso(small, count),
        "sparse subspace clustering, orthogonal matching pursuit": lambda: ssc_omp(small, count),
    }
    found = {name: timed(method, who) for name, method in peers.items()}
    best = min(found, key=lambda name: found[name][1])
    ours: dict[str, tuple[HarmonicClustering, Table, str]] = {
        "patterns": (HarmonicClustering(count, "patterns", shape), table, "the default"),
        "patterns, nobody told how many": (HarmonicClustering(None, "patterns", shape), table, ""),
        "gradient": (HarmonicClustering(count, "gradient", shape), table, "people may not move"),
        "conic": (HarmonicClustering(count, "conic"), small, f"at {REDUCED[0]} x {REDUCED[1]}, raw intensities"),
    }
    result = []
    for name, (clustering, given, note) in ours.items():
        seconds, wrong, made = timed(lambda: clustering.fit_predict(given), who)  # noqa: B023
        about = f"% of photographs in a wrong group, {made} groups; {best}: {found[best][1]:.2f} %"
        text = f"{about}; {note}" if note else about
        result.append(Record(f"group by {name}", size, seconds, wrong, matrix, best, found[best][0], text))
    for name, (seconds, wrong, made) in found.items():
        text = f"% of photographs in a wrong group, {made} groups; at {REDUCED[0]} x {REDUCED[1]}"
        result.append(Record(name, size, seconds, wrong, matrix, note=text))
    return result


def choose() -> None:
    """Print how the peers do with other settings on people 1 to 5."""
    table, who = photographs(range(1, 6))
    small = reduced(table)
    for penalty in (0.3, 0.1, 0.03, 0.01, 0.003, 0.001):
        print("lasso, penalty", penalty, "error", round(error(ssc_lasso(small, 5, penalty), who), 2))
    for atoms in (2, 3, 4, 5, 8, 12):
        print("matching pursuit, atoms", atoms, "error", round(error(ssc_omp(small, 5, atoms), who), 2))


def main() -> None:
    """Print the records, and write them if asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="people 6 to 8 instead of 1 to 10, 6 to 11 and all eleven")
    parser.add_argument("--choose", action="store_true", help="only show how the peers' settings were chosen")
    parser.add_argument("--json", help="write the records here")
    options = parser.parse_args()
    if not DATA.is_dir():
        print(f"skipped: the photographs of Yale B are not in {DATA} (set HARMONICFACE_DATA)")
        return
    if options.choose:
        choose()
        return
    sets = [range(6, 9)] if options.quick else [range(1, 11), range(6, 12), range(1, 12)]
    found = [record for people in sets for record in records(people)]
    print_records(found)
    if options.json:
        write_records(options.json, found)


if __name__ == "__main__":
    main()
