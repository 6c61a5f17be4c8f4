"""Discs of even radiance: from a lamp through the sun, a window and the sky to light from everywhere."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import degrees
from harmonicface.lighting._rotation import rotation_matrix
from harmonicface.lighting.light import BRIGHTEST, Light, require_at_most, scaled

SMALL = 0.1  # radians below which the sum of a series keeps more digits than the difference of its parts
ARCTAN_SERIES = 1 / np.arange(3.0, 19.0, 2.0)


@dataclass(frozen=True, eq=False)
class DiscLight(Light):
    r"""The same radiance from every direction within an angle of one: a cone of light.

    Its irradiance is exact, also where the surface's horizon cuts the disc (see `irradiance`), and so are its
    coefficients of any order, zonal harmonics turned to the disc's direction d:

    .. math:: L_{lm} = 2 \pi L \, Y_{lm}(d) \int_{\cos\sigma}^1 P_l(t) \, dt
              = 2 \pi L \, Y_{lm}(d) \frac{\sin^2\sigma \, P_l'(\cos\sigma)}{l (l + 1)}

    Parameters
    ----------
    direction
        (3,) toward the centre of the disc, of any length above 0.
    radius
        sigma, its angular radius in degrees, above 0 to 180: 90 is a hemisphere, 180 the whole sphere.
    strength
        The irradiance it gives to a surface facing it, one number or three (colours), 0 to 1e30. The radiance is
        that over pi sin^2(sigma), from 90 degrees on over pi.

    Raises
    ------
    HarmonicFaceError
        A direction of zero length, a radius outside 0 to 180, a strength that is negative, not finite or beyond 1e30.

    Examples
    --------
    >>> sky = DiscLight([0, 1, 0], 90.0, 1.0)
    >>> sky.irradiance([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]).round(12)
    array([1. , 0.5, 0. ])
    """

    direction: Floats
    radius: float
    strength: Floats

    def __post_init__(self) -> None:
        direction = _validate.directions(self.direction, "direction")
        radius = _validate.positive(self.radius, "radius")
        strength = _validate.finite(self.strength, "strength")
        if direction.shape != (3,):
            raise HarmonicFaceError(f"direction: expected one of shape (3,), got {direction.shape}")
        if radius > 180:
            raise HarmonicFaceError(f"radius: expected degrees above 0 to 180, got {radius:g}")
        if strength.shape not in ((), (3,)):
            raise HarmonicFaceError(f"strength: expected one number or three, got {_validate.describe(strength)}")
        if strength.min() < 0:
            raise HarmonicFaceError(f"strength: expected at least 0, got {strength.min():.4g}")
        object.__setattr__(self, "direction", direction.astype(np.float64))
        object.__setattr__(self, "radius", radius)
        require_at_most(BRIGHTEST, strength, "strength")
        object.__setattr__(self, "strength", strength)

    @property
    def channels(self) -> int:
        return 1 if self.strength.ndim == 0 else 3

    @property
    def radiance(self) -> Floats:
        """The radiance inside the disc, () or (3,); HarmonicFaceError if the disc is too small for a finite one."""
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            radiance = self.strength / np.float64(math.pi * math.sin(math.radians(min(self.radius, 90.0))) ** 2)
        if not np.isfinite(radiance).all():
            raise HarmonicFaceError(f"radius: expected one of finite radiance, got {self.radius:g} degrees")
        return np.asarray(radiance)

    def irradiance(self, normals: ArrayLike) -> Floats:
        unit = _validate.unit_normals(normals, "normals")
        share = _share_of_disc(unit.astype(np.float64) @ self.direction, math.radians(self.radius))
        return np.asarray(np.multiply.outer(share, self.strength)).astype(unit.dtype)

    def coefficients(self, order: int = 2) -> Floats:
        harmonics = real_harmonics(self.direction, order)
        integrals = _cap_integrals(math.radians(self.radius), order)[degrees(order)]
        return np.asarray(np.multiply.outer(2 * integrals * harmonics, self.strength.astype(np.float64)))

    def rotated(self, rotation: Any) -> DiscLight:
        return replace(self, direction=rotation_matrix(rotation) @ self.direction)

    def __mul__(self, factor: ArrayLike) -> DiscLight:
        return replace(self, strength=scaled(self.strength, factor, self.channels == 3))


def _share_of_disc(cosine: NDArray[np.float64], sigma: float) -> NDArray[np.float64]:
    """Return the irradiance as a fraction of that of a surface facing the disc."""
    if sigma == math.pi:
        return np.ones_like(cosine)
    if sigma > math.pi / 2:  # everywhere less the disc on the other side, which is the smaller one
        return np.asarray(1 - math.sin(sigma) ** 2 * _share_of_disc(-cosine, math.pi - sigma))
    cosine = np.clip(cosine, -1.0, 1.0)
    if sigma == math.pi / 2:
        return np.asarray((1 + cosine) / 2)
    return np.where(np.abs(cosine) >= math.sin(sigma), np.maximum(cosine, 0), _cut_by_horizon(cosine, sigma))


def _cut_by_horizon(cosine: NDArray[np.float64], sigma: float) -> NDArray[np.float64]:
    r"""Return the share of a disc that the horizon cuts: |pi / 2 - theta| < sigma < pi / 2.

    By Stokes' theorem the irradiance of even radiance is half the integral of n.(w x dw) around what is seen: an arc
    of the disc's edge, between the angles -gamma and gamma, and one of the horizon. Over pi sin^2(sigma) that is

    .. math:: \frac{1}{\pi} \left[ \gamma \cos\theta + \frac{\arctan(h \tan\sigma) - h \sin\sigma \cos\sigma}
              {\sin^2\sigma} \right], \quad \cos\gamma = -\cot\sigma \cot\theta, \; h = \sin\theta \sin\gamma
    """
    sine = np.sqrt(np.maximum(1 - cosine**2, 0))
    tangent = math.tan(sigma)
    limit = np.clip(-cosine / np.maximum(sine * tangent, np.finfo(float).tiny), -1, 1)
    height = sine * np.sqrt(1 - limit**2)
    reach = height * tangent
    if sigma < SMALL:  # the difference is of third order: arctan x = x - x^3 (1/3 - x^2/5 + ...), tan - sin cos cancels
        arcs = reach * (1 - (height / math.cos(sigma)) ** 2 * polynomial.polyval(-(reach**2), ARCTAN_SERIES))
    else:
        arcs = (np.arctan(reach) - height * math.sin(sigma) * math.cos(sigma)) / math.sin(sigma) ** 2
    return np.maximum((cosine * np.arccos(limit) + arcs) / math.pi, 0)


def _cap_integrals(sigma: float, order: int) -> NDArray[np.float64]:
    """Return the integrals of P_l over the disc, over sin^2 of its radius (1 from 90 degrees on), (order + 1,)."""
    cosine = math.cos(sigma)
    scale = math.sin(sigma) ** 2 if sigma > math.pi / 2 else 1.0
    result = np.empty(order + 1)
    result[0] = 1 - cosine if sigma > math.pi / 2 else 1 / (1 + cosine)  # 2 sin^2(sigma / 2) over sin^2(sigma)
    below, current = 0.0, 1.0  # P_(l-1), P_l
    slope_below, slope = 0.0, 0.0  # their derivatives
    for degree in range(1, order + 1):
        slope_below, slope = slope, slope_below + (2 * degree - 1) * current
        below, current = current, ((2 * degree - 1) * cosine * current - (degree - 1) * below) / degree
        result[degree] = scale * slope / (degree * (degree + 1))
    return result
