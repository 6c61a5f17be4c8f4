"""How fast are factors, least squares and integration? Beside scikit-learn, numpy, a pass over the data and spsolve.

python benchmarks/stereo.py [--quick] [--json FILE]
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from itertools import chain

import numpy as np
from scipy.sparse import diags_array, kron
from scipy.sparse.linalg import spsolve
from sklearn.utils.extmath import randomized_svd

from harmonicface.bench.measure import Record, best_seconds, print_records, write_records
from harmonicface.stereo.factors import leading_factors
from harmonicface.stereo.integration import integrate_normals
from harmonicface.stereo.least_squares import scaled_normals

PHOTOGRAPHS, RANK = 96, 9


def seconds_of(function: Callable[[], object]) -> float:
    """Return the time of one call."""
    start = time.perf_counter()
    function()
    return time.perf_counter() - start


def photographs(pixels: int, weakest: float) -> np.ndarray:
    """Return photographs of nine factors, the last of some strength, with noise."""
    rng = np.random.default_rng(0)
    lights = rng.uniform(0, 1, (PHOTOGRAPHS, RANK)) * np.geomspace(1, weakest, RANK)
    clean = lights @ rng.normal(size=(RANK, pixels))
    return (clean + weakest / 20 * rng.normal(size=clean.shape)).astype(np.float32)


def factors(pixels: int, quick: bool) -> Iterator[Record]:
    """Time the leading nine factors beside randomized and full singular value decomposition."""
    for weakest in (1e-1, 1e-2, 1e-3):
        matrix = photographs(pixels, weakest)
        exact = exact_singular_values(matrix)
        found = leading_factors(matrix, RANK)
        ours = best_seconds(lambda matrix=matrix: leading_factors(matrix, RANK), 3)
        sampled = randomized_svd(matrix, RANK, random_state=0)[1]
        peer = best_seconds(lambda matrix=matrix: randomized_svd(matrix, RANK, random_state=0), 1 if quick else 3)
        note = (
            f"error: of the nine singular values, the largest, relative to the first; the peer's "
            f"{np.abs(sampled - exact[:RANK]).max() / exact[0]:.1e}; the ninth is {exact[RANK - 1] / exact[0]:.1e}"
        )
        if not quick and weakest == 0.1:
            whole = seconds_of(lambda matrix=matrix: np.linalg.svd(matrix, full_matrices=False))
            note += f"; numpy.linalg.svd takes {whole:.2f} s"
        yield Record(
            name="leading nine factors of photographs",
            size=f"{PHOTOGRAPHS} x {pixels} float32",
            seconds=ours,
            error=float(np.abs(found.singular_values[:RANK] - exact[:RANK]).max() / exact[0]),
            bytes=found.right.nbytes,
            peer="sklearn randomized_svd",
            peer_seconds=peer,
            note=note,
        )


def exact_singular_values(matrix: np.ndarray) -> np.ndarray:
    """Return the singular values by orthogonal triangles in float64, block by block."""
    triangle = np.zeros((0, len(matrix)))
    for block in np.array_split(matrix, max(matrix.shape[1] // 20_000, 1), axis=1):
        triangle = np.linalg.qr(np.concatenate([triangle, block.T.astype(np.float64)]), mode="r")
    return np.linalg.svd(triangle, compute_uv=False)


def least_squares(pixels: int) -> Iterator[Record]:
    """Time albedo times normals of all pixels beside one pass over the photographs."""
    rng = np.random.default_rng(1)
    lights = rng.normal([0, 0, 1], 0.5, (PHOTOGRAPHS, 3))
    true = rng.normal([0, 0, 1], 0.4, (pixels, 3))
    matrix = (lights @ true.T).astype(np.float32)
    found = scaled_normals(matrix, lights)[0]
    yield Record(
        name="photometric stereo by least squares",
        size=f"{PHOTOGRAPHS} x {pixels} float32",
        seconds=best_seconds(lambda: scaled_normals(matrix, lights), 3),
        error=float(np.abs(found - true).max()),
        bytes=matrix.nbytes,
        peer="images.sum()",
        peer_seconds=best_seconds(lambda: matrix.sum(), 3),
        note="error: largest of albedo times normal, against the numbers that made the photographs",
    )


def integration(side: int) -> Iterator[Record]:
    """Time the depth of a square of normals beside a direct solver of the same normal equations."""
    y, x = np.mgrid[1 : -1 : side * 1j, -1 : 1 : side * 1j]
    step = 2 / (side - 1)
    depth = 0.6 * np.exp(-3 * (x**2 + 1.3 * y**2)) + 0.1 * np.sin(4 * x + 2 * y)
    slope_x = -3.6 * x * np.exp(-3 * (x**2 + 1.3 * y**2)) + 0.4 * np.cos(4 * x + 2 * y)
    slope_y = -4.68 * y * np.exp(-3 * (x**2 + 1.3 * y**2)) + 0.2 * np.cos(4 * x + 2 * y)
    normals = np.stack([-slope_x, -slope_y, np.ones_like(x)], axis=-1)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    found = integrate_normals(normals, pixel_size=step)
    direct, seconds = solved_directly(normals, step)
    exact = depth - depth.mean()
    yield Record(
        name="depth from normals",
        size=f"{side} x {side} pixels",
        seconds=best_seconds(lambda: integrate_normals(normals, pixel_size=step), 3),
        error=float(np.sqrt(np.mean((found - exact) ** 2)) / np.std(depth)),
        peer="scipy spsolve of the same system",
        peer_seconds=seconds,
        note=f"error: RMS against the depth in closed form, relative to its deviation; the peer's "
        f"{np.sqrt(np.mean((direct - exact) ** 2)) / np.std(depth):.1e}, from ours {np.abs(direct - found).max():.1e} "
        "at most",
    )


def solved_directly(normals: np.ndarray, step: float) -> tuple[np.ndarray, float]:
    """Return the depth of the same steps by elimination, and the time of that alone."""
    side = len(normals)
    right = normals[:, :-1] + normals[:, 1:]
    up = normals[1:] + normals[:-1]
    wanted = np.concatenate([(-step * right[..., 0] / right[..., 2]).ravel(), (step * up[..., 1] / up[..., 2]).ravel()])
    difference = diags_array([-np.ones(side - 1), np.ones(side - 1)], offsets=[0, 1], shape=(side - 1, side))
    identity = diags_array(np.ones(side))
    across, down = kron(identity, difference), kron(difference, identity)
    system = (across.T @ across + down.T @ down).tocsc()
    target = across.T @ wanted[: side * (side - 1)] + down.T @ wanted[side * (side - 1) :]
    system[0, 0] += 1.0
    start = time.perf_counter()
    depth = spsolve(system, target)
    seconds = time.perf_counter() - start
    return (depth - depth.mean()).reshape(side, side), seconds


def main() -> None:
    """Print the records, and write them if asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a fifth of the pixels, without numpy's decomposition")
    parser.add_argument("--json", help="write the records here")
    options = parser.parse_args()
    pixels = 50_000 if options.quick else 250_000
    found = []
    for row in chain(factors(pixels, options.quick), least_squares(pixels), integration(128 if options.quick else 512)):
        print_records([row])
        sys.stdout.flush()
        found.append(row)
    if options.json:
        write_records(options.json, found)


if __name__ == "__main__":
    main()
