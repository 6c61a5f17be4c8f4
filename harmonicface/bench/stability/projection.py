"""Rows of the stability table: the span of pictures, distances from it, and how pictures combine."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import DTypeLike

from harmonicface._validate import Floats
from harmonicface.bench.stability import exact
from harmonicface.bench.stability.row import CONSTANT, Answers, Measured, Rows, if_honest, named, rounded, unit
from harmonicface.recognition.subspace import Subspace

PIXELS = 60
SINGLE = float(np.finfo(np.float32).eps)  # of the stored rows
KEPT = "condition reported; the rows are float32"


def of_projection() -> Answers:
    """Return a function for each row."""
    distances: Rows = {case: partial(_distance, pictures) for case, pictures in _spans().items()}
    coefficients: Rows = {case: partial(_coefficients, pictures) for case, pictures in _spans().items()}
    usual = _pictures()
    inside = np.array([1.0, -2.0, 0.5]) @ usual
    distances["a photo in the span"] = partial(_distance, usual, inside)
    distances["a photo 1e-05 off the span"] = partial(_distance, usual, inside + 1e-5 * _photo())
    for factor, case in ((1e-300, "1e-300"), (1e300, "1e+300"), (1e-310, "1e-310 (subnormal)")):
        distances[f"a photo of {case}"] = partial(_distance, usual, factor * _photo())
    distances["pictures of 1e+12 and 1e-12"] = partial(_distance, usual * [[1e12], [1.0], [1e-12]])
    distances["black pictures"] = partial(_distance, 0 * usual)
    distances["a black photo"] = partial(_distance, usual, 0 * _photo())
    distances["NaN"] = partial(_distance, usual, np.full(PIXELS, np.nan))
    coefficients["pictures of 1e-310 (subnormal)"] = partial(_coefficients, 1e-310 * usual)
    restricted: Rows = {
        "half of the pixels": partial(_restricted, PIXELS // 2),
        "as many pixels as pictures": partial(_restricted, 3),
        "fewer pixels than pictures": partial(_restricted, 2),
        "no pixel": partial(_restricted, 0),
    }
    return {
        **named("Subspace.distance", distances),
        **named("Subspace.coefficients", coefficients),
        **named("Subspace.restrict", restricted),
    }


def _pictures(dtype: DTypeLike = np.float64) -> Floats:
    """Return three pictures of integers, so that their sums are exact."""
    return np.random.default_rng(0).integers(-99, 100, (3, PIXELS)).astype(dtype)


def _photo(pixels: int = PIXELS) -> Floats:
    return np.random.default_rng(1).normal(size=pixels)


def _spans() -> dict[str, Floats]:
    usual, single = _pictures(), _pictures(np.float32)
    first, second, third = usual
    spans = {"independent pictures": usual}
    for nearness in (1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14):
        spans[f"nearly dependent at {nearness:.0e}"] = np.stack([first, second, first + second + nearness * third])
    spans["dependent pictures"] = np.stack([first, second, first + 2 * second, third])
    spans["one picture nine times"] = np.repeat(usual[:1], 9, axis=0)
    spans["one picture 1e-12 of the others"] = usual * [[1.0], [1.0], [1e-12]]
    for factor in (1e-12, 1e12, 1e-300, 1e300):
        spans[f"times {factor:.0e}"] = factor * usual
    spans["float32 pictures"] = single
    near = np.stack([first, second, first + second + 1e-4 * third])
    spans["float32, nearly dependent at 1e-04"] = near.astype(np.float32)
    spans["float32, times 1e-40 (subnormal)"] = (1e-40 * usual).astype(np.float32)
    spans["one pixel"] = usual[:, :1]
    return spans


def _allowed(pictures: Floats, condition: float) -> float:
    """Return what rounding to float32 rows, and the pictures' own arithmetic, may do to a unit vector of the span."""
    return CONSTANT * (SINGLE + condition * float(np.finfo(np.float64).eps))


def _distance(pictures: Floats, photo: Floats | None = None) -> Measured:
    """Compare the distance with the sine that fractions give."""
    seen = _photo(pictures.shape[1]) if photo is None else photo
    span = Subspace.of(pictures)
    error = abs(span.distance(seen) - exact.sine(_resolved(pictures), seen))
    return Measured(error, _allowed(pictures, span.condition), span.condition, f"absolute; {KEPT}")


def _resolved(pictures: Floats) -> Floats:
    """Return pictures without those so faint beside the others that no arithmetic of this precision sees them."""
    sizes = np.abs(pictures.astype(np.float64)).max(axis=1)
    return np.asarray(pictures[sizes > sizes.max() * np.finfo(pictures.dtype).eps])


def _coefficients(pictures: Floats) -> Measured:
    """Compare the least-squares combination of a photograph near the span with that of fractions, of least norm."""
    double = pictures.astype(np.float64)
    size = float(np.abs(double).max())
    photo = (np.arange(1.0, len(double) + 1) @ (double / size)) + 1e-3 * _photo(pictures.shape[1])
    span = Subspace.of(pictures)
    right = exact.longs(exact.least_squares(double.T, photo))
    condition = span.condition
    made = np.linalg.norm(exact.longs(exact.rationals(double)).T @ right)
    # how far the combination falls short of what one of its size can make, and what it leaves of the photograph
    # (Trefethen & Bau, lecture 18): rounded rows count the less the shorter it falls, rounded pictures with the
    # condition and, if there is a rest, its square
    short = float(exact.singular_values(double)[0] * np.linalg.norm(right) / made)
    whole = float(np.linalg.norm(photo) / made)
    rest = np.sqrt(max(whole**2 - 1, 0.0))
    pictured = condition * (1 + condition * rest / short) * unit(size, pictures.dtype)
    allowed = float(CONSTANT * (condition * whole / short * SINGLE + pictured))
    error = rounded(span.coefficients(photo), right).error
    return if_honest(Measured(error, allowed, condition, KEPT), exact.condition_of(double))


def _restricted(pixels: int) -> Measured:
    """Compare the distance of a photograph through a mask."""
    good = np.arange(PIXELS) < pixels
    span = Subspace.of(_pictures()).restrict(good)
    error = abs(span.distance(_photo()[good]) - exact.sine(_pictures()[:, good], _photo()[good]))
    return Measured(error, _allowed(_pictures(), span.condition), span.condition, f"absolute; {KEPT}")
