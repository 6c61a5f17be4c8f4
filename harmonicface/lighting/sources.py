"""Lights with an exact irradiance: from given directions, and from everywhere alike."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.lighting._clamped_cosine import sum_clamped_cosine
from harmonicface.lighting._rotation import rotation_matrix
from harmonicface.lighting.light import BRIGHTEST, Light, no_coefficients, require_at_most, scaled


@dataclass(frozen=True, eq=False)
class DirectionalLights(Light):
    """Light from a finite set of directions: one lamp, or hundreds that stand for a window.

    Parameters
    ----------
    directions
        (n, 3) vectors from the surface to the light, of any length above 0.
    strengths
        (n,) or (n, 3) irradiances that each gives to a surface facing it, 0 to 1e30.

    Raises
    ------
    HarmonicFaceError
        A direction of zero length, a strength that is negative, not finite or beyond 1e30, unlike counts.

    Examples
    --------
    >>> lamp = DirectionalLights([[0, 0, 2]], [1.0])
    >>> lamp.irradiance([[0.0, 0.0, 1.0], [0.0, 0.6, 0.8], [0.0, 0.0, -1.0]])
    array([1. , 0.8, 0. ])
    """

    directions: Floats
    strengths: Floats

    def __post_init__(self) -> None:
        directions = _validate.directions(self.directions, "directions")
        strengths = _validate.finite(self.strengths, "strengths")
        if directions.ndim != 2 or len(directions) == 0:
            raise HarmonicFaceError(f"directions: expected shape (n, 3), got {directions.shape}")
        if strengths.shape not in ((len(directions),), (len(directions), 3)):
            n = len(directions)
            raise HarmonicFaceError(f"strengths: expected shape ({n},) or ({n}, 3), got {strengths.shape}")
        if strengths.min() < 0:
            raise HarmonicFaceError(f"strengths: expected at least 0, got {strengths.min():.4g}")
        object.__setattr__(self, "directions", directions)
        require_at_most(BRIGHTEST, strengths, "strengths")
        object.__setattr__(self, "strengths", strengths)

    @property
    def channels(self) -> int:
        return 1 if self.strengths.ndim == 1 else 3

    def irradiance(self, normals: ArrayLike) -> Floats:
        return sum_clamped_cosine(_validate.unit_normals(normals, "normals"), self.directions, self.strengths)

    def coefficients(self, order: int = 2) -> Floats:
        harmonics = real_harmonics(self.directions.astype(np.float64), order)
        return np.asarray(harmonics @ self.strengths.astype(np.float64))

    def rotated(self, rotation: Any) -> DirectionalLights:
        return DirectionalLights(self.directions @ rotation_matrix(rotation).T, self.strengths)

    def __mul__(self, factor: ArrayLike) -> DirectionalLights:
        return DirectionalLights(self.directions, scaled(self.strengths, factor, self.channels == 3))


@dataclass(frozen=True, eq=False)
class AmbientLight(Light):
    """The same light from everywhere.

    Parameters
    ----------
    strength
        The irradiance it gives to every surface, one number or three (colours), 0 to 1e30: pi times its radiance.

    Raises
    ------
    HarmonicFaceError
        A strength that is negative, not finite, beyond 1e30, or neither one number nor three.

    Examples
    --------
    >>> AmbientLight(0.5).irradiance([[0.0, 1.0, 0.0]])
    array([0.5])
    """

    strength: Floats

    def __post_init__(self) -> None:
        strength = _validate.finite(self.strength, "strength")
        if strength.shape not in ((), (3,)):
            raise HarmonicFaceError(f"strength: expected one number or three, got {_validate.describe(strength)}")
        if strength.min() < 0:
            raise HarmonicFaceError(f"strength: expected at least 0, got {strength.min():.4g}")
        require_at_most(BRIGHTEST, strength, "strength")
        object.__setattr__(self, "strength", strength)

    @property
    def channels(self) -> int:
        return 1 if self.strength.ndim == 0 else 3

    def irradiance(self, normals: ArrayLike) -> Floats:
        unit = _validate.unit_normals(normals, "normals")
        return np.broadcast_to(self.strength, unit.shape[:-1] + self.strength.shape).astype(unit.dtype)

    def coefficients(self, order: int = 2) -> Floats:
        result = no_coefficients(order, self.strength.shape)
        result[0] = self.strength / np.pi * np.sqrt(4 * np.pi)  # radiance times the integral of Y_00
        return result

    def rotated(self, rotation: Any) -> AmbientLight:
        rotation_matrix(rotation)
        return self

    def __mul__(self, factor: ArrayLike) -> AmbientLight:
        return AmbientLight(scaled(self.strength, factor, self.channels == 3))
