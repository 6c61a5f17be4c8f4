"""Silhouette: the shape that a mask alone suggests, a balloon, as a start under unknown light."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.linalg import spsolve

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]


def balloon_depth(mask: Mask) -> Doubles:
    r"""Return the depth in pixels of a balloon with the outline of a mask, 0 outside.

    .. math:: -\Delta u = 4 \text{ inside}, \quad u = 0 \text{ outside}, \quad z = \sqrt u

    which is a hemisphere for a disc (u = r^2 - x^2 - y^2), and a smooth pillow for any other outline.

    Parameters
    ----------
    mask
        (h, w) booleans; the border of the picture is outline too.

    Examples
    --------
    >>> y, x = np.mgrid[-20:21, -20:21]
    >>> float(balloon_depth(x**2 + y**2 < 20**2).max().round())
    20.0
    """
    wide = np.pad(mask, 1)
    number = np.where(wide, np.cumsum(wide).reshape(wide.shape) - 1, -1)
    count = int(wide.sum())
    rows, columns = [], []
    for step, axis in ((1, 0), (-1, 0), (1, 1), (-1, 1)):
        other = np.roll(number, step, axis)[wide]
        rows.append(np.flatnonzero(other >= 0))
        columns.append(other[other >= 0])
    diagonal = np.arange(count)
    values = np.concatenate([-np.ones(sum(map(len, rows))), np.full(count, 4.0)])
    places = np.concatenate([*rows, diagonal]), np.concatenate([*columns, diagonal])
    matrix = csr_array((values, places), (count, count))
    depth = np.zeros(mask.shape)
    depth[mask] = np.sqrt(np.maximum(spsolve(matrix.tocsc(), np.full(count, 4.0)), 0))
    return depth


def balloon_normals(mask: Mask) -> Doubles:
    """Return the unit normals of the balloon at the masked pixels, (p, 3)."""
    depth = np.pad(balloon_depth(mask), 1)
    right, down = (depth[1:-1, 2:] - depth[1:-1, :-2]) / 2, (depth[2:, 1:-1] - depth[:-2, 1:-1]) / 2
    normals = np.stack([-right, down, np.ones_like(right)], axis=-1)[mask]
    return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))
