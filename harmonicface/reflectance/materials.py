"""Glossy materials: a lobe about the mirror direction, on top of the matte skin."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.reflectance._arguments import at_least_zero, roughness_of
from harmonicface.reflectance.fresnel import fresnel, index_of
from harmonicface.reflectance.microfacet import microfacet_filter, microfacet_lobe
from harmonicface.reflectance.phong import phong_filter, phong_lobe

LEFT_OUT = 0.01  # of the filter's f_0: what harmonics above the highest degree may still let through
HIGHEST_DEGREE = 200  # 40,401 harmonics


class Material(ABC):
    """What shines on a surface: a lobe, the same lobe as a filter on the light, and how strong it is at an angle."""

    @abstractmethod
    def lobe(self, cosines: ArrayLike) -> Floats:
        """Return the lobe in 1 / steradian at cosines of the angle from the mirror direction."""

    @abstractmethod
    def filter(self, order: int) -> NDArray[np.float64]:
        """Return f_l of the lobe, (order + 1,)."""

    @abstractmethod
    def reflectance(self, cosines: ArrayLike) -> Floats:
        """Return the share of the light in the lobe that is thrown back, at cosines of view and normal."""

    @property
    @abstractmethod
    def width(self) -> float:
        """Standard deviation of the lobe along one axis, in radians, of its Gaussian near the peak."""

    def highest_degree(self) -> int:
        """Return the degree above which every f_l is at most 1 % of f_0.

        Raises
        ------
        HarmonicFaceError
            A lobe so narrow that it lies beyond degree 200.
        """
        factors = np.abs(self.filter(2 * HIGHEST_DEGREE))
        highest = int(np.flatnonzero(factors > LEFT_OUT * factors[0])[-1])
        if highest > HIGHEST_DEGREE:
            raise HarmonicFaceError(
                f"material: expected a lobe wide enough for harmonics up to degree {HIGHEST_DEGREE}, got one of "
                f"{math.degrees(self.width):.2g} degrees; without an order it is exact"
            )
        return highest


@dataclass(frozen=True)
class Phong(Material):
    """A shiny coat of any gloss, as strong at every angle.

    Its lobe is (s + 1) / (2 pi) max(R.w, 0)^s about the mirrored view R, its filter f_l that of `phong_filter`. Under
    the same light from everywhere it adds `strength` times the irradiance.

    Parameters
    ----------
    shininess
        The exponent s, at least 0: 10 for dull skin, 100 for wet, a mirror in the limit.
    strength
        The share of the light that the coat throws back, 0 to 1; 0.04 is about that of skin, plastic and varnish.

    Raises
    ------
    HarmonicFaceError
        A negative shininess, a strength that is not from 0 to 1.

    Examples
    --------
    >>> Phong(2, 0.1).filter(2).round(3)
    array([1.  , 0.75, 0.4 ])
    """

    shininess: float
    strength: float = 0.04

    def __post_init__(self) -> None:
        at_least_zero(self.shininess, "shininess")
        _validate.fraction(self.strength, "strength")

    def lobe(self, cosines: ArrayLike) -> Floats:
        """Return the lobe in 1 / steradian at cosines of the angle from the mirror direction."""
        return phong_lobe(cosines, self.shininess)

    def filter(self, order: int) -> NDArray[np.float64]:
        """Return f_l of the lobe, (order + 1,)."""
        return phong_filter(self.shininess, order)

    def reflectance(self, cosines: ArrayLike) -> Floats:
        """Return the strength: the same at every angle."""
        return np.full_like(_validate.floats(cosines, "cosines"), self.strength)

    @property
    def width(self) -> float:
        """Standard deviation of the lobe along one axis in radians, 1 / sqrt(s); of the widest lobes pi / 2."""
        return min(math.pi / 2, 1 / math.sqrt(self.shininess)) if self.shininess else math.pi / 2


@dataclass(frozen=True)
class Microfacet(Material):
    """A rough dielectric coat, brighter toward grazing views: skin, varnish, wet clay.

    The simplified Torrance-Sparrow lobe of normal exitance (`microfacet_lobe`) about the mirrored view R, times
    Fresnel's factor at the angle of view, which stands outside of the integral (Ramamoorthi & Hanrahan, A
    Signal-Processing Framework for Inverse Rendering, 2001). That the lobe grows longer toward grazing angles, masking
    between facets, and light that the coat withholds from the skin below are not modelled.

    Parameters
    ----------
    roughness
        sigma of the facets' slopes in radians, 1e-100 to 100: 0.3 for skin, 0.1 for varnish.
    refractive_index
        Above 1 to 100; 1.4 for skin: 2.8 % of the light at normal incidence.
    strength
        A factor for Fresnel's, 0 to 1.

    Raises
    ------
    HarmonicFaceError
        A roughness, refractive index or strength outside its range.

    Examples
    --------
    >>> Microfacet(0.3).reflectance([1.0, 0.2]).round(3)
    array([0.028, 0.318])
    """

    roughness: float
    refractive_index: float = 1.4
    strength: float = 1.0

    def __post_init__(self) -> None:
        roughness_of(self.roughness)
        index_of(self.refractive_index)
        _validate.fraction(self.strength, "strength")

    def lobe(self, cosines: ArrayLike) -> Floats:
        """Return the lobe in 1 / steradian at cosines of the angle from the mirror direction."""
        return microfacet_lobe(cosines, self.roughness)

    def filter(self, order: int) -> NDArray[np.float64]:
        """Return f_l of the lobe, (order + 1,)."""
        return microfacet_filter(self.roughness, order)

    def reflectance(self, cosines: ArrayLike) -> Floats:
        """Return the strength times Fresnel's factor at the angle of view."""
        return np.asarray(self.strength * fresnel(cosines, self.refractive_index))

    @property
    def width(self) -> float:
        """Standard deviation of the lobe along one axis in radians, sqrt(2) sigma; of the widest lobes pi / 2."""
        return min(math.pi / 2, math.sqrt(2) * self.roughness)
