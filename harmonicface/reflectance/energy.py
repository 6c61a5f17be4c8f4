"""How much of a reflection the first degrees hold: on average, at the least, and at the worst pixel."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.reflectance._arguments import at_least_zero, filter_order, filter_values
from harmonicface.reflectance.filters import lambertian_filter

LAMBERTIAN_ENERGY = 2 * math.pi / 3  # the integral of max(cos, 0)^2 over the sphere


def phong_energy(shininess: float) -> float:
    r"""Return the squared integral of a Phong lobe, (s + 1)^2 / (2 pi (2s + 1)).

    Parameters
    ----------
    shininess
        The exponent s, any real number of at least 0.

    Raises
    ------
    HarmonicFaceError
        A negative shininess.

    Examples
    --------
    >>> round(phong_energy(1) * np.pi**2 / LAMBERTIAN_ENERGY, 12)
    1.0
    """
    exponent = at_least_zero(shininess, "shininess")
    return (exponent + 1) * ((exponent + 1) / (2 * exponent + 1)) / (2 * math.pi)


def degree_energies(filter_: ArrayLike) -> NDArray[np.float64]:
    r"""Return what each degree holds of the transfer function's squared integral, (2l + 1) f_l^2 / (4 pi).

    It is also what it holds of the reflection of a directional light, over all normals (Parseval).

    Parameters
    ----------
    filter_
        (order + 1,) numbers f_l.

    Raises
    ------
    HarmonicFaceError
        A filter that is not one finite number a degree.

    Examples
    --------
    >>> (100 * degree_energies(lambertian_filter(4)) / LAMBERTIAN_ENERGY).round(2)
    array([37.5 , 50.  , 11.72,  0.  ,  0.59])
    """
    values = filter_values(filter_)
    return np.asarray((2 * np.arange(len(values)) + 1) * values**2 / (4 * math.pi), np.float64)


def energy_captured(filter_: ArrayLike, total: float) -> NDArray[np.float64]:
    r"""Return which part of a filter's energy the degrees up to each order hold.

    .. math:: F_n = \sum_{l \le n} \frac{2l + 1}{4\pi} f_l^2 \; / \int |\hat\rho|^2

    Lambertian: 37.5, 87.5, 99.22, 99.22, 99.80 ... % (Basri & Jacobs 2003, table 1). That is the part of the picture's
    energy, over all normals, under one directional light, the hardest of all lights for a filter that falls; the RMS
    error there is sqrt(1 - F_n) of the picture: 8.8 % at order 2.

    Parameters
    ----------
    filter_
        (order + 1,) numbers f_l.
    total
        The squared integral of the transfer function: `LAMBERTIAN_ENERGY`, `phong_energy(shininess)`, or any other.

    Returns
    -------
    array
        (order + 1,) fractions, 0 to 1.

    Raises
    ------
    HarmonicFaceError
        A total below what the filter's own degrees hold, NaN or infinity.

    Examples
    --------
    >>> (100 * energy_captured(lambertian_filter(4), LAMBERTIAN_ENERGY)).round(2)
    array([37.5 , 87.5 , 99.22, 99.22, 99.8 ])
    """
    held = np.cumsum(degree_energies(filter_))
    whole = _validate.positive(total, "total")
    if held[-1] > whole * (1 + 1e-9):
        raise HarmonicFaceError(f"total: expected at least the {held[-1]:.6g} that these degrees hold, got {whole:.6g}")
    return np.asarray(np.minimum(held / whole, 1))


def least_energy_captured(filter_: ArrayLike, total: float) -> NDArray[np.float64]:
    r"""Return the part of a reflection's energy that each order holds at the least, whatever the non-negative light.

    .. math:: \frac{e_0}{e_0 + \sum_{l > n} e_l}, \quad e_l = \frac{2l + 1}{4 \pi} f_l^2

    The reflection's energy is \sum_l f_l^2 P_l with P_l = \sum_m L_lm^2. By the addition theorem P_l is the double
    integral of L(u) L(v) (2l + 1) / (4 pi) P_l(u.v), and with L >= 0 and |P_l(u.v)| <= 1 that is at most
    (2l + 1) P_0. The part held is least where every held degree but 0 is empty and every other one full. No light does
    all of that at once, so it is a bound and not a minimum. Lambertian: 37.5, 75, 97.96, 97.96, 99.48 ... %
    (Basri & Jacobs 2003, table 1).

    Parameters
    ----------
    filter_, total
        As of `energy_captured`.

    Raises
    ------
    HarmonicFaceError
        As of `energy_captured`.

    Examples
    --------
    >>> (100 * least_energy_captured(lambertian_filter(4), LAMBERTIAN_ENERGY)).round(2)
    array([37.5 , 75.  , 97.96, 97.96, 99.48])
    """
    captured = energy_captured(filter_, total)
    return np.asarray(captured[0] / (captured[0] + 1 - captured))


def worst_pixel_error(filter_: ArrayLike, lobe: Callable[[Floats], Floats]) -> float:
    r"""Return the largest error of any pixel under any non-negative light, as a fraction of the light's total.

    .. math:: \max_u \; | \hat\rho(u) - \sum_l \frac{2l + 1}{4\pi} f_l P_l(u) |

    The error of a pixel is the integral of L times the error of the transfer function at n.w, so at most the largest
    error times \int L; light from the one direction where it is largest attains it.

    Parameters
    ----------
    filter_
        (order + 1,) numbers f_l: the series that is used.
    lobe
        The whole transfer function of the cosine u, vectorized; its kinks and jumps at u = -1, 0 and 1 only.

    Returns
    -------
    float
        In the transfer function's own unit: Lambertian irradiance, 0.09375 at order 2.

    Raises
    ------
    HarmonicFaceError
        A filter that is not one finite number a degree, a lobe that is no function, not finite or not vectorized.

    Examples
    --------
    >>> worst_pixel_error(lambertian_filter(2), lambda cosine: np.maximum(cosine, 0)).__round__(5)
    0.09375
    """
    values = filter_values(filter_)
    if not callable(lobe):
        raise HarmonicFaceError(f"lobe: expected a function of cosines, got {_validate.describe(lobe)}")
    series = (2 * np.arange(len(values)) + 1) * values / (4 * math.pi)

    def error(angle: Floats) -> Floats:
        cosine = np.cos(angle)
        exact = _validate.finite(lobe(cosine), "lobe")
        if exact.shape != cosine.shape:
            raise HarmonicFaceError(f"lobe: expected values of shape {cosine.shape}, got {_validate.describe(exact)}")
        return np.asarray(np.abs(np.polynomial.legendre.legval(cosine, series) - exact))

    worst = 0.0
    for start in (0.0, math.pi / 2):
        angles = start + np.linspace(1e-12, math.pi / 2 - 1e-12, 64 * len(values) + 1)
        for _ in range(4):  # each round looks between the neighbours of the largest
            errors = error(angles)
            peak = int(errors.argmax())
            worst = max(worst, float(errors[peak]))
            angles = np.linspace(angles[max(peak - 1, 0)], angles[min(peak + 1, len(angles) - 1)], 65)
    return worst


def lambertian_pixel_error(order: int) -> float:
    r"""Return the worst pixel error of a matte surface's irradiance, as a fraction of the light's total.

    1/4 at order 1, 3/32 = 9.375 % at order 2 (Ramamoorthi & Hanrahan, An Efficient Representation for Irradiance
    Environment Maps, 2001, section 3.1: "9 %"): where the light grazes the surface.

    Parameters
    ----------
    order
        The highest degree used, at least 0.

    Raises
    ------
    HarmonicFaceError
        A negative order.

    Examples
    --------
    >>> round(lambertian_pixel_error(2), 9)
    0.09375
    """
    return worst_pixel_error(lambertian_filter(filter_order(order)), lambda cosine: np.maximum(cosine, 0))
