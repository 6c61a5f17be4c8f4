"""The harmonic coefficients of a latitude-longitude map: along rows they are sines and cosines."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import count, index
from harmonicface.harmonics.rotation import rotate
from harmonicface.lighting.latlong import row_angles

# x, y, z of the map are y, z, x of a frame whose pole is up, where harmonics are products of rows and columns
TO_POLAR = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
ROWS_FIRST = 3  # up to this order, one product of all rows with a few functions is the shortest way
BLOCK = 1 << 17  # numbers of the map read at once


def latlong_coefficients(radiance: Floats, order: int) -> NDArray[np.float64]:
    r"""Return the sum of radiance times solid angle times Y_lm(pixel), ((order + 1)^2,) or (..., 3).

    .. math:: L'_{lm} = \sum_{rows} N P_l^{|m|}(y) \, \Delta\omega \sum_{columns} L \{\cos m\phi, \sin m\phi\}

    in the frame with its pole up (+y), then turned to the axes of the camera. Each number of the map is read once.
    """
    height, width = radiance.shape[:2]
    planes = radiance.reshape(height, width, -1)
    polar = _rows_first(planes, order) if order <= ROWS_FIRST else _columns_first(planes, order)
    return _from_polar(polar, order).reshape(count(order), *radiance.shape[2:])


def _rows_first(planes: Floats, order: int) -> NDArray[np.float64]:
    """Sum over rows, in the type of the map within a block and in float64 over blocks, then over columns."""
    height, width, colours = planes.shape
    functions, waves = _kept_functions(height, width, order), _waves(width, order)
    chosen = [(degree, mode) for degree in range(order + 1) for mode in range(degree + 1)]
    rows = np.array([functions[index(degree, mode)] for degree, mode in chosen]).astype(planes.dtype)
    flat = planes.reshape(height, -1)
    step = max(1, BLOCK // flat.shape[1])
    sums = np.zeros((len(chosen), flat.shape[1]))
    for start in range(0, height, step):
        sums += rows[:, start : start + step] @ flat[start : start + step]
    result = np.zeros((count(order), colours))
    for (degree, mode), line in zip(chosen, sums.reshape(-1, width, colours), strict=True):
        for signed in {mode, -mode}:
            result[index(degree, signed)] = waves[order + signed] @ line
    return result


def _columns_first(planes: Floats, order: int) -> NDArray[np.float64]:
    """Sum over columns, then over rows."""
    height, width, colours = planes.shape
    functions, waves = _functions(height, width, order), _waves(width, order)
    sums = np.stack([waves @ row for row in planes])  # (rows, 2 order + 1, colours)
    result = np.zeros((count(order), colours))
    for signed in range(-order, order + 1):
        mode = abs(signed)
        kept = functions[[index(degree, mode) for degree in range(mode, order + 1)]]
        result[[index(degree, signed) for degree in range(mode, order + 1)]] = kept @ sums[:, order + signed]
    return result


def _functions(height: int, width: int, order: int) -> NDArray[np.float64]:
    """Return Y_lm at longitude 0 of the polar frame times the solid angle, ((order + 1)^2, rows)."""
    latitude = np.pi * (0.5 - (np.arange(height) + 0.5) / height)
    meridian = np.stack([np.cos(latitude), np.zeros(height), np.sin(latitude)], axis=-1)
    return np.asarray(real_harmonics(meridian, order) * row_angles(height, width))


_kept_functions = lru_cache(maxsize=8)(_functions)  # of low orders only: they are few


@lru_cache(maxsize=4)
def _waves(width: int, order: int) -> NDArray[np.float64]:
    """Return sin(|m| phi) for m < 0 and cos(m phi) for the others, (2 order + 1, columns)."""
    phi = np.pi - 2 * np.pi * ((np.arange(width) + 0.5) / width - 0.5)
    modes = np.arange(1, order + 1)[:, None]
    return np.concatenate([np.sin(modes * phi)[::-1], np.ones((1, width)), np.cos(modes * phi)])


def _from_polar(polar: NDArray[np.float64], order: int) -> NDArray[np.float64]:
    """Turn coefficients of the frame with its pole up to the camera's axes."""
    return _turn(order) @ polar if order <= 8 else np.asarray(rotate(polar, TO_POLAR.T))


@lru_cache(maxsize=8)
def _turn(order: int) -> NDArray[np.float64]:
    return np.asarray(rotate(np.eye(count(order)), TO_POLAR.T))
