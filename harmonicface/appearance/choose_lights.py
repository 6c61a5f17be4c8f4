"""The power of light by degree, beyond the order to which its statistics are known."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.appearance.choose_images import FARTHEST
from harmonicface.appearance.principal_lights import HIGHEST_ORDER, Lights, LightStatistics
from harmonicface.harmonics.indexing import count, degrees
from harmonicface.io.colour import luminance
from harmonicface.lighting.as_light import as_light
from harmonicface.lighting.light import Light

Array = NDArray[np.float64]

KNOWN_ORDER = 24  # to which the power of given lights is computed
NAMED = ("sphere", "frontal", "natural")


def light_power(lights: Lights, statistics: LightStatistics) -> Array:
    """Return the mean square of a light coefficient by its degree, (201,).

    Up to order 12 it is that of the statistics; of given lights, their own up to order 24. Above, it goes on by the
    power of the degree that fits the upper half of what is known, or stays (lamps are as strong in every degree).
    """
    moment = np.diag(statistics.moment)
    known = _by_degree(moment, HIGHEST_ORDER)
    if isinstance(lights, Light) or (isinstance(lights, (str, list, tuple)) and lights not in NAMED):
        several = lights if isinstance(lights, (list, tuple)) else [lights]
        squares = np.mean([_grey(as_light(one).coefficients(KNOWN_ORDER)) ** 2 for one in several], axis=0)
        known = np.concatenate([known, _by_degree(squares, KNOWN_ORDER)[HIGHEST_ORDER + 1 :]])
    upper = np.arange(len(known) // 2, len(known))
    beyond = np.arange(len(known), FARTHEST + 1)
    if (known[upper] <= 0).any():
        return np.concatenate([known, np.zeros(len(beyond))])
    slope, start = np.polyfit(np.log(upper), np.log(known[upper]), 1)
    return np.concatenate([known, np.exp(start + min(slope, 0.0) * np.log(beyond))])


def _grey(coefficients: Floats) -> Array:
    """Return coefficients (k,) of grey light, in float64."""
    grey = luminance(coefficients) if coefficients.ndim == 2 else coefficients
    return np.asarray(grey, np.float64)


def _by_degree(squares: Array, order: int) -> Array:
    """Return the mean over the modes of each degree, (order + 1,)."""
    sums = np.bincount(degrees(order), np.maximum(squares[: count(order)], 0))
    return np.asarray(sums / (2 * np.arange(order + 1) + 1))
