"""Redrawing a map in another layout without aliasing."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.lighting.layout import Layout, Shape


def resampled(sample: Callable[[NDArray[np.float64]], Floats], spacing: float, target: Layout, shape: Shape) -> Floats:
    """Return the mean of samples in each pixel of a map; they are at most half of `spacing` (radians) apart."""
    each = max(1, math.ceil(2 * target.spacing(shape) / spacing))
    fractions = (np.arange(each) + 0.5) / each
    samples = (sample(target.directions(shape, across, down)) for down in fractions for across in fractions)
    first = next(samples)
    total = first.astype(np.float64)
    for values in samples:
        total += values
    total[target.solid_angles(shape) == 0] = 0  # outside the disc of a light probe
    return (total / each**2).astype(first.dtype)
