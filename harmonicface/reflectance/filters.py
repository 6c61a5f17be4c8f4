"""Materials as filters: how much of each degree of the light a surface lets through."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from harmonicface._memory import require
from harmonicface.harmonics.indexing import count, degrees
from harmonicface.reflectance._arguments import filter_order


def lambertian_filter(order: int) -> NDArray[np.float64]:
    r"""Return A_l of a matte surface, with E_lm = A_l L_lm for irradiance E and radiance L.

    .. math:: A_0 = \pi, \quad A_1 = 2\pi/3, \quad A_l = 0 \;(l > 1, \text{odd}), \quad
              A_{l+2} = -\frac{l - 1}{l + 4} A_l \;(l \ge 2, \text{even}), \quad A_2 = \pi/4

    The harmonic coefficients of max(cos, 0) (Ramamoorthi & Hanrahan, On the relationship between radiance and
    irradiance, 2001, equation 19; Basri & Jacobs 2003, equation 8), scaled by sqrt(4 pi / (2l + 1)), which in the
    former's equation 26 stands beside their A_l. For even l

    .. math:: A_l = 2\pi \frac{(-1)^{l/2 - 1}}{(l + 2)(l - 1)} \frac{l!}{2^l ((l/2)!)^2}
              \to 2 \sqrt{2\pi} \, (-1)^{l/2 - 1} \, l^{-5/2}

    so |A_4 / A_0| is 4.2 % (not the "about 1 %" of Ramamoorthi, Modeling Illumination Variation with Spherical
    Harmonics, 2005). The recurrence multiplies by less than one and neither overflows nor loses digits at any degree.

    Parameters
    ----------
    order
        The highest degree l, at least 0.

    Returns
    -------
    array
        (order + 1,) numbers A_0 ... A_order.

    Raises
    ------
    HarmonicFaceError
        A negative order, or one beyond what an array should hold.

    Examples
    --------
    >>> (lambertian_filter(4) / np.pi).round(6)
    array([ 1.      ,  0.666667,  0.25    ,  0.      , -0.041667])
    """
    result = np.zeros(filter_order(order) + 1)
    result[:2] = [math.pi, 2 * math.pi / 3][: order + 1]
    if order >= 2:
        result[2] = math.pi / 4
    for degree in range(2, order - 1, 2):
        result[degree + 2] = -(degree - 1) / (degree + 4) * result[degree]
    return result


def lambertian_weights(order: int) -> NDArray[np.float64]:
    """Return A_l for each stored harmonic (l, m), ((order + 1)^2,).

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
    >>> lambertian_weights(1).round(4)
    array([3.1416, 2.0944, 2.0944, 2.0944])
    """
    require(16 * count(order), f"weights of order {order}")
    return np.asarray(lambertian_filter(order)[degrees(order)])
