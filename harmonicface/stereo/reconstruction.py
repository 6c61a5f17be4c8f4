"""Reconstruction: photographs of a person under known lights -> a Surface with depth, which can cast shadows."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from harmonicface.stereo.depth.integration import integrate_normals
from harmonicface.stereo.known.calibrated import calibrated_stereo
from harmonicface.stereo.registration import register
from harmonicface.surfaces.surface import Surface


def reconstruct(photographs: ArrayLike, lights: ArrayLike, *, registered: bool = False) -> Surface:
    """Register photographs of a person, find normals and albedo, integrate the normals to depth.

    The photographs are registered to the one among them that the others are nearest to (`register`), so that the
    Surface is where that one shows the person; photometric stereo leaves shadowed and saturated observations out
    (`calibrated_stereo`); the depth is in pixels (`integrate_normals`).

    Parameters
    ----------
    photographs
        (n, h, w) linear grey intensities, 0 to 1, n of at least 3. A value of 1 counts as saturated.
    lights
        (n, 3) directions from the person to each light (x right, y up, z toward the camera), times its brightness.
    registered
        True for photographs in which she did not move: they are taken as they are.

    Returns
    -------
    Surface
        float32 normals, albedo and depth at every pixel, pixel size 1.

    Raises
    ------
    HarmonicFaceError
        What the three steps refuse: shapes that do not fit, too few photographs, NaN, intensities beyond the range,
        lights in a plane, photographs that do not show the same person.

    Examples
    --------
    >>> lights = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, 0.6, 0.8]])
    >>> wall = np.tile(0.5 * lights @ [0.0, 0.0, 1.0], (4, 5, 1)).T  # (3, 5, 4)
    >>> surface = reconstruct(wall, lights, registered=True)
    >>> surface.albedo[0, 0].round(4), abs(surface.depth).max().round(4)
    (np.float32(0.5), np.float32(0.0))
    """
    stack = np.asarray(photographs) if registered else register(photographs).photographs
    found = calibrated_stereo(stack, lights).surface
    depth = integrate_normals(found.normals)
    return Surface(found.normals, found.albedo, found.mask, depth.astype(np.float32))
