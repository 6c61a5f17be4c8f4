"""Lights by name: `hf.lights.directional([1, 1, 1])`, `hf.lights.natural(seed=0)`; they add with +."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _validate
from harmonicface.lighting.natural import natural
from harmonicface.lighting.sources import AmbientLight, DirectionalLights

__all__ = ["ambient", "directional", "from_angles", "natural"]


def directional(direction: ArrayLike, strength: ArrayLike = 1.0) -> DirectionalLights:
    """Return one distant lamp.

    Parameters
    ----------
    direction
        (3,) from the surface to the light, of any length above 0: x right, y up, z toward the camera.
    strength
        The irradiance it gives to a surface facing it, one number or three (colours), at least 0.

    Raises
    ------
    HarmonicFaceError
        A direction of zero length, a negative strength, anything not finite.

    Examples
    --------
    >>> directional([0, 0, 1]).irradiance([0.0, 0.6, 0.8])
    array(0.8)
    """
    return DirectionalLights(np.atleast_2d(_validate.vectors(direction, "direction")), np.asarray(strength)[None])


def from_angles(azimuth: float, elevation: float, strength: ArrayLike = 1.0) -> DirectionalLights:
    """Return one distant lamp at angles in degrees, seen from the face.

    Parameters
    ----------
    azimuth
        Degrees from straight ahead to the right of the picture (+x).
    elevation
        Degrees up (+y).
    strength
        The irradiance it gives to a surface facing it.

    Raises
    ------
    HarmonicFaceError
        Angles that are not finite, a negative strength.

    Examples
    --------
    >>> from_angles(90, 0).directions.round(6) + 0.0
    array([[1., 0., 0.]])
    """
    across, up = np.radians(_validate.finite([azimuth, elevation], "azimuth and elevation"))
    return directional([np.sin(across) * np.cos(up), np.sin(up), np.cos(across) * np.cos(up)], strength)


def ambient(strength: ArrayLike = 1.0) -> AmbientLight:
    """Return the same light from everywhere.

    Parameters
    ----------
    strength
        The irradiance it gives to every surface, one number or three (colours), at least 0.

    Raises
    ------
    HarmonicFaceError
        A negative strength, anything not finite.

    Examples
    --------
    >>> ambient(0.3).irradiance([0.0, 0.0, -1.0])
    array(0.3)
    """
    return AmbientLight(np.asarray(strength))
