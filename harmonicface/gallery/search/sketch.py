"""Sketch: what a search reads of a person before it reads her pixels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.search.shared_basis import UNIT_ROUNDING, SharedBasis

COLUMNS = (32, 128, 384)  # how many rows of the shared basis each stage has seen
DTYPES = ("float16", "float32")
ORTHONORMAL = 0.01  # how far a person's rows may be from it
SINGLE = 2.0**-24  # the unit rounding of float32


@dataclass(frozen=True, eq=False)
class Sketch:
    """A person's rows in the shared basis, stage by stage; made by `sketch`.

    Each stage turns the basis Q of her span so that what the shared basis leaves over of its rows is orthogonal: then
    a photograph y has Q y = b + S t + e, with b from the sketch, S = diag(s), |t| at most what the shared basis leaves
    over of y, and |e| at most the doubt.

    Parameters
    ----------
    numbers
        (r, m) float16 or float32: her rows in the shared basis, the columns of each stage as this stage turns them.
    turns
        (stages - 1, r, r) float32: from the rows of a stage to those of the next.
    squares
        (stages, r) float32: s^2, rounded up.
    doubts
        (stages,) float32: what the rounding of numbers, turns and float32 products can add to |Q y|, rounded up.
    defect
        How far the stored rows are from orthonormal, |Q Q^T - I|, rounded up.
    stops
        How many rows of the shared basis each stage has seen.
    """

    numbers: NDArray[np.floating]
    turns: NDArray[np.float32]
    squares: NDArray[np.float32]
    doubts: NDArray[np.float32]
    defect: float
    stops: tuple[int, ...]


def sketch(rows: ArrayLike, basis: SharedBasis, columns: Sequence[int] = COLUMNS, dtype: str = "float32") -> Sketch:
    """Sketch a person from her rows as they are stored.

    Parameters
    ----------
    rows
        (r, p) orthonormal up to the rounding of their type.
    basis
        Over the same p pixels.
    columns
        How many rows of the basis each stage uses, rising; those beyond the basis are left out.
    dtype
        Of the numbers, "float32" or "float16".

    Raises
    ------
    HarmonicFaceError
        Rows of another shape, NaN or infinity, not orthonormal; columns that do not rise from at least 1; another
        dtype.

    Examples
    --------
    >>> sketch([[0.6, 0.8, 0.0]], SharedBasis([[1.0, 0.0, 0.0]])).squares.round(2)
    array([[0.64]], dtype=float32)
    """
    stored = _validate.finite(rows, "rows").astype(np.float64)
    stops = stage_columns(columns, len(basis.rows))
    if dtype not in DTYPES:
        raise HarmonicFaceError(f"dtype: expected one of {', '.join(DTYPES)}, got {dtype!r}")
    if stored.ndim != 2 or stored.shape[1] != basis.rows.shape[1] or not 0 < len(stored) <= stored.shape[1]:
        expected = f"shape (r, {basis.rows.shape[1]})"
        raise HarmonicFaceError(f"rows: expected {expected}, got {_validate.describe(stored)}")
    rank, pixels = stored.shape
    gram = stored @ stored.T
    defect = float(np.linalg.norm(gram - np.eye(rank))) + rank * pixels * UNIT_ROUNDING
    if defect > ORTHONORMAL:
        raise HarmonicFaceError(f"rows: expected orthonormal rows, got some that are not, by {defect:.2g}")
    values, vectors = np.linalg.eigh(gram)
    inside = (vectors / np.sqrt(values)) @ vectors.T @ (stored @ basis.rows[: stops[-1]].T)
    return Sketch(
        *_stages(inside, stops, dtype, 8 * rank * (pixels + rank) * UNIT_ROUNDING + basis.defect), defect, stops
    )


def stage_columns(columns: Sequence[int], available: int) -> tuple[int, ...]:
    """Return how many rows of a shared basis of so many the stages use.

    Raises
    ------
    HarmonicFaceError
        Columns that do not rise from at least 1.
    """
    stops = [_validate.at_least(count, 1, "columns") for count in columns]
    if not stops or sorted(set(stops)) != stops:
        raise HarmonicFaceError(f"columns: expected rising numbers, got {_validate.describe(tuple(columns))}")
    return tuple(sorted({min(count, available) for count in stops}))


def _stages(
    inside: NDArray[np.float64], stops: Sequence[int], dtype: str, slack: float
) -> tuple[NDArray[np.floating], NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """Return numbers, turns, squares and doubts of (r, m) coordinates C in the basis; float64 may err by `slack`."""
    rank, start = len(inside), 0
    numbers = np.empty(inside.shape, dtype)
    before, lost = np.eye(rank), 0.0
    turns, squares, doubts = [], [], []
    for stop in stops:
        # what is left over has the Gram matrix I - C C^T: its eigenvectors are the rows of this stage
        values, vectors = np.linalg.eigh(np.eye(rank) - inside[:, :stop] @ inside[:, :stop].T)
        turned = vectors.T @ inside[:, start:stop]
        numbers[:, start:stop] = turned
        lost = np.hypot(lost, float(np.linalg.norm(numbers[:, start:stop] - turned)))
        if start:
            turns.append((vectors.T @ before).astype(np.float32))
        squares.append(_up(np.clip(values, 0, 1) + slack))
        # products: one rounding a column and row, of numbers whose lengths are at most sqrt(r) together
        operations = (stop + len(turns) * (rank + 4) + 4) * SINGLE
        rounding = (operations / (1 - operations) + 2 * len(turns) * rank * SINGLE) * np.sqrt(rank) * 1.01
        doubts.append(_up(np.asarray(lost * (1 + slack) + rounding + slack)))
        before, start = vectors, stop
    stacked = np.stack(turns) if turns else np.empty((0, rank, rank), np.float32)
    return numbers, stacked, np.stack(squares), np.stack(doubts)


def _up(values: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return float32 numbers that are not below."""
    return np.nextafter(values.astype(np.float32), np.float32(np.inf))
