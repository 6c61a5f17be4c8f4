"""Redrawing a map in another layout without aliasing."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.lighting.layout import Layout, Shape


def resampled(
    sample: Callable[[NDArray[np.float64]], Floats], spacing: float, target: Layout, shape: Shape
) -> NDArray[np.float64]:
    """Return the mean radiance of each pixel of a map, from samples at most half of `spacing` (radians) apart.

    Each sample counts with the solid angle of its part of the pixel, so the whole light keeps its strength.
    """
    each = max(1, math.ceil(2 * target.spacing(shape) / spacing))
    fine = target.solid_angles((*shape[:-2], shape[-2] * each, shape[-1] * each))
    total: float | Floats = 0.0
    for down in range(each):
        for across in range(each):
            values = sample(target.directions(shape, (across + 0.5) / each, (down + 0.5) / each))
            total = total + _each_colour(fine[..., down::each, across::each], values) * values
    whole = np.maximum(target.solid_angles(shape), np.finfo(float).tiny)  # 0 outside the disc of a light probe
    return np.asarray(total / _each_colour(whole, np.asarray(total)))


def _each_colour(angles: NDArray[np.float64], values: Floats) -> NDArray[np.float64]:
    """Give angles of pixels the shape of values that may have colours."""
    return angles if angles.ndim == values.ndim else angles[..., None]
