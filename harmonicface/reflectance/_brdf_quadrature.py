"""Grids of angles for expanding a BRDF, refined until its coefficients settle."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import degrees

Reals = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Expansion = TypeVar("Expansion", NDArray[np.float64], NDArray[np.complex128])

MOST_ISOTROPIC, MOST_ANISOTROPIC, MOST_AT_ANGLE = 600, 100, 2000
GROWTH = 1.4
BLOCK = 2**19


def settled(expand: Callable[[int], Expansion], start: int, most: int, tolerance: float) -> Expansion:
    """Return an expansion on a grid so fine that the last refinement changed nothing by more than the tolerance."""
    _validate.positive(tolerance, "tolerance")
    nodes, most = start, max(most, refined(start))
    result = expand(nodes)
    change = math.inf
    while change > tolerance:
        if nodes >= most:
            raise HarmonicFaceError(
                f"brdf: expected coefficients that settle to {tolerance:.2g} of the largest, "
                f"got a change of {change:.2g} at {nodes} angles; give a smoother BRDF or a larger tolerance"
            )
        nodes = min(refined(nodes), most)
        finer = expand(nodes)
        largest = np.abs(finer).max()
        change = float(np.abs(finer - result).max() / largest) if largest else 0.0
        result = finer
    return result


def refined(nodes: int) -> int:
    """Return how many angles come after so many: at least the first refinement is needed for any answer."""
    return math.ceil(GROWTH * nodes)


def blocks(length: int, each: int) -> Iterator[slice]:
    """Cut a range so that a block of it, times what each of its members takes, stays small."""
    step = max(BLOCK // max(each, 1), 1)
    return (slice(first, first + step) for first in range(0, length, step))


def polar_nodes(nodes: int, form: str) -> tuple[Reals, Reals]:
    """Return cosines of polar angles and their weights: of the upper half sphere, or all of it for a kernel.

    Above the horizon the Gauss nodes stand in sqrt(cos theta), so that BRDFs with a root of the cosine are smooth too.
    """
    at, weights = np.polynomial.legendre.leggauss(nodes)
    if form == "kernel":
        return at, weights
    roots = (at + 1) / 2
    return roots**2, weights * roots


def half_turns(nodes: int, order: int) -> tuple[Reals, Reals]:
    """Return azimuths from 0 to pi and the matrix that takes an even function there to its integrals with cos(q phi).

    They crowd toward pi, where a rough mirror's lobe narrows to nothing as both directions approach the horizon: an
    even grid gains two digits where this one gains twelve.
    """
    at, weights = np.polynomial.legendre.leggauss(nodes)
    roots = (at + 1) / 2
    azimuths = math.pi * (1 - roots**2)
    return azimuths, (2 * math.pi * weights * roots)[:, None] * np.cos(azimuths[:, None] * np.arange(order + 1))


def full_turns(nodes: int, order: int) -> tuple[Reals, Complexes]:
    """Return azimuths of the circle, crowded toward pi, and the matrix to integrals with exp(-i q phi), q >= 0."""
    at, weights = np.polynomial.legendre.leggauss(nodes)
    roots = (at + 1) / 2
    azimuths = math.pi * np.concatenate([1 - roots**2, 1 + roots**2])
    weights = np.tile(math.pi * weights * roots, 2)
    return azimuths, weights[:, None] * np.exp(-1j * azimuths[:, None] * np.arange(order + 1))


def directions(cosines: Reals, azimuths: Reals) -> Reals:
    """Return local unit vectors of polar cosines and azimuths that broadcast."""
    sines = np.sqrt((1 - cosines) * (1 + cosines))
    parts = np.broadcast_arrays(sines * np.cos(azimuths), sines * np.sin(azimuths), cosines)
    return np.stack(parts, axis=-1)


def legendre(cosines: Reals, order: int) -> Reals:
    """Return the polar part of Y_lq for q >= 0, (order + 1, order + 1, n): [l, q], 0 where q > l."""
    harmonics = real_harmonics(directions(cosines, np.zeros_like(cosines)), order)
    result = np.zeros((order + 1, order + 1, len(cosines)))
    for degree in range(order + 1):
        result[degree, : degree + 1] = harmonics[degree * (degree + 1) : (degree + 1) ** 2]
    result[:, 1:] /= math.sqrt(2)
    return result


def to_real_rows(coefficients: Complexes) -> Complexes:
    """Take the rows of a matrix from factors of conjugate complex harmonics to factors of real ones.

    sum_a c'_a conj(Y'_a) = sum_a c_a Y_a with Y' the complex harmonics (Condon-Shortley): what incoming indices are.
    """
    result = np.array(coefficients, np.complex128)
    plus, minus, sign = _pairs(result)
    result[plus] = (sign * coefficients[plus] + coefficients[minus]) / math.sqrt(2)
    result[minus] = -1j * (sign * coefficients[plus] - coefficients[minus]) / math.sqrt(2)
    return result


def _pairs(rows: Complexes) -> tuple[NDArray[np.intp], NDArray[np.intp], Reals]:
    """Return where m > 0 and -m are stored, and (-1)^m shaped to multiply those rows."""
    degree = degrees(math.isqrt(len(rows)) - 1)
    mode = np.arange(len(rows)) - degree * (degree + 1)
    plus = np.flatnonzero(mode > 0)
    return plus, plus - 2 * mode[plus], ((-1.0) ** mode[plus]).reshape(-1, *[1] * (rows.ndim - 1))
