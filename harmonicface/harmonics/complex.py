"""Complex harmonics, as the papers' formulas use them, and conversion of coefficients to and from the real ones."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _memory, _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics._checked import numbers
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import count, modes, order_of

REALITY_TOLERANCE = 1e-6  # of the largest coefficient

Complexes = NDArray[np.complexfloating]


def complex_harmonics(directions: ArrayLike, order: int) -> Complexes:
    r"""Evaluate the complex harmonics Y_lm, orthonormal over the sphere, with the Condon-Shortley phase.

    .. math:: Y_{lm} = \sqrt{\frac{2l+1}{4\pi}\frac{(l-m)!}{(l+m)!}} P_{lm}(\cos\theta) e^{im\phi}, \qquad
              Y_{l,-m} = (-1)^m Y^*_{lm}

    (Ramamoorthi & Hanrahan, A Signal-Processing Framework for Reflection, 2004, equations 23 and 24), so that
    Y_11 = -sqrt(3 / (8 pi)) (x + iy). The same as scipy's `sph_harm_y`. From the real ones: for m > 0,
    Y_lm = (-1)^m (R_lm + i R_l-m) / sqrt(2).

    Parameters
    ----------
    directions
        (..., 3) unit vectors; of float32, the result is complex64.
    order
        The highest degree l, at least 0.

    Returns
    -------
    array
        ((order + 1)^2, ...) values, (l, m) at l * (l + 1) + m.

    Raises
    ------
    HarmonicFaceError
        Directions that are not finite unit vectors, a negative order, a result larger than the memory.

    Examples
    --------
    >>> complex_harmonics([1.0, 0.0, 0.0], order=1).round(6) + 0.0
    array([ 0.282095+0.j,  0.345494+0.j,  0.      +0.j, -0.345494+0.j])
    """
    flat = _validate.floats(directions, "directions")
    _memory.require(24 * count(order) * (flat.size // 3), f"complex harmonics of order {order}")
    real = real_harmonics(flat, order)
    return _combine(real, order, conjugate=False)


def to_complex(coefficients: ArrayLike) -> Complexes:
    r"""Return the complex coefficients of a real function from its real ones.

    .. math:: f = \sum c_{lm} R_{lm} = \sum a_{lm} Y_{lm}, \qquad a_{lm} = (-1)^m (c_{lm} - i c_{l,-m}) / \sqrt{2},
              \quad a_{l,-m} = (c_{lm} + i c_{l,-m}) / \sqrt{2} \quad (m > 0)

    Parameters
    ----------
    coefficients
        ((order + 1)^2, ...) real coefficients.

    Returns
    -------
    array
        Complex coefficients, of the same shape and order of storage.

    Raises
    ------
    HarmonicFaceError
        A count that is not a square number, NaN or infinity.

    Examples
    --------
    >>> to_complex([0.0, 0.0, 0.0, 1.0]).round(4) + 0.0
    array([ 0.    +0.j,  0.7071+0.j,  0.    +0.j, -0.7071+0.j])
    """
    given = np.atleast_1d(_validate.finite(coefficients, "coefficients"))
    return _combine(given, order_of(len(given)), conjugate=True)


def to_real(coefficients: ArrayLike) -> Floats:
    r"""Return the real coefficients of a real function from its complex ones, the inverse of `to_complex`.

    .. math:: c_{lm} = \sqrt{2} (-1)^m \Re a_{lm}, \qquad c_{l,-m} = -\sqrt{2} (-1)^m \Im a_{lm} \quad (m > 0)

    Parameters
    ----------
    coefficients
        ((order + 1)^2, ...) complex coefficients of a real function: a_l-m = (-1)^m conj(a_lm).

    Returns
    -------
    array
        Real coefficients, of the same shape.

    Raises
    ------
    HarmonicFaceError
        No numbers, a count that is not a square number, NaN or infinity, coefficients of a function that is not real.

    Examples
    --------
    >>> to_real([1.0, 0.5j, 2.0, 0.5j]).round(4)
    array([ 1.    ,  0.7071,  2.    , -0.    ])
    """
    given = np.atleast_1d(numbers(coefficients, "coefficients"))
    if not np.isfinite(given).all():
        raise HarmonicFaceError(f"coefficients: expected finite numbers, got {_validate.describe(given)}")
    order = order_of(len(given))
    mode = _column(modes(order), given)
    signs = np.where(mode % 2, -1.0, 1.0)
    mirrored = given[_mirror(order)]
    error = np.abs(given - signs * mirrored.conj()).max()
    if error > REALITY_TOLERANCE * np.abs(given).max():
        raise HarmonicFaceError(
            f"coefficients: expected those of a real function, a_l-m = (-1)^m conj(a_lm), got {error:.3g} apart"
        )
    real = np.where(mode > 0, given.real, -mirrored.imag)
    result = np.where(mode == 0, given.real, np.sqrt(2.0) * signs * real)
    return result.astype(np.float32 if given.dtype == np.complex64 else np.float64)


def _combine(real: Floats, order: int, conjugate: bool) -> Complexes:
    """Return (-1)^m (R_lm + i R_l-m) / sqrt(2) for m > 0 and (R_l|m| - i R_l-|m|) / sqrt(2) for m < 0.

    Coefficients go with the conjugate, so that the sum of products stays the same.
    """
    mode = modes(order)
    cosines = np.where(mode >= 0, np.arange(len(mode)), _mirror(order))
    scale = np.where(mode == 0, 1.0, np.sqrt(0.5)) * np.where((mode > 0) & (mode % 2 == 1), -1.0, 1.0)
    turn = np.sign(mode) * (-1.0 if conjugate else 1.0)
    result = np.empty(real.shape, np.complex64 if real.dtype == np.float32 else np.complex128)
    np.multiply(real[cosines], _column(scale, real), out=result.real, casting="same_kind")
    np.multiply(real[_mirror(order)[cosines]], _column(scale * turn, real), out=result.imag, casting="same_kind")
    return result


def _mirror(order: int) -> NDArray[np.intp]:
    """Return where the harmonic (l, -m) is stored, for each (l, m)."""
    return np.asarray(np.arange(count(order)) - 2 * modes(order))


def _column(values: NDArray[Any], like: NDArray[Any]) -> NDArray[Any]:
    """Return one value a coefficient, in a shape that broadcasts with the coefficients."""
    return values.reshape(-1, *(1,) * (like.ndim - 1))
