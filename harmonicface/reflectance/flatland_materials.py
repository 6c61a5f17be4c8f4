"""Lights and materials of flatland in closed form: filters f_l = sqrt(2 pi) rho_l with B_l = f_l L_l.

All are even in l; degrees -order ... order are stored at l + order.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.special import poch, wofz

from harmonicface import _validate
from harmonicface._memory import require
from harmonicface.reflectance._arguments import at_least_zero, filter_order, roughness_of
from harmonicface.reflectance.flatland_series import Complexes, fourier_basis


def flat_directional(angle: float, order: int) -> Complexes:
    r"""Return L_l = F_l^*(angle) of a unit light from one angle: of the same size at each degree.

    The twin of Ramamoorthi & Hanrahan 2004, equation 63.

    Parameters
    ----------
    angle
        Where the light comes from, in radians.
    order
        The highest degree l, at least 0.

    Raises
    ------
    HarmonicFaceError
        An angle that is not finite, a negative order.

    Examples
    --------
    >>> np.abs(flat_directional(0.3, 1)).round(4)
    array([0.3989, 0.3989, 0.3989])
    """
    return fourier_basis(angle, order).conj()


def flat_uniform(order: int) -> Complexes:
    r"""Return L_l of the same light from everywhere, of total 1: only L_0 = 1 / sqrt(2 pi) is not 0.

    The twin of Ramamoorthi & Hanrahan 2004, equation 65.

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
    >>> flat_uniform(1).real.round(4)
    array([0.    , 0.3989, 0.    ])
    """
    result = np.zeros(2 * filter_order(order) + 1, np.complex128)
    result[order] = 1 / math.sqrt(2 * math.pi)
    return result


def flat_lambertian(order: int) -> NDArray[np.float64]:
    r"""Return the filter of a matte surface, \int_{-\pi/2}^{\pi/2} cos(theta) cos(l theta) dtheta.

    .. math:: f_0 = 2, \quad f_{\pm 1} = \pi / 2, \quad f_l = \frac{2 (-1)^{l/2 + 1}}{l^2 - 1} \; (l \text{ even}),
              \quad f_l = 0 \; (|l| > 1, \text{odd})

    As on the sphere the odd degrees above 1 vanish; the even ones fall as l^-2 instead of l^-5/2. Degrees up to 2 hold
    99.53 % of the energy.

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
    >>> flat_lambertian(4)[4:].round(4)
    array([ 2.    ,  1.5708,  0.6667,  0.    , -0.1333])
    """
    degree = np.arange(filter_order(order) + 1)
    half = np.zeros(order + 1)
    even = degree[::2].astype(np.float64)
    half[::2] = 2 * (1 - 2 * (degree[::2] // 2 % 2)) / (1 - even**2)
    half[1:2] = math.pi / 2
    return _mirrored(half)


def flat_mirror(order: int, outgoing_order: int, both_sides: bool = False) -> NDArray[np.float64]:
    r"""Return rho_lp of a mirror about the normal, which sends theta_i to theta_o = -theta_i.

    .. math:: \hat\rho_{lp} = \frac{1}{2\pi} \int_{-\pi/2}^{\pi/2} e^{i (l + p) \theta} d\theta
              = \frac{\sin((l + p) \pi / 2)}{(l + p) \pi}

    which is 1/2 for p = -l and not diagonal: the twin of Ramamoorthi & Hanrahan 2004, equation 66, whose delta holds
    for a mirror that reflects on both sides. About the reflection vector a mirror is 1 at each degree.

    Parameters
    ----------
    order, outgoing_order
        The highest degrees of l and p.
    both_sides
        Whether the lower half circle reflects as well.

    Raises
    ------
    HarmonicFaceError
        A negative order, more than the memory holds.

    Examples
    --------
    >>> flat_mirror(1, 1, both_sides=True)
    array([[0., 0., 1.],
           [0., 1., 0.],
           [1., 0., 0.]])
    """
    order, outgoing_order = filter_order(order), filter_order(outgoing_order)
    entries = (2 * order + 1) * (2 * outgoing_order + 1)
    require(40 * entries, f"mirror of order {order} by {outgoing_order}")
    incident = np.arange(-order, order + 1)
    total = np.add.outer(incident, np.arange(-outgoing_order, outgoing_order + 1))
    if both_sides:
        return np.asarray(total == 0, np.float64)
    return np.asarray(
        np.where(total % 2 == 0, total == 0, np.sinc(total / 2)) / 2, np.float64
    )  # exactly 0 at even degrees


def flat_phong(shininess: float, order: int) -> NDArray[np.float64]:
    r"""Return the filter of the lobe cos(theta)^s about the reflection vector, of unit energy.

    .. math:: f_l = \frac{\Gamma(1 + s/2)^2}{\Gamma(1 + (s + l)/2) \Gamma(1 + (s - l)/2)}, \quad
              f_l = \frac{s - l + 2}{s + l} f_{l-2}

    That is what Ramamoorthi & Hanrahan 2004 arrive at in equation 79 for large s (with s/2 for 1 + s/2): their Gaussian
    exp(-l^2 / 2s) without a term linear in l belongs to flatland, where exp(-l^2 / (2s + 2)) is nearer still. Whole
    s: zeros at the degrees l > s of the same parity, as on the sphere.

    Parameters
    ----------
    shininess
        The exponent s, any real number of at least 0.
    order
        The highest degree, at least 0.

    Raises
    ------
    HarmonicFaceError
        A negative shininess or order.

    Examples
    --------
    >>> flat_phong(2, 4)[4:].round(4)
    array([1.    , 0.8488, 0.5   , 0.1698, 0.    ])
    """
    exponent = at_least_zero(shininess, "shininess")
    half = np.ones(filter_order(order) + 1)
    degree = np.arange(2, order + 1)
    ratios = (exponent - degree + 2) / (exponent + degree)
    half[1:2] = float(poch(0.5 + exponent / 2, 0.5)) / float(poch(1 + exponent / 2, 0.5))
    half[2::2] = np.cumprod(ratios[0::2])
    half[3::2] = half[1:2] * np.cumprod(ratios[1::2])
    return _mirrored(half + 0.0)  # a zero has no sign


def flat_phong_gaussian(shininess: float, order: int, shifted: bool = True) -> NDArray[np.float64]:
    r"""Return exp(-l^2 / (2s + 2)), or the papers' exp(-l^2 / 2s) if not `shifted`, in place of `flat_phong`.

    Their largest errors over all degrees, for s = 10, 50, 1000: .017, .0036, 1.8e-4 and .027, .0053, 2.7e-4.

    Parameters
    ----------
    shininess
        The exponent s, above 0.
    order
        The highest degree l, at least 0.
    shifted
        Which of the two.

    Raises
    ------
    HarmonicFaceError
        A shininess that is not above 0, a negative order.

    Examples
    --------
    >>> filters = flat_phong(50, 5), flat_phong_gaussian(50, 5), flat_phong_gaussian(50, 5, shifted=False)
    >>> [round(float(values[-1]), 4) for values in filters]
    [0.7823, 0.7826, 0.7788]
    """
    exponent = _validate.positive(shininess, "shininess")
    degree = np.arange(filter_order(order) + 1.0)
    return _mirrored(np.exp(-(degree**2) / (2 * exponent + 2 * shifted)))


def flat_microfacet(roughness: float, order: int) -> NDArray[np.float64]:
    r"""Return the filter of the lobe exp(-(theta / 2 sigma)^2) / (2 sigma sqrt(pi)) over the upper half circle.

    .. math:: f_l = e^{-(\sigma l)^2} \; \mathrm{Re} \, \mathrm{erf}\left(\frac{\pi}{4\sigma} + i \sigma l\right)

    The exp(-(sigma l)^2) of Ramamoorthi & Hanrahan 2004, equation 92, is exact in flatland but for the horizon.

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
    >>> flat_microfacet(0.1, 10)[[10, 11, 20]].round(4)
    array([1.    , 0.99  , 0.3679])
    """
    width = roughness_of(roughness)
    degree = np.arange(filter_order(order) + 1.0)
    end, wave = math.pi / (4 * width), width * degree
    # erf by the scaled function, so that no huge number meets a tiny one; its phase 2 end wave is l pi / 2
    turn = np.array([1, -1j, -1, 1j])[np.arange(order + 1) % 4]
    return _mirrored(np.exp(-(wave**2)) - math.exp(-(end**2)) * np.real(turn * wofz(1j * end - wave)))


def _mirrored(half: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return degrees -order ... order of a filter that is even in the degree."""
    return np.concatenate([half[:0:-1], half])
