"""How complex harmonics of one degree mix under rotation: the matrices d^l and D^l of any degree."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _memory, _validate
from harmonicface.errors import HarmonicFaceError

LARGEST_DEGREE = 1024  # beyond, the corner 2^-l of d^l(pi/2), which the recursion starts from, leaves the doubles
CACHED_DEGREE = 128  # quarter turns are kept up to here: 5.8 MB for all of them

Floats64 = NDArray[np.float64]


def wigner_d(degree: int, alpha: ArrayLike) -> Floats64:
    r"""Return d^l(alpha): how harmonics of degree l mix under a rotation about the y axis.

    .. math:: Y_{lm}(R_y(\alpha) n) = \sum_{m'} d^l_{mm'}(\alpha) Y_{lm'}(n)

    (Ramamoorthi & Hanrahan, A Signal-Processing Framework for Reflection, 2004, equations 25 to 30, with complex
    harmonics that carry the Condon-Shortley phase). Degrees up to 2 in closed form, equation 30. Others through
    a quarter turn, d(alpha) = diag(i^m) d(pi/2) diag(e^(im alpha)) d(pi/2)^T diag(i^-m'), whose entries follow
    from a three-term recursion in m that runs downward, the stable way (Trapani & Navaza, Calculation of spherical
    harmonics and Wigner d functions by FFT, 2006). Orthogonal to 1e-14 at degree 64, to 1e-13 at 200, for any
    angle. The derivatives and factorials of the paper's equation 29 are right, but cancel and overflow soon.

    Parameters
    ----------
    degree
        l, from 0 to 1024.
    alpha
        (...) angles in radians.

    Returns
    -------
    array
        (..., 2l + 1, 2l + 1), rows m and columns m' from -l to l.

    Raises
    ------
    HarmonicFaceError
        Another degree, angles that are not finite, a result larger than the memory.

    Examples
    --------
    >>> wigner_d(1, np.pi / 2).round(4) + 0.0
    array([[ 0.5   ,  0.7071,  0.5   ],
           [-0.7071,  0.    ,  0.7071],
           [ 0.5   , -0.7071,  0.5   ]])
    """
    size = 2 * _degree(degree) + 1
    angles = np.asarray(_validate.finite(alpha, "alpha"), np.float64)
    _memory.require(32 * size**2 * max(1, angles.size), f"matrices of degree {degree} at {angles.size} angles")
    if degree <= 2:
        return _closed_form(degree, angles)
    modes = np.arange(-degree, degree + 1)
    quarter = _whole(quarter_turn(degree))
    turned = (quarter * np.exp(1j * modes * angles[..., None])[..., None, :]) @ quarter.T
    powers = 1j ** (modes % 4)
    return np.ascontiguousarray((powers[:, None] * turned * powers.conj()).real)


def wigner_matrix(
    degree: int, alpha: ArrayLike, beta: ArrayLike = 0.0, gamma: ArrayLike = 0.0
) -> NDArray[np.complex128]:
    r"""Return D^l(alpha, beta, gamma): how complex harmonics of degree l mix under R = Rz(beta) Ry(alpha) Rz(gamma).

    .. math:: Y_{lm}(R n) = \sum_{m'} D^l_{mm'} Y_{lm'}(n), \qquad
              D^l_{mm'} = d^l_{mm'}(\alpha) e^{im\beta} e^{im'\gamma}

    (Ramamoorthi & Hanrahan 2004, equations 25 to 27). Two columns of it are harmonics themselves (equation 31):
    D_0m'(alpha, beta, 0) = sqrt(4 pi / (2l + 1)) Y*_lm'(alpha, pi), and D_m0 = sqrt(4 pi / (2l + 1)) Y_lm(alpha, beta).
    Quantum mechanics calls the complex conjugate, with beta and alpha in other places, by the same letter.

    Parameters
    ----------
    degree
        l, from 0 to 1024.
    alpha, beta, gamma
        Angles in radians, of shapes that broadcast.

    Returns
    -------
    array
        (..., 2l + 1, 2l + 1) unitary matrices, rows m and columns m' from -l to l.

    Raises
    ------
    HarmonicFaceError
        Another degree, angles that are not finite or do not broadcast, a result larger than the memory.

    Examples
    --------
    >>> wigner_matrix(1, 0.0, np.pi / 2).diagonal().round(4) + 0.0
    array([0.-1.j, 1.+0.j, 0.+1.j])
    """
    given = [
        np.asarray(_validate.finite(angle, name), np.float64)
        for angle, name in ((alpha, "alpha"), (beta, "beta"), (gamma, "gamma"))
    ]
    try:
        tilt, left, right = np.broadcast_arrays(*given)
    except ValueError:
        shapes = ", ".join(str(angle.shape) for angle in given)
        raise HarmonicFaceError(f"alpha, beta, gamma: expected shapes that broadcast, got {shapes}") from None
    modes = np.arange(-_degree(degree), degree + 1)
    tilted = wigner_d(degree, tilt)
    rows, columns = np.exp(1j * modes * left[..., None]), np.exp(1j * modes * right[..., None])
    return np.asarray(tilted * rows[..., :, None] * columns[..., None, :])


def quarter_turn(degree: int) -> Floats64:
    """Return d^l(pi/2) for modes m, m' >= 0, (l + 1, l + 1); the rest of it follows by parity. Read-only."""
    return _kept(degree) if degree <= CACHED_DEGREE else _quarter_turn(degree)


def _quarter_turn(degree: int) -> Floats64:
    """Compute d^l(pi/2) row by row from m = l, where it is a square root of a binomial coefficient, down to 0."""
    modes = np.arange(degree + 1)
    result = np.zeros((degree + 1, degree + 1))
    corner = math.prod(math.sqrt((2 * k - 1) / (2 * k)) for k in range(1, degree + 1))
    ratios = -np.sqrt((degree - modes[:-1]) / (degree + modes[:-1] + 1))
    result[degree] = (-1) ** degree * corner * np.cumprod(np.concatenate([[1.0], ratios]))
    for mode in range(degree - 1, -1, -1):
        across = (degree - mode) * (degree + mode + 1)
        result[mode] = 2 * modes / math.sqrt(across) * result[mode + 1]
        if mode + 2 <= degree:
            result[mode] -= math.sqrt((degree - mode - 1) * (degree + mode + 2) / across) * result[mode + 2]
    result.flags.writeable = False
    return result


_kept = lru_cache(maxsize=CACHED_DEGREE + 1)(_quarter_turn)


def _whole(quarter: Floats64) -> Floats64:
    """Return d^l(pi/2) for all modes from its part with m, m' >= 0."""
    degree = len(quarter) - 1
    signs = (-1.0) ** np.arange(degree + 1)
    result = np.empty((2 * degree + 1, 2 * degree + 1))
    parity = (-1) ** degree
    result[degree:, degree:] = quarter
    result[degree:, degree::-1] = parity * signs[:, None] * quarter
    result[degree::-1, degree:] = parity * signs * quarter
    result[degree::-1, degree::-1] = signs[:, None] * signs * quarter
    return result


def _closed_form(degree: int, alpha: Floats64) -> Floats64:
    """Return d^0, d^1 or d^2, equation 30 of the paper."""
    cosine, sine = np.cos(alpha), np.sin(alpha)
    near, far = (1 + cosine) / 2, (1 - cosine) / 2  # squares of the cosine and sine of half the angle
    if degree == 0:
        rows = [[np.ones_like(cosine)]]
    elif degree == 1:
        edge = sine / math.sqrt(2)
        rows = [[near, edge, far], [-edge, cosine, edge], [far, -edge, near]]
    else:
        corner, other, middle = near * sine, far * sine, math.sqrt(3 / 8) * sine**2
        slope = math.sqrt(3 / 2) * sine * cosine
        inner, outer = near * (2 * cosine - 1), far * (2 * cosine + 1)
        rows = [
            [near**2, corner, middle, other, far**2],
            [-corner, inner, slope, outer, other],
            [middle, -slope, (3 * cosine**2 - 1) / 2, slope, middle],
            [-other, outer, -slope, inner, corner],
            [far**2, -other, middle, -corner, near**2],
        ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _degree(degree: int) -> int:
    """Return a degree that the recursion reaches."""
    if _validate.at_least(degree, 0, "degree") > LARGEST_DEGREE:
        raise HarmonicFaceError(f"degree: expected at most {LARGEST_DEGREE} for rotations, got {degree}")
    return int(degree)
