"""References without rounding: harmonics and harmonic images as sums of fractions, without recursion."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from harmonicface.bench.stability.exact import Long, as_long, rationals

PI = np.longdouble("3.14159265358979323846264338327950288")


def harmonics(direction: ArrayLike, degree: int) -> Long:
    r"""Return Y_lm of one degree, m = -l ... l, at one direction, from the powers of z and of x + iy.

    .. math:: P_l(z) = 2^{-l} \sum_k (-1)^k \binom{l}{k} \binom{2l - 2k}{l} z^{l - 2k}

    differentiated |m| times, times the real or imaginary part of (x + iy)^|m|: sums of fractions, without recursion.

    Examples
    --------
    >>> harmonics([0.0, 0.0, 1.0], 1).astype(float).round(6).tolist()
    [0.0, 0.488603, 0.0]
    """
    x, y, z = rationals(direction)
    legendre = [Fraction(0)] * (degree + 1)
    for k in range(degree // 2 + 1):
        legendre[degree - 2 * k] = Fraction(
            (-1) ** k * math.comb(degree, k) * math.comb(2 * degree - 2 * k, degree), 2**degree
        )
    values: dict[int, np.longdouble] = {}
    real, imaginary = Fraction(1), Fraction(0)
    for mode in range(degree + 1):
        if mode:
            legendre = [power * number for power, number in enumerate(legendre)][1:]
            real, imaginary = x * real - y * imaginary, x * imaginary + y * real
        value = _polynomial(legendre, z)
        norm = Fraction((2 * degree + 1) * (1 if mode == 0 else 2), 4)
        norm *= Fraction(math.factorial(degree - mode), math.factorial(degree + mode))
        values[mode] = _root(value * real, norm)
        values[-mode] = values[mode] if mode == 0 else _root(value * imaginary, norm)
    return np.array([values[mode] for mode in range(-degree, degree + 1)])


def harmonics_up_to(directions: ArrayLike, order: int) -> Long:
    """Return the harmonics up to an order at directions (n, 3), ((order + 1)^2, n)."""
    each = np.asarray(directions, np.float64)
    columns = [np.concatenate([harmonics(one, degree) for degree in range(order + 1)]) for one in each]
    return np.stack(columns, axis=1)


def harmonic_pictures(normals: ArrayLike, albedo: ArrayLike = 1.0, order: int = 2) -> Long:
    """Return the harmonic images A_l albedo Y_lm of pixels (p, 3), ((order + 1)^2, p), in extended precision."""
    weights = np.repeat(clamped_cosine(order), 2 * np.arange(order + 1) + 1)
    return np.asarray(harmonics_up_to(normals, order) * weights[:, None] * np.asarray(albedo, np.longdouble))


def clamped_cosine(order: int) -> Long:
    r"""Return A_l = 2 pi \int_0^1 z P_l(z) dz, with the integral as a fraction.

    Examples
    --------
    >>> (clamped_cosine(4) / PI).astype(float).round(6).tolist()
    [1.0, 0.666667, 0.25, 0.0, -0.041667]
    """
    found = []
    for degree in range(order + 1):
        total = Fraction(0)
        for k in range(degree // 2 + 1):
            number = (-1) ** k * math.comb(degree, k) * math.comb(2 * degree - 2 * k, degree)
            total += Fraction(number, 2**degree * (degree - 2 * k + 2))
        found.append(2 * PI * as_long(total))
    return np.array(found)


def _polynomial(coefficients: Sequence[Fraction], z: Fraction) -> Fraction:
    """Evaluate by Horner's rule in integers."""
    top, bottom = z.numerator, z.denominator
    common = math.lcm(*(number.denominator for number in coefficients))
    total, scale = 0, 1
    for number in reversed(coefficients):
        total = total * top + int(number * common) * scale
        scale *= bottom
    return Fraction(total * bottom, scale * common)


def _root(value: Fraction, square: Fraction) -> Any:
    """Return value * sqrt(square / pi)."""
    root = np.sqrt(as_long(value * value * square) / PI)
    return -root if value < 0 else root
