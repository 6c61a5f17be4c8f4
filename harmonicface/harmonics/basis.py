"""Real orthonormal spherical harmonics of any order at unit directions."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import count


def real_harmonics(directions: ArrayLike, order: int, out: Floats | None = None) -> Floats:
    r"""Evaluate the real harmonics Y_lm, orthonormal over the sphere and without the Condon-Shortley phase.

    .. math:: Y_{lm} = N_{l|m|} P_l^{|m|}(\cos\theta) \sqrt{2} \{\cos m\phi, \; \sin|m|\phi\}

    with the cosine for m > 0, the sine for m < 0 and neither (nor the root) for m = 0. In order 2 that is 1, y, z,
    x, xy, yz, 3z^2 - 1, xz, x^2 - y^2 times 0.282095, 0.488603, 1.092548 or 0.315392, 0.546274 (Ramamoorthi &
    Hanrahan, An Efficient Representation for Irradiance Environment Maps, 2001, equation 3).

    Parameters
    ----------
    directions
        (..., 3) unit vectors. float32 stays float32; anything else is computed in float64.
    order
        The highest degree l, at least 0.
    out
        Where to write the result: C-contiguous, of the result's shape and type. Made if not given.

    Returns
    -------
    array
        ((order + 1)^2, ...) values, coefficient-major: one contiguous row a harmonic, (l, m) at l * (l + 1) + m.

    Raises
    ------
    HarmonicFaceError
        Directions that are not finite unit vectors, a negative order, an `out` that does not fit.

    Examples
    --------
    >>> real_harmonics([0.0, 0.0, 1.0], order=1).round(6)
    array([0.282095, 0.      , 0.488603, 0.      ])
    """
    unit = _validate.unit_normals(directions, "directions")
    shape = (count(order), *unit.shape[:-1])
    if out is None:
        out = np.empty(shape, unit.dtype)
    elif not isinstance(out, np.ndarray) or out.shape != shape or out.dtype != unit.dtype or not out.flags.c_contiguous:
        expected = f"a C-contiguous array of shape {shape} and type {unit.dtype}"
        raise HarmonicFaceError(f"out: expected {expected}, got {_validate.describe(out)}")
    x, y, z = np.ascontiguousarray(np.moveaxis(unit, -1, 0))
    cosine, sine = np.ones_like(x), np.zeros_like(x)  # sin(theta)^m times cos(m phi) and sin(m phi)
    for mode in range(order + 1):
        if mode:
            cosine, sine = x * cosine - y * sine, x * sine + y * cosine
        _fill_mode(out, z, cosine, sine, mode, order)
    return out


def _fill_mode(out: Floats, z: Floats, cosine: Floats, sine: Floats, mode: int, order: int) -> None:
    """Write the harmonics +-mode of every degree, by the normalized three-term recursion in the degree.

    What recurs is N P_l^m / sin(theta)^m, a polynomial in z, so that nothing is divided at the poles.
    """
    below: Floats | None = None
    current: Floats = np.full_like(z, _sectoral(mode))
    for degree in range(mode, order + 1):
        if degree > mode:
            step, back = _recursion(degree, mode)
            following = step * z * current
            if below is not None:
                following -= step * back * below
            below, current = current, following
        centre = degree * (degree + 1)
        np.multiply(current, cosine, out=out[centre + mode, ...])
        if mode:
            np.multiply(current, sine, out=out[centre - mode, ...])


def _sectoral(mode: int) -> float:
    """Return Y_mm over (sin(theta)^m cos(m phi)), by a product that stays near one."""
    squared = 1 / (4 * math.pi)
    for k in range(1, mode + 1):
        squared *= (2 * k + 1) / (2 * k)
    return math.sqrt(squared * (2 if mode else 1))


def _recursion(degree: int, mode: int) -> tuple[float, float]:
    """Return a and b of P_l = a (z P_(l-1) - b P_(l-2)) for normalized associated Legendre functions."""
    step = math.sqrt((4 * degree**2 - 1) / (degree**2 - mode**2))
    back = math.sqrt(((degree - 1) ** 2 - mode**2) / (4 * (degree - 1) ** 2 - 1))
    return step, back
