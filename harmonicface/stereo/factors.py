"""Factors: the leading singular vectors of a few photographs of very many pixels, block by block."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError

BLOCK = 1 << 11  # pixels at a time: float32 products of so few, summed in float64, round to 4e-8 of the largest
RESOLVED = 1e-6  # of the largest square: smaller ones drown in float32 products, which are then redone in float64
GRADED = 1e-10  # of the largest square: smaller ones are found without squares
SQUARED = 1e12  # brighter or darker intensities, squared and summed, come near the ends of float32
SPARE = 3  # singular vectors beyond those asked for, among which a second pass turns the last ones right

Doubles = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Factors:
    """Photographs (n, p) as `left @ right`, as near as so few factors come, and how much there is beyond.

    Parameters
    ----------
    left
        (n, rank) float64, orthonormal columns times the singular values: how much of each factor a photograph has.
    right
        (rank, p) orthonormal rows of the photographs' type; None where the blocks could be read only once.
    singular_values
        (n,) float64, all of them, largest first. The first `rank` are exact to 1e-6 of the largest; beyond the third
        after them those of float32 photographs are uncertain by 3e-4 of it. Of blocks that could be read only once,
        what is not told from 0, below about 1e-7 of the largest, is 0.
    pixels
        How many columns there were.
    """

    left: Doubles
    right: Floats | None
    singular_values: Doubles
    pixels: int

    @property
    def rank(self) -> int:
        """How many factors were kept."""
        return int(self.left.shape[1])

    @property
    def gap(self) -> float:
        """The last singular value that is kept over the next one; infinite where nothing is left."""
        return self.gap_after(self.rank)

    @property
    def condition(self) -> float:
        """The first singular value over the last one that is kept: how much noise is magnified at the worst."""
        last = self.singular_values[self.rank - 1]
        return float(self.singular_values[0] / last) if last > 0 else float("inf")

    def gap_after(self, rank: int) -> float:
        """Return the singular value number `rank` over the next one."""
        if rank >= len(self.singular_values) or self.singular_values[rank] == 0:
            return float("inf")
        return float(self.singular_values[rank - 1] / self.singular_values[rank])

    def residual(self, rank: int) -> float:
        """Return the root mean square of the photographs minus their best approximation by so many factors."""
        rest = self.singular_values[rank:]
        largest = rest.max(initial=0.0) or 1.0  # its square may be no number
        return float(largest * np.sqrt(((rest / largest) ** 2).sum() / (len(self.singular_values) * self.pixels)))

    def above_noise(self, noise: float) -> int:
        """Return how many singular values stand above those of noise of a standard deviation.

        The largest singular value of (n, p) noise is `noise * (sqrt(n) + sqrt(p))` (Davidson & Szarek 2001).
        """
        edge = noise * (np.sqrt(len(self.singular_values)) + np.sqrt(self.pixels))
        return int((self.singular_values > edge).sum())

    def project(self, block: ArrayLike) -> Floats:
        """Return the right factors (rank, b) of some pixels, given as the photographs have them, (n, b)."""
        strength = np.maximum(self.singular_values[: self.rank], np.finfo(float).tiny)
        columns = _validate.floats(block, "block")
        products = (self.left / strength).T.astype(columns.dtype) @ columns
        return np.asarray((products / strength[:, None]).astype(columns.dtype))


def leading_factors(photographs: ArrayLike | Iterable[Floats], rank: int) -> Factors:
    r"""Return the leading factors of n photographs of p pixels, n much smaller than p.

    .. math:: M = U S V', \quad M M' = U S^2 U', \quad V' = S^{-1} U' M

    The (n, n) matrix M M' is summed over blocks of pixels in float64, so that neither memory nor rounding grows with
    p; then the leading rows of U' M are computed and turned to be orthogonal (Rayleigh-Ritz), which gives the small
    singular values the accuracy that their squares had lost. Products of float32 photographs are of float32, half the
    time, unless the last factor's singular value is below a thousandth of the first.

    Parameters
    ----------
    photographs
        (n, p) intensities; or a list of blocks (n, b) of pixels, which are read twice; or an iterator of such blocks,
        which is read once: then no `right` factors are kept, and `Factors.project` gives those of any pixels.
    rank
        How many factors, 1 to n.

    Returns
    -------
    Factors
        With the sign of each factor such that its photographs have a positive sum.

    Raises
    ------
    HarmonicFaceError
        No photographs, NaN or infinity, blocks of different numbers of photographs, a rank beyond their number.

    Examples
    --------
    >>> lights, shades = np.array([[1.0, 0.0], [0.0, 2.0], [1.0, 1.0]]), np.array([[3.0, 0.0, 1.0], [0.0, 1.0, 1.0]])
    >>> factors = leading_factors(lights @ shades, rank=2)
    >>> bool(np.allclose(factors.left @ factors.right, lights @ shades)), factors.singular_values.round(3)[2] + 0.0
    (True, np.float64(0.0))
    """
    if isinstance(photographs, Iterator):
        return _read_once(photographs, rank)
    if isinstance(photographs, np.ndarray) or not isinstance(photographs, Iterable):
        matrix = _checked_block(photographs, None)
        blocks = [matrix]
    else:
        blocks = [_checked_block(block, None) for block in photographs]
        if not blocks:
            raise HarmonicFaceError("photographs: expected at least one block of pixels, got none")
        if blocks[0].ndim == 1:  # rows of an array
            blocks = [_checked_block(np.asarray(photographs), None)]
    count = len(blocks[0])
    pixels = sum(_checked_block(block, count).shape[1] for block in blocks)
    number = _checked_rank(rank, count)
    unit = max(_unit(block) for block in blocks) or 1.0
    blocks = [_in_units(block, unit) for block in blocks]
    for dtype in (None, np.float64) if _resolved(blocks[0], number) else (np.float64,):
        gram = sum((_gram(block, dtype) for block in blocks), start=np.zeros((count, count)))
        _refuse_unfinite(gram)
        values, vectors = _eigen(gram)
        if values[number - 1] >= RESOLVED * values[0]:
            break
    if values[number - 1] < GRADED * values[0]:
        return _by_triangles(blocks, number, unit)
    some = min(number + SPARE, count)
    rows, inner = [], np.zeros((some, some))
    towards = vectors[:, :some].T
    for block in blocks:
        rows.append(towards.astype(block.dtype) @ block)
        inner += _gram(rows[-1])
    exact, turn = _eigen(inner)
    values[:some], vectors[:, :some] = exact, vectors[:, :some] @ turn
    strength = np.sqrt(values[:number])
    sign = np.where(vectors[:, :number].sum(axis=0) < 0, -1.0, 1.0)
    back = turn[:, :number] * sign / np.maximum(strength, np.finfo(float).tiny)
    right = np.concatenate([back.T.astype(row.dtype) @ row for row in rows], axis=1)
    return Factors(vectors[:, :number] * sign * (unit * strength), right, unit * np.sqrt(values), pixels)


def _by_triangles(blocks: list[Floats], rank: int, unit: float) -> Factors:
    """Return the factors of blocks (in units) without squares, which lose what is below 1e-8 of the largest."""
    count = len(blocks[0])
    triangle = np.zeros((0, count))
    for block in blocks:
        for first in range(0, block.shape[1], BLOCK):
            part = block[:, first : first + BLOCK].astype(np.float64)
            triangle = np.asarray(np.linalg.qr(np.concatenate([triangle, part.T]), mode="r"))
    vectors, values, _ = np.linalg.svd(triangle.T)
    values = np.concatenate([values, np.zeros(count - len(values))])  # fewer pixels than photographs
    chosen, strength = vectors[:, :rank], values[:rank]
    sign = np.where(chosen.sum(axis=0) < 0, -1.0, 1.0)
    back = chosen * sign / np.maximum(strength, np.finfo(float).tiny)
    right = np.concatenate([(back.T @ block).astype(block.dtype) for block in blocks], axis=1)
    return Factors(chosen * sign * (unit * strength), right, unit * values, sum(block.shape[1] for block in blocks))


def _read_once(blocks: Iterator[Floats], rank: int) -> Factors:
    """Return the factors of blocks that come once, from float64 products."""
    gram, pixels, unit = np.zeros((0, 0)), 0, 0.0
    for index, block in enumerate(blocks):
        matrix = _checked_block(block, len(gram) if index else None)
        if not index:
            gram = np.zeros((len(matrix), len(matrix)))
        before, unit = unit, max(unit, _unit(matrix))
        if unit > before:  # until now everything was darker
            gram *= (before / unit) ** 2
        gram += _gram(_in_units(matrix.astype(np.float64, copy=False), unit or 1.0))
        pixels += matrix.shape[1]
    if not len(gram):
        raise HarmonicFaceError("photographs: expected at least one block of pixels, got none")
    number, unit = _checked_rank(rank, len(gram)), unit or 1.0
    _refuse_unfinite(gram)
    values, vectors = _eigen(gram)
    values[values < len(gram) * np.finfo(float).eps * values[0]] = 0.0  # rounding
    sign = np.where(vectors[:, :number].sum(axis=0) < 0, -1.0, 1.0)
    singular = unit * np.sqrt(values)
    return Factors(vectors[:, :number] * sign * singular[:number], None, singular, pixels)


def _unit(block: Floats) -> float:
    """Return a power of two near the largest intensity where squares would leave float32, 0 of black, and 1 of most."""
    largest = max(float(block.max()), -float(block.min()))
    if largest == 0:
        return 0.0
    if not np.isfinite(largest) or 1 / SQUARED < largest < SQUARED:
        return 1.0
    return float(2.0 ** np.floor(np.log2(largest)))


def _in_units(block: Floats, unit: float) -> Floats:
    """Return a block divided by a power of two, which changes no digit; without a copy if that is 1."""
    return block if unit == 1 else np.asarray(block / block.dtype.type(unit))


def _resolved(block: Floats, rank: int) -> bool:
    """Tell from a few pixels whether the last factor will stand above the rounding of float32 products."""
    some = block[:, :: max(block.shape[1] // BLOCK, 1)]
    with np.errstate(invalid="ignore"):
        gram = _gram(some, np.float64)
    return not np.isfinite(gram).all() or bool((values := _eigen(gram)[0])[rank - 1] >= 2 * RESOLVED * values[0])


def _gram(matrix: Floats, dtype: type[np.floating[Any]] | None = None) -> Doubles:
    """Return M M' as a sum over blocks in float64, each block's product in a type or its own."""
    total = np.zeros((len(matrix), len(matrix)))
    for first in range(0, matrix.shape[1], BLOCK):
        part = matrix[:, first : first + BLOCK].astype(dtype or matrix.dtype, copy=False)
        total += part @ part.T
    return total


def _eigen(gram: Doubles) -> tuple[Doubles, Doubles]:
    """Return eigenvalues, largest first and at least 0, and eigenvectors as columns."""
    values, vectors = np.linalg.eigh(gram)
    return np.maximum(values[::-1], 0.0), np.asarray(vectors[:, ::-1])


def _checked_block(block: ArrayLike, count: int | None) -> Floats:
    matrix = _validate.floats(block, "photographs")
    if count is None and matrix.ndim == 1:
        return matrix
    if matrix.ndim != 2 or matrix.size == 0 or (count is not None and len(matrix) != count):
        expected = "(n, p)" if count is None else f"({count}, b) as the first block"
        raise HarmonicFaceError(f"photographs: expected shape {expected}, got {_validate.describe(matrix)}")
    return matrix


def _refuse_unfinite(gram: Doubles) -> None:
    """Refuse NaN and infinity, which any one of them leaves in its photograph's row."""
    bad = np.flatnonzero(~np.isfinite(np.diag(gram)))
    if bad.size:
        raise HarmonicFaceError(f"photographs: expected finite intensities, got NaN or infinity in photograph {bad[0]}")


def _checked_rank(rank: int, count: int) -> int:
    number = _validate.at_least(rank, 1, "rank")
    if number > count:
        raise HarmonicFaceError(f"rank: expected at most the {count} photographs there are, got {number}")
    return number
