"""Fourier series, the harmonics of flatland: directions are angles, a rotation is a factor.

Coefficients of degrees l = -order ... order are stored at l + order.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._memory import require
from harmonicface.errors import HarmonicFaceError
from harmonicface.reflectance._arguments import numbers

Complexes = NDArray[np.complex128]
FULL = math.sqrt(2 * math.pi)


def circle_angles(count: int) -> NDArray[np.float64]:
    """Return evenly spaced angles from -pi up to and without pi, (count,).

    Parameters
    ----------
    count
        How many, at least 1.

    Raises
    ------
    HarmonicFaceError
        A count below 1, more angles than the memory holds.

    Examples
    --------
    >>> (circle_angles(4) / np.pi).tolist()
    [-1.0, -0.5, 0.0, 0.5]
    """
    size = _validate.at_least(count, 1, "count")
    require(16 * size, f"{size} angles")
    return np.asarray(2 * math.pi / size * np.arange(size) - math.pi, np.float64)


def fourier_basis(angles: ArrayLike, order: int) -> Complexes:
    r"""Return F_l(theta) = exp(i l theta) / sqrt(2 pi), orthonormal over the circle, (2 order + 1, ...).

    Ramamoorthi & Hanrahan 2004, equation 15.

    Parameters
    ----------
    angles
        (...) angles, in radians.
    order
        The highest degree, at least 0.

    Raises
    ------
    HarmonicFaceError
        Angles that are not finite, a negative order, more than the memory holds.

    Examples
    --------
    >>> (fourier_basis(np.pi / 2, 1) * np.sqrt(2 * np.pi)).round(12) + 0
    array([0.-1.j, 1.+0.j, 0.+1.j])
    """
    values = _validate.finite(angles, "angles")
    order = _validate.at_least(order, 0, "order")
    size = 2 * order + 1
    require(8 * size + 32 * size * values.size, f"waves of order {order} at {values.size} angles")
    degree = np.arange(-order, order + 1)
    return np.asarray(np.exp(1j * np.multiply.outer(degree, values)) / FULL)


def fourier_coefficients(samples: ArrayLike, order: int) -> Complexes:
    r"""Return L_l = \int L F_l^* of a function sampled at `circle_angles`, (2 order + 1, ...).

    Exact where the function holds no degree of (number of samples - order) or more.

    Parameters
    ----------
    samples
        (n, ...) values at the n angles of `circle_angles`, n > 2 order.
    order
        The highest degree.

    Raises
    ------
    HarmonicFaceError
        Too few samples for the order, NaN or infinity.

    Examples
    --------
    >>> fourier_coefficients(np.cos(circle_angles(8)), 1).real.round(4) + 0
    array([1.2533, 0.    , 1.2533])
    """
    values = numbers(samples, "samples")
    if values.ndim == 0 or len(values) <= 2 * _validate.at_least(order, 0, "order"):
        raise HarmonicFaceError(f"samples: expected at least {2 * order + 1} of them, got {_validate.describe(values)}")
    basis = fourier_basis(circle_angles(len(values)), order)
    return np.asarray(np.tensordot(basis.conj(), values, (1, 0)) * (2 * math.pi / len(values)))


def fourier_series(coefficients: ArrayLike, angles: ArrayLike) -> Complexes:
    """Return the sum of L_l F_l(theta), (number of angles, ...): the inverse of `fourier_coefficients`.

    Parameters
    ----------
    coefficients
        (2 order + 1, ...) coefficients L_l.
    angles
        Any number of angles, in radians.

    Raises
    ------
    HarmonicFaceError
        An even number of degrees, NaN or infinity.

    Examples
    --------
    >>> fourier_series([0, np.sqrt(2 * np.pi), 0], [0.3, 2.0]).real.round(12).tolist()
    [1.0, 1.0]
    """
    values = series(coefficients, "coefficients")
    basis = fourier_basis(np.ravel(_validate.finite(angles, "angles")), len(values) // 2)
    return np.asarray(np.tensordot(basis, values, (0, 0)))


def rotate_flat(coefficients: ArrayLike, angle: float) -> Complexes:
    r"""Return the coefficients of L(angle + theta'), the light in the frame of a normal at that angle.

    They are L_l e^{i l angle} (Ramamoorthi & Hanrahan 2004, equation 16). A rotation of flatland is a factor for each
    degree.

    Parameters
    ----------
    coefficients
        (2 order + 1, ...) coefficients L_l.
    angle
        Of the normal, in radians.

    Raises
    ------
    HarmonicFaceError
        An even number of degrees, NaN or infinity.

    Examples
    --------
    >>> rotate_flat([0, 1, 1], np.pi / 2).round(12) + 0
    array([0.+0.j, 1.+0.j, 0.+1.j])
    """
    values = series(coefficients, "coefficients")
    turn = FULL * fourier_basis(angle, len(values) // 2)
    return np.asarray(turn.reshape(-1, *[1] * (values.ndim - 1)) * values)


def series(coefficients: ArrayLike, name: str) -> NDArray[Any]:
    """Return coefficients of degrees -order ... order along the first axis: an odd number of them."""
    values = numbers(coefficients, name)
    if values.ndim == 0 or len(values) % 2 == 0:
        raise HarmonicFaceError(f"{name}: expected 2 order + 1 degrees, got {_validate.describe(values)}")
    return values
