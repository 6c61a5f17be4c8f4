"""Real orthonormal spherical harmonics of any order at unit directions."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _memory, _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics._blocks import all_harmonics, low_harmonics, scaled_low_harmonics
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
    vectors = _checked(directions)
    out = _place(out, (count(order), *vectors.shape[:-1]), vectors.dtype, order)
    flat, rows = vectors.reshape(-1, 3), out.reshape(len(out), -1)
    _share(lambda piece: _fill(flat[piece], rows[:, piece], order), rows)
    return out


def scaled_harmonics(
    directions: ArrayLike, order: int, weights: ArrayLike, factors: ArrayLike, out: Floats | None = None
) -> Floats:
    """Evaluate w_l f(x) Y_lm(x), harmonics times a weight a degree and a factor a direction.

    As `real_harmonics` and two products, but in one pass over the memory, which is what takes the time, and without its
    check of the lengths.

    Parameters
    ----------
    directions
        (n, 3) vectors that are known to be of unit length. float32 stays float32; anything else is computed in float64.
    order
        The highest degree l, at least 0.
    weights
        (order + 1,) finite numbers w_l.
    factors
        (n,) finite numbers f.
    out
        Where to write the result, as for `real_harmonics`.

    Returns
    -------
    array
        ((order + 1)^2, n), one contiguous row a harmonic.

    Raises
    ------
    HarmonicFaceError
        Arrays of another shape, weights or factors that are not finite, a negative order, an `out` that does not fit,
        a result larger than the memory.

    Examples
    --------
    >>> scaled_harmonics([[0.0, 0.0, 1.0]], 1, weights=[1.0, 0.5], factors=[10.0]).round(4).T
    array([[2.8209, 0.    , 2.443 , 0.    ]])
    """
    vectors = _checked(directions)
    if vectors.ndim != 2:
        raise HarmonicFaceError(f"directions: expected vectors of shape (n, 3), got {_validate.describe(vectors)}")
    out = _place(out, (count(order), len(vectors)), vectors.dtype, order)
    each, own = (_validate.finite(value, name) for value, name in ((weights, "weights"), (factors, "factors")))
    if each.shape != (order + 1,):
        raise HarmonicFaceError(f"weights: expected shape {(order + 1,)}, got {_validate.describe(each)}")
    if own.shape != (len(vectors),):
        raise HarmonicFaceError(f"factors: expected shape {(len(vectors),)}, got {_validate.describe(own)}")
    each, own = each.astype(vectors.dtype), own.astype(vectors.dtype, copy=False)
    _share(lambda piece: _fill_scaled(vectors[piece], out[:, piece], each, own[piece]), out)
    return out


def _checked(directions: ArrayLike) -> Floats:
    """Return vectors (..., 3); their lengths are checked later, where they are in the cache."""
    vectors = _validate.floats(directions, "directions")
    if vectors.ndim == 0 or vectors.shape[-1] != 3:
        raise HarmonicFaceError(f"directions: expected vectors of shape (..., 3), got {_validate.describe(vectors)}")
    return vectors


def _place(out: Floats | None, shape: tuple[int, ...], dtype: np.dtype[np.floating], order: int) -> Floats:
    """Return where the result goes: what was given if it fits, else a new array."""
    if out is None:
        return _memory.empty(shape, dtype, f"harmonics of order {order} at directions of shape {shape[1:]}")
    if not isinstance(out, np.ndarray) or out.shape != shape or out.dtype != dtype or not out.flags.c_contiguous:
        expected = f"a C-contiguous array of shape {shape} and type {dtype}"
        raise HarmonicFaceError(f"out: expected {expected}, got {_validate.describe(out)}")
    return out


def _share(fill: Callable[[slice], None], out: Floats) -> None:
    """Have the columns of a result filled, by more than one thread if it is large."""
    shares = 1 if out.size < THREADED_SIZE else min(THREADS, _cores())
    bounds = [out.shape[1] * share // shares for share in range(shares + 1)]
    pieces = [slice(*pair) for pair in pairwise(bounds)]
    if shares == 1:
        fill(pieces[0])
        return
    with ThreadPoolExecutor(shares) as pool:
        list(pool.map(fill, pieces))


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


def _fill_scaled(directions: Floats, out: Floats, weights: Floats, factors: Floats) -> None:
    """Write the harmonics times a weight a degree and a factor a direction, block by block."""
    order = len(weights) - 1
    size = max(1, min(len(directions), LOW_BLOCK if order <= 2 else BLOCK))
    write_low, write_all = scaled_low_harmonics(weights[:3], size), all_harmonics(order)
    for first in range(0, len(directions), size):
        some = slice(first, first + size)
        rows, block, own = out[:, some], directions[some], factors[some]
        if order <= 2:
            write_low(block, own, rows)
            continue
        write_all(block, rows)
        for degree, weight in enumerate(weights):
            several = rows[degree**2 : (degree + 1) ** 2]
            np.multiply(several, weight * own, out=several)


def _cores() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
