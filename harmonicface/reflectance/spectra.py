"""The extremes of light and material as spectra: one direction, no direction, a mirror; and how a filter acts."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._memory import require
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import count, degrees, order_of
from harmonicface.reflectance._arguments import filter_order, filter_values


def degree_norms(order: int) -> NDArray[np.float64]:
    r"""Return Lambda_l = sqrt(4 pi / (2l + 1)), which turns rho_l into the filter Lambda_l rho_l, (order + 1,).

    Ramamoorthi & Hanrahan 2004, equation 45; rho_l are the harmonic coefficients of the transfer function about its
    own axis.

    Parameters
    ----------
    order
        The highest degree l, at least 0.

    Raises
    ------
    HarmonicFaceError
        A negative order.

    Examples
    --------
    >>> degree_norms(2).round(4)
    array([3.5449, 2.0467, 1.5853])
    """
    return np.sqrt(4 * math.pi / (2 * np.arange(filter_order(order) + 1) + 1))


def mirror_filter(order: int) -> NDArray[np.float64]:
    r"""Return the filter of a mirror about the reflection vector: 1 at each degree, (order + 1,).

    rho_l = 1 / Lambda_l, B_lm = L_lm: the picture of a mirror sphere is the light itself (Ramamoorthi & Hanrahan 2004,
    equation 68). It is what Phong tends to as the shininess grows and microfacets as the roughness vanishes.

    Parameters
    ----------
    order
        The highest degree l, at least 0.

    Raises
    ------
    HarmonicFaceError
        A negative order.

    Examples
    --------
    >>> mirror_filter(2)
    array([1., 1., 1.])
    """
    return np.ones(filter_order(order) + 1)


def mirror_coefficients(order: int, degree: int, mode: int) -> NDArray[np.float64]:
    r"""Return rho_lpq of a mirror about the surface normal, for one l and q and every p up to the order.

    .. math:: \rho_{lpq} = (-1)^q \int_{upper} Y_{lq}^* Y_{pq}

    Over the upper half sphere, where a mirror reflects, that is (-1)^q / 2 for p = l, 0 for other p of l's parity, and
    not 0 for the rest: not the (-1)^q delta_lp of Ramamoorthi & Hanrahan 2004, equation 66, which holds for a mirror
    that reflects on both sides (twice the p of l's parity, the others cancel).

    Parameters
    ----------
    order
        The highest degree p.
    degree, mode
        l >= |q|, and q.

    Returns
    -------
    array
        (order + 1,) numbers for p = 0 ... order; 0 for p < |q|.

    Raises
    ------
    HarmonicFaceError
        A degree or an order that is negative, a mode beyond the degree, more memory than there is.

    Examples
    --------
    >>> mirror_coefficients(2, 1, 0).round(4)
    array([0.433 , 0.5   , 0.2421])
    """
    highest = max(filter_order(order), _validate.at_least(degree, 0, "degree"))
    if abs(_validate.at_least(mode, -degree, "mode")) > degree:
        raise HarmonicFaceError(f"mode: expected an integer from {-degree} to {degree}, got {mode}")
    size = highest + 1
    require(8 * size**3 + 24 * size**2, f"mirror of degrees up to {highest}")
    nodes, weights = np.polynomial.legendre.leggauss(size)
    heights = (nodes + 1) / 2
    across = np.sqrt(1 - heights**2)
    directions = np.stack([across, np.zeros_like(across), heights], axis=-1)
    positions = np.arange(highest + 1)
    values = np.zeros((highest + 1, len(heights)))
    rows = positions[abs(mode) :]
    values[rows] = real_harmonics(directions, highest)[rows * (rows + 1) + abs(mode)]
    turn = math.pi / (1 if mode == 0 else 2)  # the azimuth's integral of 1, or of 2 cos^2 already at its largest
    return np.asarray((-1.0) ** mode * turn * (values[: order + 1] @ (weights * values[degree])))


def directional_spectrum(direction: ArrayLike, order: int) -> NDArray[np.float64]:
    r"""Return L_lm = Y_lm(direction) of a light from one direction, of irradiance 1, ((order + 1)^2,).

    Ramamoorthi & Hanrahan 2004, equations 63 and 64. Each coefficient's mean square is 1 / (4 pi) at every degree: a
    white spectrum, the best light to measure a material by. From the z axis only L_l0 = 1 / Lambda_l are not 0.

    Parameters
    ----------
    direction
        Three numbers toward the light, of any length above 0.
    order
        The highest degree l, at least 0.

    Raises
    ------
    HarmonicFaceError
        A direction of zero length or not of three numbers, a negative order.

    Examples
    --------
    >>> directional_spectrum([0, 0, 2], 1).round(4)
    array([0.2821, 0.    , 0.4886, 0.    ])
    """
    vector = _validate.directions(direction, "direction")
    if vector.shape != (3,):
        raise HarmonicFaceError(f"direction: expected three numbers, got {_validate.describe(vector)}")
    return np.asarray(real_harmonics(vector.astype(np.float64), order), np.float64)


def uniform_spectrum(order: int) -> NDArray[np.float64]:
    r"""Return L_lm of the same light from everywhere, radiance 1 / (4 pi): only L_00 = 1 / Lambda_0 is not 0.

    Ramamoorthi & Hanrahan 2004, equation 65; its total is 1 like that of `directional_spectrum`. A radiance of 1 has
    L_00 = Lambda_0 = sqrt(4 pi).

    Parameters
    ----------
    order
        The highest degree l, at least 0.

    Raises
    ------
    HarmonicFaceError
        A negative order, one that needs more memory than there is.

    Examples
    --------
    >>> uniform_spectrum(1).round(4)
    array([0.2821, 0.    , 0.    , 0.    ])
    """
    require(8 * count(order), f"light of order {order}")
    result = np.zeros(count(order))
    result[0] = 1 / math.sqrt(4 * math.pi)
    return result


def degree_power(coefficients: ArrayLike) -> NDArray[np.float64]:
    r"""Return the energy of each degree, \sum_m L_lm^2, (order + 1,) or (order + 1, channels).

    A rotation does not change it.

    Parameters
    ----------
    coefficients
        ((order + 1)^2,) or ((order + 1)^2, channels) harmonic coefficients.

    Raises
    ------
    HarmonicFaceError
        Not (order + 1)^2 coefficients, NaN or infinity.

    Examples
    --------
    >>> (4 * np.pi * degree_power(directional_spectrum([1, 2, 3], 3))).round(12)
    array([1., 3., 5., 7.])
    """
    values = _validate.finite(coefficients, "coefficients")
    order = order_of(len(np.atleast_1d(values)))
    return np.add.reduceat(np.square(np.atleast_1d(values), dtype=np.float64), np.arange(order + 1) ** 2, axis=0)


def apply_filter(filter_: ArrayLike, coefficients: ArrayLike) -> Floats:
    r"""Return B_lm = f_l L_lm, the light as a surface with this filter reflects it.

    Ramamoorthi & Hanrahan 2004, equation 56. Convolution is associative: light filtered by one material and seen in
    another is light seen in the product of both filters, and a blurred light in a mirror is the light in a gloss
    (equation 82): no picture tells them apart.

    Parameters
    ----------
    filter_
        (order + 1,) numbers f_l.
    coefficients
        ((order + 1)^2,) or ((order + 1)^2, channels) coefficients L_lm of no higher order than the filter's.

    Raises
    ------
    HarmonicFaceError
        A filter with fewer degrees than the coefficients, a wrong number of them, NaN or infinity.

    Examples
    --------
    >>> apply_filter([2.0, 0.5], [1.0, 1.0, 2.0, 3.0])
    array([2. , 0.5, 1. , 1.5])
    """
    factors = filter_values(filter_)
    values = np.atleast_1d(_validate.finite(coefficients, "coefficients"))
    order = order_of(len(values))
    if len(factors) <= order:
        raise HarmonicFaceError(
            f"filter: expected at least {order + 1} degrees for the coefficients, got {len(factors)}"
        )
    return np.asarray((factors[degrees(order)] * values.T).T)
