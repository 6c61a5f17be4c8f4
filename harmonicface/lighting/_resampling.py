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

    Each sample counts with the area of its part of the pixel, so the whole light keeps its strength.
    """
    target.require_memory(shape)
    widest = float(np.sqrt(target.solid_angles(shape).max()))
    each = max(1, math.ceil(2 * widest / spacing))
    fractions = (np.arange(each) + 0.5) / each
    total: Floats | float = 0.0
    weights: Floats | float = 0.0
    for down in fractions:
        for across in fractions:
            values = sample(target.directions(shape, across, down))
            area = target.area_element(shape, across, down)
            weight = area if area.ndim == values.ndim else area[..., None]
            total = total + weight * values
            weights = weights + weight
    # outside the disc of a light probe there is no area and no light
    return np.asarray(np.divide(total, weights, out=np.zeros_like(total), where=np.asarray(weights) > 0))
