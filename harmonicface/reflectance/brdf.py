r"""Materials as functions of two directions (BRDFs), and the conventions of everything that is made of them.

**Directions.** A BRDF sees *local* directions: unit vectors in the frame of the surface, x along the tangent, y along
the bitangent, z along the normal. `incoming` points to the light, `outgoing` to the eye; theta is the angle with z
and phi the azimuth from x toward y. Everything else sees *global* directions, in the package's axes.

**Orientation.** A normal has the polar angle alpha from the global z and the azimuth beta from x toward y:
n = (sin alpha cos beta, sin alpha sin beta, cos alpha). The tangent frame is turned by gamma about it, and
R = Rz(beta) Ry(alpha) Rz(gamma) takes local to global directions: R z = n, and R x is the tangent. Where
the material is isotropic gamma only says where phi begins, and is 0.

**Reflection.** The reflected radiance and its two transfer functions are

.. math:: B(\alpha, \beta, \gamma, \omega_o) = \int L(R\,\omega_i)\, \hat\rho(\omega_i, \omega_o)\, d\omega_i, \qquad
          \hat\rho = \rho \cos\theta_i, \quad \tilde\rho = \rho \cos\theta_i \cos\theta_o, \quad
          \tilde B = B \cos\theta_o

with both zero where either direction is below the horizon. The second, the *reciprocal* form, is symmetric when the
BRDF is, stays finite where a BRDF has 1 / (cos theta_i cos theta_o) in it, and is what this package expands unless told
otherwise; then all that is computed is B cos(theta_o).

**Expansion.** In complex harmonics Y_lm (with the Condon-Shortley phase, orthonormal):

.. math:: L = \sum L_{lm} Y_{lm}, \qquad
          \tilde\rho = \sum \tilde\rho_{ln,pq}\, Y^*_{ln}(\omega_i)\, Y_{pq}(\omega_o), \qquad
          Y_{lm}(R\,\omega) = \sum_{n} D^l_{mn}(R)\, Y_{ln}(\omega)

so that l, m belong to the light, l, n to the incoming, and p, q to the outgoing direction. An isotropic BRDF that is
its own mirror image (a function of |phi_o - phi_i|) has n = q only, real numbers, and the same for q and -q: it
is stored as rho[l, p, q] for q >= 0. These are the same numbers in real harmonics, so the package's real harmonics
do the work and complex numbers appear only where a formula of the paper has them. With Lambda_l = sqrt(4 pi / (2l + 1))

.. math:: B_{lmpq} = \Lambda_l L_{lm} \rho_{lpq}, \qquad B_{lmnpq} = \sqrt{8\pi^2/(2l+1)}\, L_{lm} \rho_{ln,pq}

multiply the orthonormal functions Lambda_l^-1 D^l_mq(alpha, beta, 0) Y_pq and sqrt((2l+1) / 8 pi^2) D^l_mn Y_pq.

**Source.** Ramamoorthi & Hanrahan, A Signal-Processing Framework for Reflection, 2004 ("the paper" in this room):
equations 25-27 and 32-53. Where it cannot be followed to the letter: (a) of the microfacet model (equation 83)
only the reciprocal form has finite coefficients; (b) reciprocity of an anisotropic BRDF reads
rho_ln,pq = conj(rho_pq,ln), the paper leaves out the conjugate (section 4.3.2); (c) the mirror (equation 66) is
(-1)^q delta_lp only if it is taken over the whole sphere: over the half sphere the diagonal is (-1)^q / 2, and where
l - p is odd nothing vanishes; (d) its Phong model (equation 75) is a transfer function without a horizon, not
reciprocal as a BRDF: here `Phong` is the reciprocal one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.reflectance._arguments import roughness_of

Brdf = Callable[[NDArray[Any], NDArray[Any]], Any]
FORMS = ("reciprocal", "transfer", "kernel")


@dataclass(frozen=True)
class Lambertian:
    r"""A matte material: rho = albedo / pi.

    Parameters
    ----------
    albedo
        The fraction of the light that is reflected, 0 to 1.

    Raises
    ------
    HarmonicFaceError
        An albedo that is not from 0 to 1.

    Examples
    --------
    >>> up = np.array([0.0, 0.0, 1.0])
    >>> round(float(Lambertian(0.5)(up, up)), 6)
    0.159155
    """

    albedo: float = 1.0

    def __post_init__(self) -> None:
        _validate.fraction(self.albedo, "albedo")

    def __call__(self, incoming: ArrayLike, outgoing: ArrayLike) -> Floats:
        """Return rho in 1/sr for local unit directions (..., 3) that broadcast; 0 below the horizon."""
        return np.where(_both_above(*_directions(incoming, outgoing)), self.albedo / math.pi, 0.0)


@dataclass(frozen=True)
class Phong:
    r"""A glossy lobe about the mirror direction, reciprocal: rho = (s + 2) / (2 pi) max(R . w_i, 0)^s.

    R is the mirror image of the outgoing direction. The factor makes all light return at normal incidence (Lewis,
    Making shaders more physically plausible, 1993). The paper's equation 75 has (s + 1) and takes the lobe for the
    transfer function itself.

    Parameters
    ----------
    shininess
        The exponent s, above 0.

    Raises
    ------
    HarmonicFaceError
        A shininess that is not above 0.

    Examples
    --------
    >>> up = np.array([0.0, 0.0, 1.0])
    >>> round(float(Phong(20)(up, up)), 6)
    3.501409
    """

    shininess: float

    def __post_init__(self) -> None:
        _validate.positive(self.shininess, "shininess")

    def __call__(self, incoming: ArrayLike, outgoing: ArrayLike) -> Floats:
        """Return rho in 1/sr for local unit directions (..., 3) that broadcast; 0 below the horizon."""
        incoming, outgoing = _directions(incoming, outgoing)
        (ix, iy, iz), (ox, oy, oz) = _axes(incoming), _axes(outgoing)
        cosine = np.maximum(iz * oz - ix * ox - iy * oy, 0.0)
        lobe = (self.shininess + 2) / (2 * math.pi) * cosine**self.shininess
        return np.where(_both_above(incoming, outgoing), lobe, 0.0)


@dataclass(frozen=True)
class Microfacet:
    r"""A rough mirror, Torrance-Sparrow without Fresnel and shadowing (the paper's equation 83).

    .. math:: \rho = \frac{1}{4\pi\sigma^2 \cos\theta_i \cos\theta_o} \exp\left(-(\theta_h / \sigma)^2\right)

    with theta_h the angle of the half-way vector. It is infinite at grazing angles, its reciprocal form is not.

    Parameters
    ----------
    roughness
        The width sigma in radians, 1e-100 to 100.

    Raises
    ------
    HarmonicFaceError
        A roughness that is not from 1e-100 to 100.

    Examples
    --------
    >>> up = np.array([0.0, 0.0, 1.0])
    >>> round(float(Microfacet(0.3)(up, up)), 6)
    0.884194
    """

    roughness: float

    def __post_init__(self) -> None:
        roughness_of(self.roughness)

    def __call__(self, incoming: ArrayLike, outgoing: ArrayLike) -> Floats:
        """Return rho in 1/sr for local unit directions (..., 3) that broadcast; 0 below the horizon."""
        incoming, outgoing = _directions(incoming, outgoing)
        (ix, iy, iz), (ox, oy, oz) = _axes(incoming), _axes(outgoing)
        above = _both_above(incoming, outgoing)
        half = np.arctan2(np.hypot(ix + ox, iy + oy), iz + oz)
        cosines = np.where(above, iz * oz, 1.0)
        lobe = np.exp(-((half / self.roughness) ** 2)) / (4 * math.pi * self.roughness**2 * cosines)
        return np.where(above, lobe, 0.0)


@dataclass(frozen=True)
class Ward:
    r"""Brushed metal: a Gaussian lobe with two widths (Ward, Measuring and modeling anisotropic reflection, 1992).

    .. math:: \rho = \frac{\exp\left(-\tan^2\theta_h (\cos^2\phi_h / a_x^2 + \sin^2\phi_h / a_y^2)\right)}
                     {4\pi a_x a_y \sqrt{\cos\theta_i \cos\theta_o}}

    Parameters
    ----------
    along, across
        The widths a_x along the tangent and a_y across it, in slope, 1e-100 to 100. Equal widths: an isotropic
        material.

    Raises
    ------
    HarmonicFaceError
        A width that is not from 1e-100 to 100.

    Examples
    --------
    >>> up = np.array([0.0, 0.0, 1.0])
    >>> round(float(Ward(0.2, 0.5)(up, up)), 6)
    0.795775
    """

    along: float
    across: float

    def __post_init__(self) -> None:
        roughness_of(self.along, "along", "a slope")
        roughness_of(self.across, "across", "a slope")

    def __call__(self, incoming: ArrayLike, outgoing: ArrayLike) -> Floats:
        """Return rho in 1/sr for local unit directions (..., 3) that broadcast; 0 below the horizon."""
        incoming, outgoing = _directions(incoming, outgoing)
        (ix, iy, iz), (ox, oy, oz) = _axes(incoming), _axes(outgoing)
        above = _both_above(incoming, outgoing)
        slopes = ((ix + ox) / self.along) ** 2 + ((iy + oy) / self.across) ** 2
        exponent = slopes / np.where(above, (iz + oz) ** 2, 1.0)
        scale = 4 * math.pi * self.along * self.across * np.sqrt(np.where(above, iz * oz, 1.0))
        return np.where(above, np.exp(-exponent) / scale, 0.0)


def values(brdf: Brdf, incoming: Floats, outgoing: Floats, form: str = "reciprocal") -> Floats:
    """Return a BRDF in one of its forms at local directions, checked.

    Parameters
    ----------
    brdf
        A function of (incoming, outgoing), local unit vectors (..., 3) that broadcast, to finite numbers >= 0 in 1/sr.
    incoming, outgoing
        Local unit vectors, (..., 3).
    form
        "reciprocal": rho cos(theta_i) cos(theta_o); "transfer": rho cos(theta_i); both 0 below the horizon.
        "kernel": what the function returns, on the whole sphere, as for a transfer function without a horizon.

    Returns
    -------
    array
        The values, of the shape that the directions broadcast to.

    Raises
    ------
    HarmonicFaceError
        No function; values that are NaN, infinite, negative or of another shape; an unknown form.

    Examples
    --------
    >>> up = np.array([0.0, 0.0, 1.0])
    >>> round(float(values(Lambertian(), up, np.array([0.0, 0.6, 0.8]))) * np.pi, 6)
    0.8
    """
    check_form(form)
    if not callable(brdf):
        raise HarmonicFaceError(f"brdf: expected a function of (incoming, outgoing), got {_validate.describe(brdf)}")
    incoming, outgoing = _directions(incoming, outgoing)
    shape = np.broadcast_shapes(incoming.shape, outgoing.shape)[:-1]
    result = _validate.floats(brdf(incoming, outgoing), "brdf's values")
    if result.shape != shape:
        raise HarmonicFaceError(f"brdf: expected values of shape {shape}, got {_validate.describe(result)}")
    _validate.finite(result, "brdf's values")
    if result.size and result.min() < 0:
        raise HarmonicFaceError(f"brdf: expected values of at least 0, got {result.min():.6g}")
    if form == "kernel":
        return result
    cosine = incoming[..., 2] * outgoing[..., 2] if form == "reciprocal" else incoming[..., 2]
    return np.where(_both_above(incoming, outgoing), result * cosine, 0.0)


def check_form(form: str) -> str:
    """Return the name of a form of a BRDF if it is one."""
    if form not in FORMS:
        raise HarmonicFaceError(f"form: expected one of {', '.join(FORMS)}, got {_validate.describe(form)}")
    return form


def _directions(incoming: ArrayLike, outgoing: ArrayLike) -> tuple[Floats, Floats]:
    """Return two arrays of finite vectors that broadcast."""
    incoming, outgoing = _validate.vectors(incoming, "incoming"), _validate.vectors(outgoing, "outgoing")
    try:
        np.broadcast_shapes(incoming.shape, outgoing.shape)
    except ValueError:
        raise HarmonicFaceError(
            f"outgoing: expected directions that broadcast with incoming ones of shape {incoming.shape}, "
            f"got {_validate.describe(outgoing)}"
        ) from None
    return incoming, outgoing


def _axes(directions: Floats) -> tuple[Floats, Floats, Floats]:
    """Return x, y and z of directions."""
    return directions[..., 0], directions[..., 1], directions[..., 2]


def _both_above(incoming: Floats, outgoing: Floats) -> NDArray[np.bool_]:
    """Return where both directions are above the horizon."""
    return np.asarray((incoming[..., 2] > 0) & (outgoing[..., 2] > 0))
