"""The exact sum of clamped cosines over many directions, in blocks that fit the cache."""

from __future__ import annotations

import numpy as np

from harmonicface._validate import Floats

BLOCK = 1 << 16  # cosines held at once: 0.25 to 0.5 MB, which a second-level cache holds beside as many zeros


def sum_clamped_cosine(normals: Floats, directions: Floats, strengths: Floats) -> Floats:
    r"""Return E(n) = \sum_i s_i max(n.w_i, 0), (...) or (..., 3), in the type of the normals.

    The products are formed in that type, the sums over blocks in float64. Memory: one block of cosines.
    """
    flat = np.ascontiguousarray(normals.reshape(-1, 3))
    towards = np.ascontiguousarray(directions.T, dtype=flat.dtype)  # (3, n)
    weights = np.ascontiguousarray(strengths, dtype=flat.dtype)
    total = np.zeros((len(flat), *strengths.shape[1:]))
    rows = max(1, min(len(flat), 256))
    columns = max(1, min(len(directions), BLOCK // rows))
    cosines = np.empty((rows, columns), flat.dtype)
    zeros = np.zeros_like(cosines)  # numpy compares with an array three times as fast as with a number
    for first in range(0, len(flat), rows):
        block = slice(first, first + rows)
        for start in range(0, len(directions), columns):
            some = slice(start, start + columns)
            here = cosines[: len(flat[block]), : towards[:, some].shape[1]]
            np.matmul(flat[block], towards[:, some], out=here)
            np.maximum(here, zeros[: here.shape[0], : here.shape[1]], out=here)
            total[block] += here @ weights[some]
    return total.reshape(normals.shape[:-1] + strengths.shape[1:]).astype(normals.dtype, copy=False)
