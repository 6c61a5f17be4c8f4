"""Reflection in flatland, where a surface is a curve and directions are angles: the theory at its simplest.

Coefficients of degrees l = -order ... order are stored at l + order.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.reflectance._arguments import numbers
from harmonicface.reflectance.flatland_series import FULL, Complexes, fourier_coefficients, fourier_series, series


def transfer_coefficients(samples: ArrayLike, order: int, outgoing_order: int) -> Complexes:
    r"""Return rho_lp = \int\int rho(theta_i, theta_o) F_l(theta_i) F_p^*(theta_o) of a sampled transfer function.

    Ramamoorthi & Hanrahan 2004, equation 17: the transfer function is the BRDF times cos(theta_i), 0 beyond the upper
    half circle. A reciprocal one (times cos(theta_o) too) has rho_lp = rho_(-p)(-l).

    Parameters
    ----------
    samples
        (n, o) values at `circle_angles(n)` of incidence and `circle_angles(o)` of exitance, in the surface's own frame.
    order, outgoing_order
        The highest degrees of l and p.

    Returns
    -------
    array
        (2 order + 1, 2 outgoing_order + 1) numbers, (l, p) at (l + order, p + outgoing_order).

    Raises
    ------
    HarmonicFaceError
        Samples that are no matrix, too few for the orders, NaN or infinity.
    """
    values = numbers(samples, "samples")
    if values.ndim != 2:
        raise HarmonicFaceError(f"samples: expected (incidence, exitance), got {_validate.describe(values)}")
    across = fourier_coefficients(values, order)[::-1]  # F_l in place of its conjugate is degree -l
    return np.asarray(fourier_coefficients(across.T, outgoing_order).T)


def reflect_flat(light: ArrayLike, transfer: ArrayLike) -> Complexes:
    r"""Return the reflected light field's coefficients, B_lp = sqrt(2 pi) L_l rho_lp.

    Ramamoorthi & Hanrahan 2004, equation 21; equation 22 where the further axis holds outgoing angles instead of
    degrees; and for a radially symmetric material, whose transfer has one axis, B_l = f_l L_l with
    f_l = sqrt(2 pi) rho_l.

    Parameters
    ----------
    light
        (2 order + 1,) coefficients L_l.
    transfer
        (2 order + 1, ...) coefficients rho_l, rho_lp or rho_l(theta_o).

    Returns
    -------
    array
        Of the transfer's shape.

    Raises
    ------
    HarmonicFaceError
        Light and transfer of different orders, NaN or infinity.

    Examples
    --------
    >>> reflect_flat([0, 1, 2], [[1, 1], [1, 1], [1, 0]]).real.round(4)
    array([[0.    , 0.    ], [2.5066, 2.5066], [5.0133, 0.    ]])
    """
    known, material = series(light, "light"), series(transfer, "transfer")
    if known.ndim != 1 or len(known) != len(material):
        raise HarmonicFaceError(
            f"transfer: expected the light's {known.shape} degrees first, got {_validate.describe(material)}"
        )
    return np.asarray(FULL * known.reshape(-1, *[1] * (material.ndim - 1)) * material)


def light_field(coefficients: ArrayLike, normals: ArrayLike, outgoing: ArrayLike) -> Complexes:
    r"""Return B(alpha, theta_o) = \sum B_lp F_l(alpha) F_p(theta_o), (normals, outgoing).

    Ramamoorthi & Hanrahan 2004, equation 17; theta_o is counted from the normal at alpha.

    Parameters
    ----------
    coefficients
        (2 order + 1, 2 outgoing_order + 1) coefficients B_lp.
    normals, outgoing
        Angles alpha and theta_o, in radians.

    Raises
    ------
    HarmonicFaceError
        No matrix of odd numbers of degrees, NaN or infinity.

    Examples
    --------
    >>> light_field([[0.0], [2 * np.pi], [0.0]], [0.0, 1.0], [0.5]).real.round(12)
    array([[1.],
           [1.]])
    """
    values = series(coefficients, "coefficients")
    if values.ndim != 2:
        raise HarmonicFaceError(f"coefficients: expected B_lp, got {_validate.describe(values)}")
    return fourier_series(fourier_series(values, normals).T, outgoing).T


def reflect_flat_directly(
    light: Callable[[Floats], Floats],
    transfer: Callable[[Floats, Floats], Floats],
    normals: ArrayLike,
    outgoing: ArrayLike,
    nodes: int = 200,
) -> NDArray[np.float64]:
    r"""Return B(alpha, theta_o) by the integral itself, (normals, outgoing): the reference of everything else here.

    .. math:: B(\alpha, \theta_o) = \int_{-\pi/2}^{\pi/2} L(\alpha + \theta_i) \hat\rho(\theta_i, \theta_o) d\theta_i

    Ramamoorthi & Hanrahan 2004, equation 6, by Gauss-Legendre quadrature.

    Parameters
    ----------
    light
        L of global angles, vectorized.
    transfer
        BRDF times cos(theta_i), of angles in the surface's own frame, vectorized.
    normals, outgoing
        Angles alpha and theta_o.
    nodes
        How many nodes the half circle gets.

    Raises
    ------
    HarmonicFaceError
        Angles or values that are not finite, fewer than one node.

    Examples
    --------
    >>> uniform, matte = (lambda angle: 1 + 0 * angle), (lambda incident, outgoing: np.cos(incident) + 0 * outgoing)
    >>> reflect_flat_directly(uniform, matte, [0.3], [0.0]).round(12)
    array([[2.]])
    """
    places, weights = np.polynomial.legendre.leggauss(_validate.at_least(nodes, 1, "nodes"))
    incident = math.pi / 2 * places
    arriving = light(np.add.outer(np.ravel(_validate.finite(normals, "normals")), incident))
    passed = transfer(incident[:, None], np.ravel(_validate.finite(outgoing, "outgoing")))
    weighted = math.pi / 2 * weights * _validate.finite(arriving, "light")
    return np.asarray(weighted @ _validate.finite(passed, "transfer"), np.float64)
