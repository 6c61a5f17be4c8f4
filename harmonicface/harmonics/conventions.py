"""Other conventions: coefficients to and from the phases, scales and layouts of others (pyshtools: cilm; DPR: dpr)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics._checked import coefficients as checked
from harmonicface.harmonics._checked import nothing_outside, numbers
from harmonicface.harmonics.complex import Complexes, to_complex, to_real
from harmonicface.harmonics.indexing import degrees, modes


def switch_condon_shortley(coefficients: ArrayLike) -> Floats:
    """Multiply by (-1)^m: to the Condon-Shortley phase from harmonics without it, or back.

    Parameters
    ----------
    coefficients
        ((order + 1)^2, ...) real coefficients; or harmonics, in the same order.

    Returns
    -------
    array
        The same, with the sign of every odd mode changed.

    Raises
    ------
    HarmonicFaceError
        A count that is not a square number, NaN or infinity.

    Examples
    --------
    >>> switch_condon_shortley([1.0, 1.0, 1.0, 1.0])
    array([ 1., -1.,  1., -1.])
    """
    given, order = checked(coefficients)
    return (given.T * np.where(modes(order) % 2, -1, 1).astype(given.dtype)).T


def to_four_pi(coefficients: ArrayLike) -> Floats:
    """Return coefficients for harmonics whose square averages to 1 (geodesy), from orthonormal ones.

    The harmonics are sqrt(4 pi) times larger, so the coefficients are that much smaller: c_00 is the mean.

    Parameters
    ----------
    coefficients
        ((order + 1)^2, ...) orthonormal coefficients.

    Returns
    -------
    array
        4-pi normalized coefficients, of the same shape.

    Raises
    ------
    HarmonicFaceError
        A count that is not a square number, NaN or infinity.

    Examples
    --------
    >>> to_four_pi([math.sqrt(4 * math.pi)]).round(6)
    array([1.])
    """
    given, _ = checked(coefficients)
    return np.asarray(given / given.dtype.type(math.sqrt(4 * math.pi)))


def from_four_pi(coefficients: ArrayLike) -> Floats:
    """Return orthonormal coefficients from 4-pi normalized ones, the inverse of `to_four_pi`.

    Parameters
    ----------
    coefficients
        ((order + 1)^2, ...) 4-pi normalized coefficients.

    Returns
    -------
    array
        Orthonormal coefficients, of the same shape.

    Raises
    ------
    HarmonicFaceError
        A count that is not a square number, NaN or infinity.

    Examples
    --------
    >>> from_four_pi([1.0]).round(6)
    array([3.544908])
    """
    given, _ = checked(coefficients)
    return np.asarray(given * given.dtype.type(math.sqrt(4 * math.pi)))


def to_scipy(coefficients: ArrayLike) -> Complexes:
    """Return the coefficients that go with `scipy.special.sph_harm_y_all`, from real ones.

    The harmonics of scipy are complex, orthonormal and carry the Condon-Shortley phase: those of
    `complex_harmonics`. What differs is the layout: row l, column m, and -m counts from the end.

    Parameters
    ----------
    coefficients
        ((order + 1)^2, ...) real coefficients.

    Returns
    -------
    array
        (order + 1, 2 order + 1, ...), zero where |m| > l.

    Raises
    ------
    HarmonicFaceError
        A count that is not a square number, NaN or infinity.

    Examples
    --------
    >>> to_scipy([0.0, 0.0, 0.0, 1.0])[1].round(4) + 0.0  # m = 0, 1, -1
    array([ 0.    +0.j, -0.7071+0.j,  0.7071+0.j])
    """
    given, order = checked(coefficients)
    result = np.zeros((order + 1, 2 * order + 1, *given.shape[1:]), np.result_type(given.dtype, np.complex64))
    result[degrees(order), modes(order)] = to_complex(given)
    return result


def from_scipy(coefficients: ArrayLike) -> Floats:
    """Return real coefficients from those that go with `scipy.special.sph_harm_y_all`, the inverse of `to_scipy`.

    Parameters
    ----------
    coefficients
        (order + 1, 2 order + 1, ...) complex coefficients of a real function.

    Returns
    -------
    array
        ((order + 1)^2, ...) real coefficients.

    Raises
    ------
    HarmonicFaceError
        Another shape than (order + 1, 2 order + 1, ...), numbers that are not those of a real function, or not zero
        where |m| > l.

    Examples
    --------
    >>> from_scipy(to_scipy([0.0, 1.0, 2.0, 3.0])).round(6)
    array([0., 1., 2., 3.])
    """
    given = numbers(coefficients, "coefficients")
    if given.ndim < 2 or given.shape[1] != 2 * given.shape[0] - 1:
        raise HarmonicFaceError(f"coefficients: expected shape (order + 1, 2 order + 1, ...), got {given.shape}")
    order = len(given) - 1
    nothing_outside(given, degrees(order), modes(order), "|m| > l")
    return to_real(given[degrees(order), modes(order)])


def to_sphericart(harmonics: ArrayLike) -> Floats:
    """Return harmonics as sphericart lays them out: a row a direction, (n, k) from (k, n).

    Order, phase and scale are the same, so coefficients need no conversion.

    Parameters
    ----------
    harmonics
        ((order + 1)^2, n) values, coefficient-major.

    Returns
    -------
    array
        (n, (order + 1)^2), contiguous.

    Raises
    ------
    HarmonicFaceError
        A count that is not a square number, NaN or infinity.

    Examples
    --------
    >>> to_sphericart(np.zeros((9, 4))).shape
    (4, 9)
    """
    given, _ = checked(harmonics, "harmonics")
    return np.ascontiguousarray(np.moveaxis(given, 0, -1))


def from_sphericart(harmonics: ArrayLike) -> Floats:
    """Return harmonics coefficient-major, (k, n), from sphericart's (n, k).

    Parameters
    ----------
    harmonics
        (n, (order + 1)^2) values, a row a direction.

    Returns
    -------
    array
        ((order + 1)^2, n), contiguous.

    Raises
    ------
    HarmonicFaceError
        A count that is not a square number, NaN or infinity.

    Examples
    --------
    >>> from_sphericart(np.zeros((4, 9))).shape
    (9, 4)
    """
    given = np.atleast_1d(_validate.finite(harmonics, "harmonics"))
    return checked(np.ascontiguousarray(np.moveaxis(given, -1, 0)), "harmonics")[0]
