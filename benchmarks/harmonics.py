"""How fast and how exact are harmonics, their projection and their rotation? Beside sphericart, scipy and a copy.

python benchmarks/harmonics.py [--quick] [--json FILE]
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from unittest import mock

import numpy as np
import sphericart
from scipy.spatial.transform import Rotation
from scipy.special import sph_harm_y_all
from threadpoolctl import threadpool_limits

from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.measure import Record
from harmonicface.bench.timing import Call, in_turn, once, record
from harmonicface.harmonics import basis
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.conventions import to_scipy
from harmonicface.harmonics.grid import harmonics_on_grid, sphere_grid
from harmonicface.harmonics.indexing import count
from harmonicface.harmonics.quadrature import project, synthesize
from harmonicface.harmonics.rotation import rotate, rotation_blocks

ORDER = 64
ROUNDS = 3  # of both in turn
BETWEEN = "difference between both, the largest"
HALF_TURNS = [np.diag([1.0, -1.0, -1.0]), np.diag([-1.0, 1.0, -1.0]), np.diag([-1.0, -1.0, 1.0])]


def nine_harmonics(normals: int, repeats: int) -> list[Record]:
    """Time the nine harmonics of many normals."""
    directions, each = random_directions(normals), max(2, repeats // 3)
    theirs = sphericart.SphericalHarmonics(2)
    expected = theirs.compute(directions).T
    out = np.empty((9, normals))
    size = f"{normals:.0e} normals float64"
    records = []
    for threads, note in ((basis.THREADS, "both with all their threads"), (1, "both with one thread")):
        with mock.patch.object(basis, "THREADS", threads), threadpool_limits(threads if threads == 1 else None):
            peer = sphericart.SphericalHarmonics(2)
            timings = in_turn(
                partial(real_harmonics, directions, 2, out=out), Call(partial(peer.compute, directions)), ROUNDS, each
            )
        records.append(
            record(
                "nine harmonics",
                size,
                *timings,
                error=float(np.abs(out - expected).max()),
                unit=BETWEEN,
                bytes=out.nbytes,
                note=f"{note}; ours checks the normals and writes into out=",
            )
        )
    single = directions.astype(np.float32)
    result, source = np.empty((9, normals), np.float32), np.ones((9, normals), np.float32)
    target = np.empty_like(source)
    copy = Call(partial(np.copyto, target, source), about="of the output's bytes")
    records.append(
        record(
            "nine harmonics",
            f"{normals:.0e} normals float32",
            *in_turn(partial(real_harmonics, single, 2, out=result), copy, ROUNDS, each),
            error=float(np.abs(result - expected).max()),
            unit="from float64, the largest",
            bytes=result.nbytes,
            note="coefficient-major, checks included, out= on both sides",
        )
    )
    return records


def exactness(directions: int, repeats: int) -> list[Record]:
    """Evaluate at order 64: equal to scipy, orthonormal by quadrature."""
    towards = random_directions(directions)
    polar, azimuth = np.arccos(towards[:, 2]), np.arctan2(towards[:, 1], towards[:, 0])
    each = max(2, repeats // 3)
    scipys = Call(partial(sph_harm_y_all, ORDER, ORDER, polar, azimuth), about="complex")
    high = in_turn(partial(real_harmonics, towards, ORDER), scipys, ROUNDS, each)
    coefficients = np.random.default_rng(1).normal(size=count(ORDER))
    coefficients /= np.linalg.norm(coefficients)
    theirs = np.tensordot(to_scipy(coefficients), sph_harm_y_all(ORDER, ORDER, polar, azimuth), ([0, 1], [0, 1]))
    scipy_error = np.abs(coefficients @ real_harmonics(towards, ORDER) - theirs).max()
    grid = sphere_grid(ORDER)
    at_directions = Call(partial(real_harmonics, grid.directions, ORDER), about="at its directions")
    on_grid = in_turn(partial(harmonics_on_grid, grid, ORDER), at_directions, ROUNDS, max(2, repeats // 9))
    weighted = (harmonics_on_grid(grid, ORDER) * np.sqrt(grid.row_weights)[:, None]).reshape(count(ORDER), -1)
    gram_error = np.abs(weighted @ weighted.T - np.eye(count(ORDER))).max()
    many = random_directions(100 * directions)
    eighth = sphericart.SphericalHarmonics(8)
    out = np.empty((count(8), len(many)))
    theirs = Call(partial(eighth.compute, many))
    eight = in_turn(partial(real_harmonics, many, 8, out=out), theirs, ROUNDS, repeats)
    return [
        record(
            "harmonics of order 8",
            f"{len(many)} directions",
            *eight,
            error=float(np.abs(out - eighth.compute(many).T).max()),
            unit=BETWEEN,
            note="both with all their threads",
        ),
        record(
            "harmonics of order 64",
            f"{directions} directions",
            *high,
            error=float(scipy_error),
            unit=BETWEEN,
            seed=1,
            note="of a random unit function",
        ),
        record(
            "harmonics of order 64 on a grid",
            f"{grid.shape[0]} x {grid.shape[1]}",
            *on_grid,
            error=float(gram_error),
            unit="of orthonormality by quadrature, the largest",
            bytes=weighted.nbytes,
            note="of 4225 x 4225",
        ),
    ]


def projection(order: int, repeats: int) -> Record:
    """Project samples onto harmonics and compare with where they came from."""
    grid = sphere_grid(order)
    coefficients = np.random.default_rng(2).normal(size=count(order))
    samples = synthesize(coefficients, grid)
    weighted = grid.weights * samples.ravel()
    harmonics = real_harmonics(grid.directions, order)
    product = Call(partial(np.dot, harmonics, weighted), about="with harmonics made before")
    return record(
        "projection by quadrature",
        f"order {order}, {grid.shape[0]} x {grid.shape[1]} samples",
        *in_turn(partial(project, samples, order, grid), product, ROUNDS, max(2, repeats // 3)),
        error=float(np.abs(project(samples, order, grid) - coefficients).max()),
        unit="of a round trip, the largest",
        bytes=harmonics.nbytes,
        seed=2,
        note="bytes: what the product keeps and the projection does not",
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
    timings = [once(partial(rotate, coefficients, generic))[0]]
    if order <= ORDER:  # beyond, sampling takes minutes
        grid = sphere_grid(order)
        rotated_grid = generic.inv().apply(grid.directions)
        sampled = Call(
            lambda: project(_evaluate(coefficients, rotated_grid, order), order, grid),
            project,
            about="of the function at rotated directions",
        )
        timings = list(in_turn(partial(rotate, coefficients, generic), sampled, ROUNDS, max(2, repeats // 3)))
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
        record(
            "rotation of coefficients",
            f"order {order}",
            *timings,
            error=float(np.abs(turned @ real_harmonics(towards, order) - expected).max()),
            unit="from evaluation at rotated directions, the largest",
            seed=3,
            note="of a random unit function",
        ),
        record(
            "rotation matrices",
            f"order {order}",
            once(partial(rotation_blocks, generic, order))[0],
            error=max(float(orthogonality), composition),
            unit="of orthogonality or composition, the largest",
            bytes=kept,
            seed=3,
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


def records(quick: bool) -> Iterator[Record]:
    """Yield harmonics, projection, rotation."""
    repeats = 30 if quick else 60
    yield from nine_harmonics(10**6, repeats)
    yield from exactness(1000, 3 if quick else 9)
    yield projection(ORDER, repeats)
    yield from rotation(ORDER, 5)
    if not quick:
        yield from rotation(200, 1)


if __name__ == "__main__":
    run_benchmark(__doc__, records, "fewer repetitions, rotations up to order 64 only", seed=0)
