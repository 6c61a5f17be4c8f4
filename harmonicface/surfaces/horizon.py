"""Horizon: how high the rest of a depth map stands before each pixel, by azimuth; no ray is traced."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _memory, _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces._terrain import FREE, Terrain

Doubles = NDArray[np.float64]


def horizons(depth: ArrayLike, mask: ArrayLike | None, pixel_size: float, azimuths: ArrayLike) -> Doubles:
    r"""Return the elevation angles below which the rest of a depth map hides the sky from each pixel, (a, p).

    .. math:: h(x, \phi) = \max_{s > 0} \arctan \frac{z(x + s (\cos\phi, \sin\phi)) - z(x)}{s}

    (Max, Horizon mapping: shadows for bump-mapped surfaces, 1988). The surface is solid below its depth, and between
    two neighbouring pixels it is the straight line; each line of sight is compared with it wherever it crosses a row
    or, where it advances more from column to column, a column of pixels. Outside the mask nothing blocks, and nothing
    spans the gap between a pixel and a hole.

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
        Arrays of another shape, depth that is not finite inside the mask, an empty mask, angles that are not finite,
        a result larger than the memory.

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
    terrain = Terrain.of(heights, inside, _validate.positive(pixel_size, "pixel_size"))
    count = int(inside.sum())
    result = _memory.empty((len(angles), count), np.float64, f"horizons of {count} pixels at {len(angles)} azimuths")
    for row, slopes in zip(result, horizon_slopes(terrain, angles), strict=True):
        row[:] = np.arctan(np.where(slopes < -FREE * terrain.relief, -np.inf, slopes)[inside])
    return result


def horizon_slopes(terrain: Terrain, azimuths: Doubles, floor: Iterator[Doubles] | None = None) -> Iterator[Doubles]:
    """Yield the tangents of the horizons (h, w), one azimuth after the other; not below a floor if there is one."""
    turned = terrain.transposed
    for azimuth in azimuths:
        down, right = -math.sin(azimuth), math.cos(azimuth)
        slopes = np.full(terrain.heights.shape, -np.inf) if floor is None else next(floor)
        if abs(down) >= abs(right):
            terrain.raise_slopes(slopes, down, right)
            yield slopes
        else:
            sideways = np.ascontiguousarray(slopes.T)
            turned.raise_slopes(sideways, right, down)
            yield sideways.T
