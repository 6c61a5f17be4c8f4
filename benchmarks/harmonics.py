"""How fast and how exact are harmonics, their projection and their rotation? Beside sphericart, scipy and a copy.

python benchmarks/harmonics.py [--quick] [--json FILE]
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from timeit import Timer
from unittest import mock

import numpy as np
import sphericart
from scipy.spatial.transform import Rotation
from scipy.special import sph_harm_y_all
from threadpoolctl import threadpool_limits

from harmonicface.bench.measure import Record, print_records, write_records
from harmonicface.harmonics import basis
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.conventions import to_scipy
from harmonicface.harmonics.grid import harmonics_on_grid, sphere_grid
from harmonicface.harmonics.indexing import count
from harmonicface.harmonics.quadrature import project, synthesize
from harmonicface.harmonics.rotation import rotate, rotation_blocks

ORDER = 64
HALF_TURNS = [np.diag([1.0, -1.0, -1.0]), np.diag([-1.0, 1.0, -1.0]), np.diag([-1.0, -1.0, 1.0])]


def paired_seconds(ours: Callable[[], object], peer: Callable[[], object], repeats: int) -> tuple[float, float]:
    """Return the best times of both, in three rounds, so that what else the machine does falls on both.

    Several calls of one before the other has its turn: OpenMP's threads spin for a while after their work.
    """
    best = [np.inf, np.inf]
    for _ in range(3):
        for side, function in enumerate((ours, peer)):
            function()
            best[side] = min(best[side], *(_seconds(function) for _ in range(max(2, repeats // 3))))
    return best[0], best[1]


def nine_harmonics(normals: int, repeats: int) -> list[Record]:
    """Time the nine harmonics of many normals."""
    directions = random_directions(normals)
    theirs = sphericart.SphericalHarmonics(2)
    expected = theirs.compute(directions).T
    out = np.empty((9, normals))
    size = f"{normals:.0e} normals float64"
    records = []
    for threads, note in ((basis.THREADS, "both with all their threads"), (1, "both with one thread")):
        with mock.patch.object(basis, "THREADS", threads), threadpool_limits(threads if threads == 1 else None):
            peer = sphericart.SphericalHarmonics(2)
            seconds, peer_seconds = paired_seconds(
                lambda: real_harmonics(directions, 2, out=out), lambda peer=peer: peer.compute(directions), repeats
            )
        records.append(
            Record(
                name="nine harmonics",
                size=size,
                seconds=seconds,
                error=float(np.abs(out - expected).max()),
                bytes=out.nbytes,
                peer="sphericart compute",
                peer_seconds=peer_seconds,
                note=f"{note}; ours checks the normals and writes into out=; error: largest difference between both",
            )
        )
    single = directions.astype(np.float32)
    result, source = np.empty((9, normals), np.float32), np.ones((9, normals), np.float32)
    target = np.empty_like(source)
    seconds, peer_seconds = paired_seconds(
        lambda: real_harmonics(single, 2, out=result), lambda: np.copyto(target, source), repeats
    )
    records.append(
        Record(
            name="nine harmonics",
            size=f"{normals:.0e} normals float32",
            seconds=seconds,
            error=float(np.abs(result - expected).max()),
            bytes=result.nbytes,
            peer="np.copyto of the output's bytes",
            peer_seconds=peer_seconds,
            note="coefficient-major, checks included, out= on both sides; error: largest, against float64",
        )
    )
    return records


def exactness(directions: int, repeats: int) -> list[Record]:
    """Evaluate at order 64: equal to scipy, orthonormal by quadrature."""
    towards = random_directions(directions)
    polar, azimuth = np.arccos(towards[:, 2]), np.arctan2(towards[:, 1], towards[:, 0])
    seconds, peer_seconds = paired_seconds(
        lambda: real_harmonics(towards, ORDER), lambda: sph_harm_y_all(ORDER, ORDER, polar, azimuth), repeats
    )
    coefficients = np.random.default_rng(1).normal(size=count(ORDER))
    coefficients /= np.linalg.norm(coefficients)
    theirs = np.tensordot(to_scipy(coefficients), sph_harm_y_all(ORDER, ORDER, polar, azimuth), ([0, 1], [0, 1]))
    scipy_error = np.abs(coefficients @ real_harmonics(towards, ORDER) - theirs).max()
    grid = sphere_grid(ORDER)
    on_grid, at_directions = paired_seconds(
        lambda: harmonics_on_grid(grid, ORDER), lambda: real_harmonics(grid.directions, ORDER), max(1, repeats // 3)
    )
    weighted = (harmonics_on_grid(grid, ORDER) * np.sqrt(grid.row_weights)[:, None]).reshape(count(ORDER), -1)
    gram_error = np.abs(weighted @ weighted.T - np.eye(count(ORDER))).max()
    many = random_directions(100 * directions)
    eighth = sphericart.SphericalHarmonics(8)
    out = np.empty((count(8), len(many)))
    eight, eight_peer = paired_seconds(
        lambda: real_harmonics(many, 8, out=out), lambda: eighth.compute(many), 3 * repeats
    )
    return [
        Record(
            name="harmonics of order 8",
            size=f"{len(many)} directions",
            seconds=eight,
            error=float(np.abs(out - eighth.compute(many).T).max()),
            peer="sphericart compute",
            peer_seconds=eight_peer,
            note="both with all their threads; error: largest difference between both",
        ),
        Record(
            name="harmonics of order 64",
            size=f"{directions} directions",
            seconds=seconds,
            error=float(scipy_error),
            peer="scipy sph_harm_y_all (complex)",
            peer_seconds=peer_seconds,
            note="error: of a random unit function, largest difference between both",
        ),
        Record(
            name="harmonics of order 64 on a grid",
            size=f"{grid.shape[0]} x {grid.shape[1]}",
            seconds=on_grid,
            error=float(gram_error),
            bytes=weighted.nbytes,
            peer="real_harmonics at its directions",
            peer_seconds=at_directions,
            note="error: of orthonormality by quadrature, largest of 4225 x 4225",
        ),
    ]


def projection(order: int, repeats: int) -> Record:
    """Project samples onto harmonics and compare with where they came from."""
    grid = sphere_grid(order)
    coefficients = np.random.default_rng(2).normal(size=count(order))
    samples = synthesize(coefficients, grid)
    weighted = grid.weights * samples.ravel()
    harmonics = real_harmonics(grid.directions, order)
    seconds, peer_seconds = paired_seconds(lambda: project(samples, order, grid), lambda: harmonics @ weighted, repeats)
    return Record(
        name="projection by quadrature",
        size=f"order {order}, {grid.shape[0]} x {grid.shape[1]} samples",
        seconds=seconds,
        error=float(np.abs(project(samples, order, grid) - coefficients).max()),
        bytes=harmonics.nbytes,
        peer="numpy product with harmonics made before",
        peer_seconds=peer_seconds,
        note="error: largest of a round trip; bytes: what the product keeps and the projection does not",
    )


def rotation(order: int, repeats: int) -> list[Record]:
    """Rotate coefficients, beside sampling the rotated function; orthogonality and composition at awkward angles."""
    rng = np.random.default_rng(3)
    generic, other = Rotation.random(rng=rng), Rotation.random(rng=rng)
    coefficients = rng.normal(size=count(order))
    coefficients /= np.linalg.norm(coefficients)
    towards = random_directions(50)
    turned = rotate(coefficients, generic)
    expected = coefficients @ real_harmonics(generic.inv().apply(towards), order)
    seconds, peer_seconds = _seconds(lambda: rotate(coefficients, generic)), None
    if order <= ORDER:  # beyond, sampling takes minutes
        grid = sphere_grid(order)
        rotated_grid = generic.inv().apply(grid.directions)
        seconds, peer_seconds = paired_seconds(
            lambda: rotate(coefficients, generic),
            lambda: project(_evaluate(coefficients, rotated_grid, order), order, grid),
            repeats,
        )
    named = [generic, other, Rotation.identity(), Rotation.from_rotvec([1e-9, -2e-9, 0.7])]
    all_rotations = named + [Rotation.from_matrix(matrix) for matrix in HALF_TURNS]
    blocks = [rotation_blocks(each, order) for each in all_rotations]
    orthogonality = max(np.abs(m @ m.T - np.eye(len(m))).max() for one in blocks for m in one)
    composition = 0.0
    for left in (0, 3, 4):
        for right in (1, 5, 6):
            both = rotation_blocks(all_rotations[left] * all_rotations[right], order)
            for first, second, product in zip(blocks[left], blocks[right], both, strict=True):
                composition = max(composition, float(np.abs(first @ second - product).max()))
    kept = sum(matrix.nbytes for matrix in blocks[0])
    return [
        Record(
            name="rotation of coefficients",
            size=f"order {order}",
            seconds=seconds,
            error=float(np.abs(turned @ real_harmonics(towards, order) - expected).max()),
            peer="projection of the function at rotated directions" if peer_seconds else None,
            peer_seconds=peer_seconds,
            note="error: against evaluation at rotated directions, of a random unit function",
        ),
        Record(
            name="rotation matrices",
            size=f"order {order}",
            seconds=_seconds(lambda: rotation_blocks(generic, order)),
            error=max(float(orthogonality), composition),
            bytes=kept,
            note=f"orthogonality {orthogonality:.1e}, composition {composition:.1e}; also at poles and half turns",
        ),
    ]


def random_directions(number: int) -> np.ndarray:
    """Return uniform unit vectors."""
    vectors = np.random.default_rng(0).normal(size=(number, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _evaluate(coefficients: np.ndarray, directions: np.ndarray, order: int) -> np.ndarray:
    """Evaluate a function at directions in slices, so that the harmonics need little memory."""
    slices = (slice(first, first + 1000) for first in range(0, len(directions), 1000))
    return np.concatenate([coefficients @ real_harmonics(directions[some], order) for some in slices])


def _seconds(function: Callable[[], object]) -> float:
    """Time one call."""
    return Timer(function).timeit(1)


def main() -> None:
    """Print the records, and write them if asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer repetitions, rotations up to order 64 only")
    parser.add_argument("--json", help="write the records here")
    options = parser.parse_args()
    repeats = 30 if options.quick else 60
    found = nine_harmonics(10**6, repeats) + exactness(1000, 3 if options.quick else 9)
    found += [projection(ORDER, repeats), *rotation(ORDER, 5)]
    if not options.quick:
        found += rotation(200, 1)
    print_records(found)
    if options.json:
        write_records(options.json, found)


if __name__ == "__main__":
    main()
