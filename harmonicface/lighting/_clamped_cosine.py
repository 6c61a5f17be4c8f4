"""The exact sum of clamped cosines over many directions, in blocks that fit the cache."""

from __future__ import annotations

import numpy as np

from harmonicface._validate import Floats

BLOCK = 1 << 17  # cosines held at once: 0.5 to 1 MB, the size of a second-level cache


def sum_clamped_cosine(normals: Floats, directions: Floats, strengths: Floats) -> Floats:
    r"""Return E(n) = \sum_i s_i max(n.w_i, 0), (...) or (..., 3), in the type of the normals.

    The products are formed in that type, the sums over blocks in float64. Memory: one block of cosines.
    """
    flat = np.ascontiguousarray(normals.reshape(-1, 3))
    towards = np.ascontiguousarray(directions.T, dtype=flat.dtype)  # (3, n)
    weights = np.ascontiguousarray(strengths, dtype=flat.dtype)
    total = np.zeros((len(flat), *strengths.shape[1:]))
    rows = max(1, min(len(flat), 256))
    columns = max(1, BLOCK // rows)
    for first in range(0, len(flat), rows):
        block = slice(first, first + rows)
        for start in range(0, len(directions), columns):
            some = slice(start, start + columns)
            cosines = flat[block] @ towards[:, some]
            np.maximum(cosines, 0, out=cosines)
            total[block] += cosines @ weights[some]
    return total.reshape(normals.shape[:-1] + strengths.shape[1:]).astype(normals.dtype, copy=False)
