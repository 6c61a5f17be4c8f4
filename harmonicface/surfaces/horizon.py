"""Horizon: how high the rest of a depth map stands before each pixel, by azimuth; no ray is traced."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _memory, _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces._hidden_light import VERTICAL, hidden_range
from harmonicface.surfaces._terrain import FREE, Terrain

Doubles = NDArray[np.float64]

AXIS = 1e-9  # of a direction that crosses no rows, or no columns


def horizons(depth: ArrayLike, mask: ArrayLike | None, pixel_size: float, azimuths: ArrayLike) -> Doubles:
    r"""Return the elevation angles below which the rest of a depth map hides the sky from each pixel, (a, p).

    .. math:: h(x, \phi) = \max_{s > 0} \arctan \frac{z(x + s (\cos\phi, \sin\phi)) - z(x)}{s}

    (Max, Horizon mapping: shadows for bump-mapped surfaces, 1988). The surface is solid below its depth, and between
    two neighbouring pixels it is the straight line. A line of sight is compared with it where it crosses rows and
    columns of pixels: each of them up to 64 away, and farther off at distances that differ by no more than a 32nd; near
    by also where it crosses diagonals, of each square of pixels the one with the lesser step, the first four of either
    kind. Outside the mask nothing blocks, and nothing spans the gap between a pixel and a hole.

    Parameters
    ----------
    depth
        (h, w) heights in world units, larger nearer the camera; finite inside the mask.
    mask
        (h, w) booleans, true where there is a surface; None for every pixel that is not NaN.
    pixel_size
        World units a pixel.
    azimuths
        (a,) radians in the plane of the picture, from x (right) to y (up).

    Returns
    -------
    array
        (a, p) float64 radians above the plane of the picture, from -pi/2 (nothing blocks) to below pi/2; p masked
        pixels in row-major order.

    Raises
    ------
    HarmonicFaceError
        Arrays of another shape, depth that is not finite inside the mask or of more than 1e150 pixels, an empty mask,
        angles that are not finite, a result larger than the memory.

    Examples
    --------
    >>> step = np.array([[0.0, 0.0, 0.0, 3.0]])  # three units high, one to three pixels away
    >>> np.degrees(horizons(step, None, 1.0, [0.0])).round(1)
    array([[ 45. ,  56.3,  71.6, -90. ]])
    """
    heights = _validate.floats(depth, "depth")
    if heights.ndim != 2 or heights.size == 0:
        raise HarmonicFaceError(f"depth: expected shape (h, w), got {_validate.describe(heights)}")
    shape = (heights.shape[0], heights.shape[1])
    inside = _validate.mask(~np.isnan(heights) if mask is None else np.asarray(mask), "mask", shape)
    _validate.finite(heights[inside], "depth")
    angles = np.atleast_1d(_validate.finite(azimuths, "azimuths")).astype(np.float64)
    if angles.ndim != 1:
        raise HarmonicFaceError(f"azimuths: expected shape (a,), got {_validate.describe(angles)}")
    step = _validate.positive(pixel_size, "pixel_size")
    count = int(inside.sum())
    result = _memory.empty((len(angles), count), np.float64, f"horizons of {count} pixels at {len(angles)} azimuths")
    for row, slopes in zip(result, horizon_slopes(heights, inside, step, angles), strict=True):
        np.arctan(slopes, out=row)
    return result


def horizon_slopes(
    depth: Floats, mask: NDArray[np.bool_], pixel_size: float, azimuths: Doubles, normals: Floats | None = None
) -> Iterator[Doubles]:
    """Yield the tangents of the horizons (p,), one azimuth after the other.

    With normals (p, 3), tangents are at least those of the pixel's own tangent plane, below which there is nothing to
    hide, or minus VERTICAL where the normal points away from the camera.
    """
    rows, columns = (slice(found.min(), found.max() + 1) for found in np.nonzero(mask))
    depth, mask = depth[rows, columns], mask[rows, columns]
    upright, turned = Terrain.of(depth, mask, pixel_size), Terrain.of(depth.T, mask.T, pixel_size)
    slopes, sideways = np.empty(mask.shape), np.empty(mask.shape[::-1])
    for azimuth in azimuths:
        slopes.fill(np.inf)
        slopes[mask] = -np.inf if normals is None else tangent_plane(normals, azimuth)
        down, right = -math.sin(azimuth), math.cos(azimuth)
        upright.raise_near(slopes, down, right)
        if abs(down) > AXIS:
            upright.raise_slopes(slopes, down, right)
        if abs(right) > AXIS:
            sideways[:] = slopes.T
            turned.raise_slopes(sideways, right, down)
            slopes[:] = sideways.T
        found = slopes[mask]
        found[found < -FREE * upright.relief] = -np.inf
        yield found


def tangent_plane(normals: Floats, azimuth: float) -> Doubles:
    """Return the slopes of the planes with some normals (p, 3) along an azimuth; minus VERTICAL seen from below."""
    horizontal = normals[:, :2].astype(np.float64) @ np.array([math.cos(azimuth), math.sin(azimuth)])
    return hidden_range(horizontal, normals[:, 2], np.array(-VERTICAL))[0]
