"""Gathering: fewer lamps in place of very many, as fine as what looks at them can tell apart."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError

Doubles = NDArray[np.float64]
MOST_CELLS = 1 << 13  # a side of the grid: 67 million cells


def gathered(directions: ArrayLike, strengths: ArrayLike, angle: float) -> tuple[Doubles, Doubles]:
    """Return lamps with those of a small patch of the sphere put together, in the middle of their light.

    The sphere is unfolded as an octahedron to a square of even cells (Praun & Hoppe, Spherical Parametrization and
    Remeshing, 2003). What sums over the lamps with a kernel of standard deviation sigma then errs by about
    (angle / sigma)^2 / 12 at its peak, since each patch keeps its light and its centre.

    Parameters
    ----------
    directions
        (n, 3) unit vectors.
    strengths
        (n,) or (n, 3), at least 0.
    angle
        The side of a patch in radians, above 0; where patches would be more than lamps, nothing changes.

    Returns
    -------
    directions, strengths
        (m, 3) unit vectors and (m,) or (m, 3), m at most n.

    Raises
    ------
    HarmonicFaceError
        Directions that are not unit vectors, unlike counts, an angle that is not above 0.

    Examples
    --------
    >>> towards, strengths = gathered(np.tile([0.0, 0.0, 1.0], (50, 1)), np.full(50, 0.1), 0.8)
    >>> towards, strengths.round(6)
    (array([[0., 0., 1.]]), array([5.]))
    """
    towards = _validate.unit_normals(directions, "directions").astype(np.float64, copy=False)
    bright = _validate.finite(strengths, "strengths").astype(np.float64, copy=False)
    if towards.ndim != 2 or bright.shape not in ((len(towards),), (len(towards), 3)):
        raise HarmonicFaceError(
            f"strengths: expected one or three a direction, got {bright.shape} for {towards.shape[:-1]} directions"
        )
    side = min(MOST_CELLS, math.ceil(math.sqrt(4 * math.pi) / _validate.positive(angle, "angle")))
    if side**2 >= len(towards):
        return towards, bright
    column, row = (np.minimum((part * side).astype(np.int64), side - 1) for part in unfolded(towards))
    towards, bright, _ = put_together(towards, bright, np.unique(row * side + column, return_inverse=True)[1])
    return towards, bright


def put_together(directions: Floats, strengths: Floats, group: NDArray[np.int64]) -> tuple[Doubles, Doubles, Doubles]:
    """Return one lamp in place of each group that shines: in the middle of its light, with all of its strength.

    Parameters
    ----------
    directions
        (n, 3) unit vectors.
    strengths
        (n,) or (n, 3), at least 0.
    group
        (n,) numbers of the groups, from 0.

    Returns
    -------
    directions, strengths, spread
        (m, 3), (m,) or (m, 3), and (m,) the length of the mean vector: 1 where all of a group are in one direction.
    """
    columns = strengths.reshape(len(strengths), -1).astype(np.float64, copy=False)
    total = columns.sum(axis=1)
    sums = np.stack([np.bincount(group, total * axis) for axis in directions.T], axis=1)
    merged = np.stack([np.bincount(group, column) for column in columns.T], axis=1)
    length = np.linalg.norm(sums, axis=1)
    lit = length > 0
    towards, merged = sums[lit] / length[lit, None], merged[lit]
    return towards, merged.reshape(len(merged), *strengths.shape[1:]), length[lit] / merged.sum(axis=1)


def unfolded(directions: Floats) -> tuple[Doubles, Doubles]:
    """Return where directions fall on a square that an octahedron is unfolded to, both from 0 to 1."""
    x, y, z = (directions / np.abs(directions).sum(axis=-1, keepdims=True)).T.astype(np.float64)
    folded = z < 0
    u = np.where(folded, (1 - np.abs(y)) * np.copysign(1, x), x)
    v = np.where(folded, (1 - np.abs(x)) * np.copysign(1, y), y)
    return (u + 1) / 2, (v + 1) / 2
