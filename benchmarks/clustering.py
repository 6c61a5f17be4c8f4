"""Whose photographs are these? Groups of Yale B under all lights, beside sparse subspace clustering; error beside time.

Settings of all methods, the peers' too, were chosen on people 1 to 5 (`--choose` shows the peers' trials).

python benchmarks/clustering.py [--quick] [--choose] [--json FILE]
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from sklearn.cluster import spectral_clustering
from sklearn.exceptions import ConvergenceWarning
from sklearn.linear_model import Lasso, orthogonal_mp_gram
from sklearn.metrics.cluster import contingency_matrix

from harmonicface.bench.command_line import benchmark_parser, finish, there
from harmonicface.bench.measure import Record
from harmonicface.bench.timing import Call, once, record
from harmonicface.datasets.yale_b import IMAGE_SHAPE, load_yale_b
from harmonicface.recognition.clustering import HarmonicClustering

DATA = Path(os.environ.get("HARMONICFACE_DATA", Path(__file__).parents[2] / "shared" / "data")) / "yaleb"
REDUCED = (48, 42)  # as is usual for the peers, which learn from raw intensities
PENALTY = 0.1  # of the largest correlation
ATOMS = 3
UNIT = "% of photographs in a wrong group"
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


def records(people: Sequence[int]) -> Iterator[Record]:
    """Group the photographs of some people by every method, the number of people told and not."""
    table, who = photographs(people)
    small, count, shape = reduced(table), len(people), IMAGE_SHAPE
    size = f"{count} people ({min(people)}-{max(people)}), {len(who)} photographs"
    matrix = 8 * len(who) ** 2
    about = "sparse subspace clustering"
    peers = {
        f"{about}, lasso": Call(partial(ssc_lasso, small, count), Lasso.fit, spectral_clustering, about=about),
        f"{about}, matching pursuit": Call(
            partial(ssc_omp, small, count), orthogonal_mp_gram, spectral_clustering, about=about
        ),
    }
    found = {name: once(method) for name, method in peers.items()}
    wrong = {name: error(labels, who) for name, (_, labels) in found.items()}
    best = min(wrong, key=lambda name: wrong[name])
    ours: dict[str, tuple[HarmonicClustering, Table, str]] = {
        "patterns": (HarmonicClustering(count, "patterns", shape), table, "the default"),
        "patterns, nobody told how many": (HarmonicClustering(None, "patterns", shape), table, ""),
        "gradient": (HarmonicClustering(count, "gradient", shape), table, "people may not move"),
        "conic": (HarmonicClustering(count, "conic"), small, f"at {REDUCED[0]} x {REDUCED[1]}, raw intensities"),
    }
    for name, (clustering, given, note) in ours.items():
        timing, labels = once(partial(clustering.fit_predict, given))
        text = f"{len(np.unique(labels))} groups" + (f"; {note}" if note else "")
        yield record(
            f"group by {name}",
            size,
            timing,
            found[best][0],
            error=error(labels, who),
            peer_error=wrong[best],
            unit=UNIT,
            bytes=matrix,
            question=f"groups of {size}",
            note=text,
        )
    for name, (timing, labels) in found.items():
        text = f"a peer: {len(np.unique(labels))} groups; at {REDUCED[0]} x {REDUCED[1]}"
        yield record(name, size, timing, error=wrong[name], unit=UNIT, bytes=matrix, note=text)


def choose() -> None:
    """Print how the peers do with other settings on people 1 to 5."""
    table, who = photographs(range(1, 6))
    small = reduced(table)
    for penalty in (0.3, 0.1, 0.03, 0.01, 0.003, 0.001):
        print("lasso, penalty", penalty, "error", round(error(ssc_lasso(small, 5, penalty), who), 2))
    for atoms in (2, 3, 4, 5, 8, 12):
        print("matching pursuit, atoms", atoms, "error", round(error(ssc_omp(small, 5, atoms), who), 2))


def main() -> None:
    """Run, or show how the peers' settings were chosen."""
    parser = benchmark_parser(__doc__, "people 6 to 8 instead of 1 to 10, 6 to 11 and all eleven")
    parser.add_argument("--choose", action="store_true", help="only show how the peers' settings were chosen")
    options = parser.parse_args()
    if not there(DATA):
        return
    if options.choose:
        choose()
        return
    sets = [range(6, 9)] if options.quick else [range(1, 11), range(6, 12), range(1, 12)]
    finish((one for people in sets for one in records(people)), options.json, seed=0)


if __name__ == "__main__":
    main()
