"""Harmonics of one block of directions, small enough for the cache; each says how long its vectors are."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from harmonicface._validate import Floats

Lengths = tuple[Any, Any]
Kernel = Callable[[Floats, Floats], Lengths]
ScaledKernel = Callable[[Floats, Floats, Floats], None]

# Constants of order 2, and a scale that makes the products xy, yz, xz harmonics without further factors.
CONSTANT = math.sqrt(1 / (4 * math.pi))
LINEAR = math.sqrt(3 / (4 * math.pi))
MIXED = math.sqrt(15 / (4 * math.pi))
SCALE = math.sqrt(MIXED)
ZONAL = math.sqrt(5 / (16 * math.pi))


def low_harmonics(order: int, size: int, dtype: np.dtype[Any]) -> Kernel:
    """Return a function that writes the harmonics of order 0, 1 or 2 of up to `size` directions, (n, 3) into (k, n).

    Three rows of scratch, no temporaries, and as few calls as possible, since each costs as much as thousands of
    numbers. The function returns the least and the largest squared length of the directions (NaN if one is not a
    number).
    """
    scratch = np.empty((3, size), dtype)
    scale, linear, half, zonal, offset, constant = (
        np.array(number, dtype) for number in (SCALE, LINEAR / SCALE, 0.5, 3 * ZONAL / MIXED, ZONAL, CONSTANT)
    )

    def write(directions: Floats, out: Floats) -> Lengths:
        planes = scratch[:, : len(directions)]
        y, z, x = planes  # in the order of the linear harmonics
        np.multiply(directions.T[1:], scale, out=planes[:2])
        np.multiply(directions.T[0], scale, out=x)
        out[0] = constant
        if order >= 1:
            np.multiply(planes, linear, out=out[1:4])
        if order == 2:
            np.multiply(planes[1:], y, out=out[5:3:-1])  # yz and xy
            np.multiply(x, z, out=out[7])
        np.multiply(planes, planes, out=planes)  # squares from here on
        if order == 2:
            np.multiply(z, zonal, out=out[6])
            np.subtract(out[6], offset, out=out[6])
            np.subtract(x, y, out=out[8])
            np.multiply(out[8], half, out=out[8])
        np.add(x, y, out=x)
        np.add(x, z, out=x)
        return np.minimum.reduce(x) / MIXED, np.maximum.reduce(x) / MIXED

    return write


def scaled_low_harmonics(weights: Floats, size: int) -> ScaledKernel:
    """Return a function that writes w_l f Y_lm of order 0, 1 or 2: directions (n, 3) and factors f (n,) into (k, n).

    The factors go in before the products are made, which costs less than another pass over the result.
    """
    order, dtype = len(weights) - 1, weights.dtype
    scratch = np.empty((7, size), dtype)
    constant, linear, mixed = (
        np.array(number * weight, dtype)
        for number, weight in zip((CONSTANT, LINEAR, MIXED), [*weights, 0, 0], strict=False)
    )
    zonal, third, half = (np.array(number, dtype) for number in (3 * ZONAL / MIXED, 1 / 3, 0.5))

    def write(directions: Floats, factors: Floats, out: Floats) -> None:
        planes, scaled, factor = scratch[:3, : len(factors)], scratch[3:6, : len(factors)], scratch[6, : len(factors)]
        np.multiply(factors, constant, out=out[0])
        if order >= 1:
            planes[:2], planes[2] = directions.T[1:], directions.T[0]  # in the order of the linear harmonics
            np.multiply(factors, linear, out=factor)
            np.multiply(planes, factor, out=out[1:4])
        if order == 2:
            y, z = planes[:2]
            np.multiply(factors, mixed, out=factor)
            np.multiply(planes, factor, out=scaled)
            np.multiply(scaled[1:], y, out=out[5:3:-1])  # yz and xy
            np.multiply(scaled[2], z, out=out[7])
            np.multiply(scaled, planes, out=scaled)  # squares from here on
            np.multiply(factor, third, out=factor)
            np.subtract(scaled[1], factor, out=out[6])
            np.multiply(out[6], zonal, out=out[6])
            np.subtract(scaled[2], scaled[0], out=out[8])
            np.multiply(out[8], half, out=out[8])

    return write


def all_harmonics(order: int) -> Kernel:
    """Return a function that writes the harmonics up to an order, (n, 3) into ((order + 1)^2, n), by recursion."""

    def write(directions: Floats, out: Floats) -> Lengths:
        x, y, z = np.ascontiguousarray(directions.T)
        cosine, sine = np.ones_like(x), np.zeros_like(x)  # sin(theta)^m times cos(m phi) and sin(m phi)
        for mode in range(order + 1):
            if mode:
                cosine, sine = x * cosine - y * sine, x * sine + y * cosine
            _fill_mode(out, z, cosine, sine, mode, order)
        squared = x * x + y * y + z * z
        return squared.min(), squared.max()

    return write


def _fill_mode(out: Floats, z: Floats, cosine: Floats, sine: Floats, mode: int, order: int) -> None:
    """Write the harmonics +-mode of every degree, by the normalized three-term recursion in the degree.

    What recurs is N P_l^m / sin(theta)^m, a polynomial in z, so that nothing is divided at the poles.
    """
    below: Floats | None = None
    current: Floats = np.full_like(z, _sectoral(mode))
    for degree in range(mode, order + 1):
        if degree > mode:
            step, back = recursion(degree, mode)
            following = z * current
            if below is not None:
                following -= back * below
            following *= step
            below, current = current, following
        centre = degree * (degree + 1)
        np.multiply(current, cosine, out=out[centre + mode])
        if mode:
            np.multiply(current, sine, out=out[centre - mode])


def _sectoral(mode: int) -> float:
    """Return Y_mm over (sin(theta)^m cos(m phi)), by a product that stays near one."""
    squared = 1 / (4 * math.pi)
    for k in range(1, mode + 1):
        squared *= (2 * k + 1) / (2 * k)
    return math.sqrt(squared * (2 if mode else 1))


def recursion(degree: int, mode: int) -> tuple[float, float]:
    """Return a and b of P_l = a (z P_(l-1) - b P_(l-2)) for normalized associated Legendre functions."""
    step = math.sqrt((4 * degree**2 - 1) / (degree**2 - mode**2))
    back = math.sqrt(((degree - 1) ** 2 - mode**2) / (4 * (degree - 1) ** 2 - 1))
    return step, back
