"""From a depth map to a Surface: normals by finite differences."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces.surface import Surface


def surface_from_depth(
    depth: ArrayLike,
    albedo: ArrayLike = 0.5,
    pixel_size: float = 1.0,
    mask: NDArray[np.bool_] | None = None,
) -> Surface:
    """Return the Surface of a depth map.

    n is (-dz/dx, -dz/dy, 1) scaled to unit length. The slopes are central differences inside and one-sided ones at the
    border of the mask; nothing is taken from pixels outside. A pixel that has no neighbour in the mask beside it, or
    none above or below it, has no normal and is left outside.

    Parameters
    ----------
    depth
        (h, w) heights in world units, larger nearer the camera; NaN where there is no surface.
    albedo
        (h, w) or (h, w, 3) linear reflectances, or one number for all.
    pixel_size
        World units a pixel.
    mask
        (h, w) booleans; by default every pixel that is not NaN.

    Returns
    -------
    Surface
        Its normals have the type of the depth, float32 or float64.

    Raises
    ------
    HarmonicFaceError
        Arrays of another shape, infinite depth, NaN inside a given mask, or no pixel with neighbours.

    Examples
    --------
    >>> slope = np.tile(np.arange(3.0), (3, 1))  # rises to the right by one pixel a pixel
    >>> surface_from_depth(slope).normals[1, 1].round(4) + 0.0
    array([-0.7071,  0.    ,  0.7071])
    """
    heights = _validate.floats(depth, "depth")
    if heights.ndim != 2 or heights.size == 0:
        raise HarmonicFaceError(f"depth: expected shape (h, w), got {_validate.describe(heights)}")
    shape = (heights.shape[0], heights.shape[1])
    if np.isinf(heights).any():
        raise HarmonicFaceError("depth: expected finite heights, or NaN for no surface, got infinity")
    inside = _validate.mask(~np.isnan(heights) if mask is None else mask, "mask", shape)
    _validate.finite(heights[inside], "depth")
    step = _validate.positive(pixel_size, "pixel_size")
    right = _slopes(heights, inside)
    down = _slopes(heights.T, inside.T).T
    normals = np.stack([-right / step, down / step, np.ones(shape)], axis=2)  # y points up, rows point down
    known = inside & np.isfinite(normals).all(axis=2)
    if not known.any():
        raise HarmonicFaceError("depth: expected pixels with neighbours beside and above or below them, got none")
    normals[~known] = 0
    normals[known] /= np.linalg.norm(normals[known], axis=1, keepdims=True)
    reflectances = _validate.floats(albedo, "albedo")
    if reflectances.ndim == 0:
        reflectances = np.full(shape, reflectances, dtype=heights.dtype)
    return Surface(normals.astype(heights.dtype), reflectances, known, heights, step)


def _slopes(heights: Floats, inside: NDArray[np.bool_]) -> Floats:
    """Return the change of height from column to column, NaN where the mask has no neighbour."""
    padded = np.full((heights.shape[0], heights.shape[1] + 2), np.nan)
    padded[:, 1:-1] = np.where(inside, heights, np.nan)
    steps = np.diff(padded, axis=1)  # to the pixel from its left neighbour, and from the pixel to its right one
    from_left, to_right = steps[:, :-1], steps[:, 1:]
    both = (from_left + to_right) / 2
    return np.where(np.isnan(from_left), to_right, np.where(np.isnan(to_right), from_left, both))
