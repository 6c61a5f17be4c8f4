"""Real orthonormal spherical harmonics of any order at unit directions."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _memory, _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics._blocks import all_harmonics, low_harmonics
from harmonicface.harmonics.indexing import count

LOW_BLOCK = 1 << 16  # order 2 and less: directions at once: few calls, and 6 MB of doubles that stay in the last cache
BLOCK = 1 << 13
THREADS = 4  # more of them wait for the memory
THREADED_SIZE = 1 << 20  # numbers below which starting threads costs more than it saves
LENGTH_TOLERANCE = 2e-3  # of the squared length, as in `_validate.unit_normals`


def real_harmonics(directions: ArrayLike, order: int, out: Floats | None = None) -> Floats:
    r"""Evaluate the real harmonics Y_lm, orthonormal over the sphere and without the Condon-Shortley phase.

    .. math:: Y_{lm} = N_{l|m|} P_l^{|m|}(\cos\theta) \sqrt{2} \{\cos m\phi, \; \sin|m|\phi\}

    with the cosine for m > 0, the sine for m < 0 and neither (nor the root) for m = 0. In order 2 that is 1, y, z,
    x, xy, yz, 3z^2 - 1, xz, x^2 - y^2 times 0.282095, 0.488603, 1.092548 or 0.315392, 0.546274 (Ramamoorthi &
    Hanrahan, An Efficient Representation for Irradiance Environment Maps, 2001, equation 3). Large inputs are
    shared among up to four threads.

    Parameters
    ----------
    directions
        (..., 3) unit vectors. float32 stays float32; anything else is computed in float64.
    order
        The highest degree l, at least 0.
    out
        Where to write the result: C-contiguous, of the result's shape and type. Made if not given. After an error
        its values mean nothing.

    Returns
    -------
    array
        ((order + 1)^2, ...) values, coefficient-major: one contiguous row a harmonic, (l, m) at l * (l + 1) + m.

    Raises
    ------
    HarmonicFaceError
        Directions that are not finite unit vectors (to 1e-3), a negative order, an `out` that does not fit, a
        result larger than the memory.

    Examples
    --------
    >>> real_harmonics([0.0, 0.0, 1.0], order=1).round(6)
    array([0.282095, 0.      , 0.488603, 0.      ])
    """
    vectors = _validate.floats(directions, "directions")
    if vectors.ndim == 0 or vectors.shape[-1] != 3:
        raise HarmonicFaceError(f"directions: expected vectors of shape (..., 3), got {_validate.describe(vectors)}")
    out = _place(out, (count(order), *vectors.shape[:-1]), vectors.dtype, order)
    flat, rows = vectors.reshape(-1, 3), out.reshape(len(out), -1)
    shares = 1 if rows.size < THREADED_SIZE else min(THREADS, _cores())
    if shares == 1:
        _fill(flat, rows, order)
    else:
        bounds = [len(flat) * share // shares for share in range(shares + 1)]
        pieces = [slice(*pair) for pair in pairwise(bounds)]
        with ThreadPoolExecutor(shares) as pool:
            list(pool.map(lambda piece: _fill(flat[piece], rows[:, piece], order), pieces))
    return out


def _place(out: Floats | None, shape: tuple[int, ...], dtype: np.dtype[np.floating], order: int) -> Floats:
    """Return where the result goes: what was given if it fits, else a new array."""
    if out is None:
        return _memory.empty(shape, dtype, f"harmonics of order {order} at directions of shape {shape[1:]}")
    if not isinstance(out, np.ndarray) or out.shape != shape or out.dtype != dtype or not out.flags.c_contiguous:
        expected = f"a C-contiguous array of shape {shape} and type {dtype}"
        raise HarmonicFaceError(f"out: expected {expected}, got {_validate.describe(out)}")
    return out


def _fill(directions: Floats, out: Floats, order: int) -> None:
    """Write the harmonics block by block; lengths are checked where the block is in the cache anyway."""
    size = max(1, min(len(directions), LOW_BLOCK if order <= 2 else BLOCK))
    write = low_harmonics(order, size, directions.dtype) if order <= 2 else all_harmonics(order)
    with np.errstate(over="ignore", invalid="ignore"):  # what these would tell is told by the lengths
        for first in range(0, len(directions), size):
            block = directions[first : first + size]
            least, largest = write(block, out[:, first : first + size])
            if not (least >= 1 - LENGTH_TOLERANCE and largest <= 1 + LENGTH_TOLERANCE):
                _validate.unit_normals(block, "directions")


def _cores() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
