"""Exact sums over many directions, of clamped cosines or of any lobe, in blocks that fit the cache."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from harmonicface._validate import Floats

BLOCK = 1 << 16  # cosines held at once: 0.25 to 0.5 MB, which a second-level cache holds beside as many zeros


def sum_clamped_cosine(normals: Floats, directions: Floats, strengths: Floats) -> Floats:
    r"""Return E(n) = \sum_i s_i max(n.w_i, 0), (...) or (..., 3), in the type of the normals."""
    zeros = np.zeros(BLOCK, normals.dtype)  # numpy compares with an array three times as fast as with a number

    def clamped(cosines: Floats) -> Floats:
        return np.maximum(cosines, zeros[: cosines.size].reshape(cosines.shape), out=cosines)

    return sum_lobe(normals, directions, strengths, clamped)


def sum_lobe(normals: Floats, directions: Floats, strengths: Floats, lobe: Callable[[Floats], Floats]) -> Floats:
    r"""Return \sum_i s_i lobe(n.w_i), (...) or (..., 3), in the type of the normals.

    The products are formed in that type, the sums over blocks in float64. Memory: one block of cosines, which the
    lobe may overwrite.
    """
    flat = np.ascontiguousarray(normals.reshape(-1, 3))
    towards = np.ascontiguousarray(directions.T, dtype=flat.dtype)  # (3, n)
    weights = np.ascontiguousarray(strengths, dtype=flat.dtype)
    total = np.zeros((len(flat), *strengths.shape[1:]))
    rows = max(1, min(len(flat), 256, BLOCK))
    columns = max(1, min(len(directions), BLOCK // rows))
    cosines = np.empty(rows * columns, flat.dtype)
    for first in range(0, len(flat), rows):
        block = flat[first : first + rows]
        for start in range(0, len(directions), columns):
            some = towards[:, start : start + columns]
            here = cosines[: len(block) * some.shape[1]].reshape(len(block), -1)
            total[first : first + rows] += lobe(np.matmul(block, some, out=here)) @ weights[start : start + columns]
    return total.reshape(normals.shape[:-1] + strengths.shape[1:]).astype(normals.dtype, copy=False)
