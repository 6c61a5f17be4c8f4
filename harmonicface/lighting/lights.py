"""Lights by name: `hf.lights.directional([1, 1, 1])`, `hf.lights.natural(seed=0)`; they add with +."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _validate
from harmonicface.lighting.discs import DiscLight
from harmonicface.lighting.natural import natural
from harmonicface.lighting.published import published
from harmonicface.lighting.sources import AmbientLight, DirectionalLights

__all__ = ["ambient", "area", "cone", "directional", "from_angles", "natural", "published", "sky"]


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
    return DirectionalLights(
        np.atleast_2d(_validate.vectors(direction, "direction")), _validate.floats(strength, "strength")[None]
    )


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
    return AmbientLight(_validate.floats(strength, "strength"))


def area(direction: ArrayLike, radius: float, strength: ArrayLike = 1.0) -> DiscLight:
    """Return a disc of even radiance: the sun, a window, a lamp shade.

    Parameters
    ----------
    direction
        (3,) toward its centre, of any length above 0.
    radius
        Its angular radius in degrees, above 0 to 180; the sun's is 0.27.
    strength
        The irradiance it gives to a surface facing it, one number or three (colours), at least 0.

    Raises
    ------
    HarmonicFaceError
        A direction of zero length, a radius outside 0 to 180, a negative strength, anything not finite.

    Examples
    --------
    >>> area([0, 0, 1], 30).irradiance([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]).round(4)
    array([1.    , 0.1153, 0.    ])
    """
    return DiscLight(_validate.floats(direction, "direction"), radius, _validate.floats(strength, "strength"))


def cone(direction: ArrayLike, radius: float, strength: ArrayLike = 1.0) -> DiscLight:
    """Return light from all directions within an angle of one: another name of `area`.

    Examples
    --------
    >>> cone([0, 0, 1], 90).radius
    90.0
    """
    return area(direction, radius, strength)


def sky(strength: ArrayLike = 1.0, up: ArrayLike = (0.0, 1.0, 0.0)) -> DiscLight:
    r"""Return an even hemisphere, an overcast sky over dark ground: E(n) = strength (1 + n.up) / 2.

    Parameters
    ----------
    strength
        The irradiance it gives to a surface that faces up, one number or three (colours), at least 0.
    up
        (3,) toward the zenith, of any length above 0.

    Raises
    ------
    HarmonicFaceError
        A direction of zero length, a negative strength, anything not finite.

    Examples
    --------
    >>> sky().irradiance([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]).round(12)
    array([1. , 0.5, 0. ])
    """
    return DiscLight(_validate.floats(up, "up"), 90.0, _validate.floats(strength, "strength"))
