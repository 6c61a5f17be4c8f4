"""The Phong material: a lobe of any shininess about the mirror direction, as a filter on light."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.reflectance._arguments import at_least_zero, filter_order

Gaussian = Literal["paper", "linear", "matched"]
SLACK = 2.1e-3  # of a cosine, since unit vectors may be off by a thousandth each


def phong_lobe(cosines: ArrayLike, shininess: float) -> Floats:
    r"""Return the transfer function (s + 1) / (2 pi) max(R.L, 0)^s, whose integral over the sphere is 1.

    The normalized form of Ramamoorthi & Hanrahan 2004, equation 75, about the reflection vector R; the horizon of
    the surface is not cut away.

    Parameters
    ----------
    cosines
        (...) cosines R.L, from -1 to 1.
    shininess
        The exponent s, at least 0; 0 is a constant over the half sphere about R.

    Returns
    -------
    array
        (...) values in 1 / steradian.

    Raises
    ------
    HarmonicFaceError
        A negative shininess, cosines that are not finite or beyond -1 to 1.

    Examples
    --------
    >>> phong_lobe([1.0, 0.5, -0.5], 2).round(4)
    array([0.4775, 0.1194, 0.    ])
    """
    exponent = at_least_zero(shininess, "shininess")
    values = _validate.finite(cosines, "cosines")
    if values.size and np.abs(values).max() > 1 + SLACK:
        raise HarmonicFaceError(
            f"cosines: expected numbers from -1 to 1, got {values.flat[np.abs(values).argmax()]:.6g}"
        )
    return np.asarray((exponent + 1) / (2 * math.pi) * np.where(values > 0, _power(np.maximum(values, 0), exponent), 0))


def _power(values: Floats, exponent: float) -> Floats:
    """Return a power; in single precision by logarithms, five times as fast and right to s |log u| roundings."""
    if values.dtype != np.float32:
        return np.asarray(values**exponent)
    result = np.log(np.maximum(values, np.float32(1e-37)))
    result *= np.float32(exponent)
    return np.asarray(np.exp(result, out=result))


def phong_filter(shininess: float, order: int) -> NDArray[np.float64]:
    r"""Return f_l = Lambda_l rho_l of a Phong lobe, with B_lm = f_l L_lm about the reflection vector.

    .. math:: f_l = (s + 1) \int_0^1 u^s P_l(u) du, \quad f_0 = 1, \quad f_1 = \frac{s + 1}{s + 2}, \quad
              f_l = \frac{s - l + 2}{s + l + 1} f_{l-2}

    (Ramamoorthi & Hanrahan 2004, equations 76 to 78.) No factor exceeds one, so nothing overflows at any degree
    and each value is right to a few times l rounding errors; what is below the smallest float is 0. For a whole s the
    degrees l > s of the same parity are exactly 0. The rest of the tail falls as

    .. math:: f_l \to \Gamma(s + 2) \sqrt{2 / \pi} \, \sin(\pi (l - s) / 2) \, l^{-(s + 3/2)}

    A matte surface is s = 1: its filter is pi times this one.

    Parameters
    ----------
    shininess
        The exponent s, any real number of at least 0.
    order
        The highest degree l, at least 0.

    Returns
    -------
    array
        (order + 1,) numbers f_0 = 1 ... f_order.

    Raises
    ------
    HarmonicFaceError
        A negative shininess or order.

    Examples
    --------
    >>> phong_filter(2, 4).round(6)
    array([1.   , 0.75 , 0.4  , 0.125, 0.   ])
    >>> bool(phong_filter(50, 5)[5].round(3) == 0.747)
    True
    """
    exponent = at_least_zero(shininess, "shininess")
    result = np.ones(filter_order(order) + 1)
    degree = np.arange(1, order + 1)
    ratios = (exponent - degree + 2) / (exponent + degree + 1)
    result[1::2] = np.cumprod(ratios[0::2])
    result[2::2] = np.cumprod(ratios[1::2])
    return result + 0.0  # a zero has no sign


def phong_sensitivity(shininess: float, order: int) -> NDArray[np.float64]:
    r"""Return df_l / ds, how a Phong filter changes with its shininess, (order + 1,).

    The derivative of the two-step product, exact also where f_l itself is 0.

    Parameters
    ----------
    shininess
        The exponent s, any real number of at least 0.
    order
        The highest degree l, at least 0.

    Raises
    ------
    HarmonicFaceError
        A negative shininess or order.

    Examples
    --------
    >>> phong_sensitivity(1, 2).round(6)
    array([0.      , 0.111111, 0.1875  ])
    """
    exponent = at_least_zero(shininess, "shininess")
    values = phong_filter(exponent, order)
    result = np.zeros_like(values)
    for degree in range(1, len(values)):
        below, slope = (values[degree - 2], result[degree - 2]) if degree > 1 else (1.0, 0.0)
        total = exponent + degree + 1
        result[degree] = (exponent - degree + 2) / total * slope + (2 * degree - 1) / total / total * below
    return result


def phong_gaussian(shininess: float, order: int, form: Gaussian = "matched") -> NDArray[np.float64]:
    r"""Return a Gaussian in the degree that stands for a Phong filter, (order + 1,).

    ========= ============================ ==================================================
    form      f_l                          from
    ========= ============================ ==================================================
    "paper"   exp(-l^2 / 2s)               Ramamoorthi & Hanrahan 2004, equation 81
    "linear"  exp(-l (l + 1) / 2s)         the same with the term that equation 80 leaves out
    "matched" f_1^(l (l + 1) / 2)          the Gaussian of the sphere that has the exact f_1
    ========= ============================ ==================================================

    Equation 80 lacks the term linear in l: at s = 50, l = 5 the exact value is .747, the paper's .779, the linear
    form's .741 and the matched form's .747. exp(-t l (l + 1)) is heat that has spread over a sphere for a time t; two
    such blurs after each other add their t. The largest errors over all degrees, for s = 10, 50, 200: paper .050,
    .033, .019; linear .042, .009, .002; matched .016, .0035, .0009.

    Parameters
    ----------
    shininess
        The exponent s, above 0.
    order
        The highest degree l, at least 0.
    form
        Which of the three.

    Raises
    ------
    HarmonicFaceError
        A shininess that is not above 0, a negative order, an unknown form.

    Examples
    --------
    >>> [float(phong_gaussian(50, 5, form)[5].round(3)) for form in ("paper", "linear", "matched")]
    [0.779, 0.741, 0.747]
    """
    exponent = _validate.positive(shininess, "shininess")
    degree = np.arange(filter_order(order) + 1.0)
    if form == "paper":
        return np.exp(-(degree**2) / (2 * exponent))
    if form == "linear":
        return np.exp(-degree * (degree + 1) / (2 * exponent))
    if form == "matched":
        return np.exp(degree * (degree + 1) / 2 * -math.log1p(1 / (exponent + 1)))
    raise HarmonicFaceError(f"form: expected paper, linear or matched, got {_validate.describe(form)}")
