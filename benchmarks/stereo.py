"""How fast are factors, least squares and integration? Beside scikit-learn, numpy, a pass over the data and spsolve.

python benchmarks/stereo.py [--quick] [--json FILE]
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np
from scipy.sparse import diags_array, kron
from scipy.sparse.linalg import spsolve
from sklearn.utils.extmath import randomized_svd

from harmonicface.bench.command_line import run_benchmark
from harmonicface.bench.measure import Record
from harmonicface.bench.timing import Call, Timing, best, once, record
from harmonicface.stereo.depth.integration import integrate_normals
from harmonicface.stereo.factors import leading_factors
from harmonicface.stereo.known.least_squares import plain_least_squares

PHOTOGRAPHS, RANK = 96, 9


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
        sampled = randomized_svd(matrix, RANK, random_state=0)[1]
        peer = best(Call(partial(randomized_svd, matrix, RANK, random_state=0)), 1 if quick else 3)
        note = f"the ninth is {exact[RANK - 1] / exact[0]:.1e}"
        if not quick and weakest == 0.1:
            whole = once(Call(partial(np.linalg.svd, matrix, full_matrices=False)))[0]
            note += f"; {whole.name} takes {whole.seconds:.2f} s"
        yield record(
            f"leading nine factors of photographs, the weakest {weakest:g}",
            f"{PHOTOGRAPHS} x {pixels} float32",
            best(partial(leading_factors, matrix, RANK), 3),
            peer,
            error=float(np.abs(found.singular_values[:RANK] - exact[:RANK]).max() / exact[0]),
            peer_error=float(np.abs(sampled - exact[:RANK]).max() / exact[0]),
            unit="of nine singular values, the largest, relative to the first",
            bytes=found.right.nbytes,
            seed=0,
            question="leading nine factors of photographs",
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
    found = plain_least_squares(matrix, lights)
    yield record(
        "photometric stereo by least squares",
        f"{PHOTOGRAPHS} x {pixels} float32",
        best(partial(plain_least_squares, matrix, lights), 10),
        best(Call(matrix.sum, about="of the photographs"), 10),
        error=float(np.abs(found - true).max()),
        unit="of albedo times normal, the largest",
        bytes=matrix.nbytes,
        seed=1,
        note="against the numbers that made the photographs",
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
    direct, peer = solved_directly(normals, step)
    exact = depth - depth.mean()
    yield record(
        "depth from normals",
        f"{side} x {side} pixels",
        best(partial(integrate_normals, normals, pixel_size=step), 3),
        peer,
        error=float(np.sqrt(np.mean((found - exact) ** 2)) / np.std(depth)),
        peer_error=float(np.sqrt(np.mean((direct - exact) ** 2)) / np.std(depth)),
        unit="RMS from the closed form, over its deviation",
        question="depth from normals",
        note=f"from the peer's {np.abs(direct - found).max():.1e} at most",
    )


def solved_directly(normals: np.ndarray, step: float) -> tuple[np.ndarray, Timing]:
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
    timing, depth = once(Call(partial(spsolve, system, target), about="of the same system"))
    return (depth - depth.mean()).reshape(side, side), timing


def records(quick: bool) -> Iterator[Record]:
    """Ask each question in turn."""
    pixels = 50_000 if quick else 250_000
    yield from factors(pixels, quick)
    yield from least_squares(pixels)
    yield from integration(128 if quick else 512)


if __name__ == "__main__":
    run_benchmark(__doc__, records, "a fifth of the pixels, without numpy's decomposition")
