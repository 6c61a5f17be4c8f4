"""A rough, shiny material: the simplified Torrance-Sparrow lobe at normal exitance, as a filter on light."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.reflectance._arguments import filter_order, roughness_of
from harmonicface.reflectance.phong import Gaussian

NODES = 32  # of Gauss and Legendre in each panel
FARTHEST = 7.0  # exp(-u^2) is 5e-22 there, in units of twice the roughness


def microfacet_lobe(cosines: ArrayLike, roughness: float) -> Floats:
    r"""Return the transfer function exp(-(theta / 2 sigma)^2) / (4 pi sigma^2) over the upper half sphere.

    The simplified Torrance-Sparrow model without Fresnel and geometric terms (Ramamoorthi & Hanrahan 2004, equations
    83 and 85), seen along the normal: the half angle is theta / 2, the cosine of the incident angle cancels. For
    other exitant angles the quotient 1 / cos(theta_o) of equation 83 makes the coefficients diverge; expand
    B cos(theta_o) there.

    Parameters
    ----------
    cosines
        (...) cosines of the angle theta between the light and the normal (the mirror direction), from -1 to 1.
    roughness
        sigma, in radians, above 0 and at most 100.

    Returns
    -------
    array
        (...) values in 1 / steradian; their integral over the sphere is a little below 1 (.941 for sigma = .3).

    Raises
    ------
    HarmonicFaceError
        A roughness that is not between 1e-100 and 100, cosines that are not finite.

    Examples
    --------
    >>> microfacet_lobe([1.0, 0.5, -0.5], 0.3).round(4)
    array([0.8842, 0.042 , 0.    ])
    """
    width = roughness_of(roughness)
    values = _validate.finite(cosines, "cosines")
    angles = np.arccos(np.clip(values, 0, 1))
    return np.asarray(np.where(values > 0, _lobe(angles, width), 0))


def microfacet_filter(roughness: float, order: int) -> NDArray[np.float64]:
    r"""Return f_l = Lambda_l rho_l of the microfacet lobe at normal exitance, with B_lm = f_l L_lm.

    .. math:: f_l = \frac{1}{2 \sigma^2} \int_0^{\pi/2} e^{-\theta^2 / 4 \sigma^2} P_l(\cos\theta) \sin\theta \, d\theta

    (Ramamoorthi & Hanrahan 2004, equation 85.) By Gauss-Legendre panels fine enough for the degree, to about 1e-14;
    near the mirror direction it holds for other exitant angles too.

    Parameters
    ----------
    roughness
        sigma, in radians, above 0 and at most 100.
    order
        The highest degree l, at least 0.

    Returns
    -------
    array
        (order + 1,) numbers; f_0 is the lobe's energy, a little below 1.

    Raises
    ------
    HarmonicFaceError
        A roughness that is not between 1e-100 and 100, a negative order.

    Examples
    --------
    >>> microfacet_filter(0.3, 3).round(3)
    array([0.941, 0.791, 0.558, 0.331])
    """
    width = roughness_of(roughness)
    angles, weights = _panels(width, filter_order(order))
    return _legendre_sums(angles, 2 * math.pi * weights * np.sin(angles) * _lobe(angles, width), order)


def microfacet_sensitivity(roughness: float, order: int) -> NDArray[np.float64]:
    r"""Return df_l / dsigma, how a microfacet filter changes with its roughness, (order + 1,).

    Parameters
    ----------
    roughness
        sigma, in radians, above 0 and at most 100.
    order
        The highest degree l, at least 0.

    Raises
    ------
    HarmonicFaceError
        A roughness that is not between 1e-100 and 100, a negative order.

    Examples
    --------
    >>> microfacet_sensitivity(0.1, 2).round(3)
    array([-0.132, -0.517, -1.24 ])
    """
    width = roughness_of(roughness)
    angles, weights = _panels(width, filter_order(order))
    slope = _lobe(angles, width) * ((angles / width) ** 2 / 2 - 2) / width
    return _legendre_sums(angles, 2 * math.pi * weights * np.sin(angles) * slope, order)


def microfacet_gaussian(roughness: float, order: int, form: Gaussian = "matched") -> NDArray[np.float64]:
    r"""Return a Gaussian in the degree that stands for a microfacet filter, (order + 1,).

    ========= ================================ ===============================================
    form      f_l                              from
    ========= ================================ ===============================================
    "paper"   exp(-(sigma l)^2)                Ramamoorthi & Hanrahan 2004, equation 92
    "linear"  exp(-sigma^2 l (l + 1))          the same with equation 86's own l (l + 1)
    "matched" f_0 (f_1 / f_0)^(l (l + 1) / 2)  the Gaussian of the sphere with exact f_0 and f_1
    ========= ================================ ===============================================

    The paper's is coarse for a rough surface: at sigma = .3, l = 1 the exact value is .791, the paper's .914, the
    linear form's .835. (Equation 87, behind it, lacks a factor sqrt(2 / (pi l)).) The largest errors over all degrees,
    for sigma = .1, .2, .3: paper .044, .091, .139; linear .007, .026, .059; matched 2e-6, 4e-5, .0015.

    Parameters
    ----------
    roughness
        sigma, in radians, above 0 and at most 100.
    order
        The highest degree l, at least 0.
    form
        Which of the three.

    Raises
    ------
    HarmonicFaceError
        A roughness that is not between 1e-100 and 100, a negative order, an unknown form.

    Examples
    --------
    >>> [float(microfacet_gaussian(0.3, 1, form)[1].round(3)) for form in ("paper", "linear", "matched")]
    [0.914, 0.835, 0.791]
    """
    width = roughness_of(roughness)
    degree = np.arange(filter_order(order) + 1.0)
    if form == "paper":
        return np.exp(-((width * degree) ** 2))
    if form == "linear":
        return np.exp(-(width**2) * degree * (degree + 1))
    if form == "matched":
        energy, first = microfacet_filter(width, 1)
        return np.asarray(energy * np.exp(degree * (degree + 1) / 2 * math.log(first / energy)))
    raise HarmonicFaceError(f"form: expected paper, linear or matched, got {_validate.describe(form)}")


def _lobe(angles: Floats, width: float) -> Floats:
    """Return the lobe at an angle from the normal."""
    return np.asarray(np.exp(-((angles / (2 * width)) ** 2)) / (4 * math.pi * width**2))


@cache
def _gauss() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the nodes and weights of one panel from 0 to 1."""
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    return (nodes + 1) / 2, weights / 2


def _panels(width: float, order: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return angles and weights that integrate the lobe times any P_l up to the order: three waves a panel at most."""
    end = min(math.pi / 2, 2 * FARTHEST * width)
    panels = 6 + math.ceil(order * end / (6 * math.pi))
    nodes, weights = _gauss()
    starts = np.arange(panels)[:, None]
    return (end / panels * (starts + nodes)).ravel(), np.tile(end / panels * weights, panels)


def _legendre_sums(angles: Floats, weights: Floats, order: int) -> NDArray[np.float64]:
    """Return the sum of weight P_l(cos(angle)) for each degree.

    What recurs is P_l - P_(l-1) with 1 - cos(angle) = 2 sin(angle / 2)^2, because a cosine near 1 has lost its digits.
    """
    result = np.empty(order + 1)
    fallen = 2 * np.sin(angles / 2) ** 2
    current, step = np.ones_like(angles), np.zeros_like(angles)
    for degree in range(order + 1):
        result[degree] = weights @ current
        step = (degree * step - (2 * degree + 1) * fallen * current) / (degree + 1)
        current = current + step
    return result
