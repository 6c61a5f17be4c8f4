"""Sketch: what a search reads of a person before it reads her pixels."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.search import bound
from harmonicface.gallery.search.shared_basis import UNIT_ROUNDING, SharedBasis

COLUMNS = (128, 384)  # how many rows of the shared basis each stage has seen
FORM = 28  # how many of them the quadratic form has seen, which everybody is asked for first
DTYPES = ("float16", "float32")
ORTHONORMAL = 0.01  # how far a person's rows may be from it
TOGETHER = 1 << 24  # bytes of rows that are multiplied together


@dataclass(frozen=True, eq=False)
class Sketch:
    """A bound of what a person can explain of any photograph, coarse first and then finer; made by `sketch`.

    Parameters
    ----------
    form
        (k,) float32: N^T N of the first rows of the shared basis (`bound.quadratic`).
    numbers
        For each stage (r, columns) float16 or float32: N of so many rows of the shared basis.
    levels
        (1 + stages,) float32: l of the form and of each stage.
    doubts
        (1 + stages,) float32: what all rounding can add to each bound, rounded up.
    defect
        How far the stored rows are from orthonormal, |Q Q^T - I|, rounded up.
    """

    form: NDArray[np.float32]
    numbers: tuple[NDArray[np.floating], ...]
    levels: NDArray[np.float32]
    doubts: NDArray[np.float32]
    defect: float

    @property
    def stops(self) -> tuple[int, ...]:
        """How many rows of the shared basis each stage has seen."""
        return tuple(some.shape[1] for some in self.numbers)


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
    >>> one = sketch([[0.6, 0.8, 0.0]], SharedBasis([[1.0, 0.0, 0.0]]))
    >>> bool(one.form[0] >= 0.36)  # that much of a photograph of the first pixel alone, at least
    True
    """
    return next(sketches([rows], basis, columns, dtype))


def sketches(
    people: Sequence[ArrayLike], basis: SharedBasis, columns: Sequence[int] = COLUMNS, dtype: str = "float32"
) -> Iterator[Sketch]:
    """Sketch many people, some at a time, which takes a fraction of the time; arguments and errors as of `sketch`."""
    stops = stage_columns(columns, len(basis.rows))
    if dtype not in DTYPES:
        raise HarmonicFaceError(f"dtype: expected one of {', '.join(DTYPES)}, got {dtype!r}")
    pixels, used = basis.rows.shape[1], basis.rows[: stops[-1]].T
    step = max(1, TOGETHER // (8 * pixels * 9))
    for start in range(0, len(people), step):
        stored = [_checked(rows, pixels) for rows in people[start : start + step]]
        seen = np.concatenate(stored) @ used
        for rows, inside in zip(stored, np.split(seen, np.cumsum([len(rows) for rows in stored[:-1]])), strict=True):
            yield _sketched(rows, inside, stops, dtype, basis.defect)


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


def form_columns(stops: Sequence[int]) -> int:
    """Return how many rows of the shared basis the quadratic form has seen."""
    return min(FORM, stops[0])


def _checked(rows: ArrayLike, pixels: int) -> NDArray[np.float64]:
    """Return the rows of a person in float64."""
    stored = _validate.finite(rows, "rows")
    if stored.ndim != 2 or stored.shape[1] != pixels or not 0 < len(stored) <= pixels:
        raise HarmonicFaceError(f"rows: expected shape (r, {pixels}), got {_validate.describe(stored)}")
    return stored.astype(np.float64)


def _sketched(
    stored: NDArray[np.float64], seen: NDArray[np.float64], stops: tuple[int, ...], dtype: str, basis_defect: float
) -> Sketch:
    """Return the sketch of a person from her rows and their products with the shared basis."""
    rank, pixels = stored.shape
    gram = stored @ stored.T
    defect = float(np.linalg.norm(gram - np.eye(rank))) + rank * pixels * UNIT_ROUNDING
    if defect > ORTHONORMAL:
        raise HarmonicFaceError(f"rows: expected orthonormal rows, got some that are not, by {defect:.2g}")
    values, vectors = np.linalg.eigh(gram)
    inside = (vectors / np.sqrt(values)) @ vectors.T @ seen
    slack = 8 * rank * (pixels + rank) * UNIT_ROUNDING + basis_defect  # what float64 may have lost
    count = form_columns(stops)
    folded, highest, longest = _folded(inside[:, :count], slack, pixels)
    form = bound.quadratic(folded)
    beside = bound.gamma(len(form) + 10) * (1.01 * float(np.linalg.norm(folded.T @ folded)) + highest + 1)
    kept, levels = [], [highest]
    doubts = [bound.whole_doubt(longest * slack, longest, beside, 8, highest)]
    for stop in stops:
        folded, highest, longest = _folded(inside[:, :stop], slack, pixels)
        numbers = folded.astype(dtype)
        length = float(np.linalg.norm(numbers.astype(np.float64)))
        lost = float(np.linalg.norm(numbers - folded)) * (1 + slack) + bound.gamma(stop + 4) * length + longest * slack
        kept.append(numbers)
        levels.append(highest)
        doubts.append(bound.whole_doubt(lost, longest, 0.0, rank + 8, highest))
    return Sketch(form.astype(np.float32), tuple(kept), np.array(levels, np.float32), _up(np.array(doubts)), defect)


def _folded(inside: NDArray[np.float64], slack: float, pixels: int) -> tuple[NDArray[np.float64], float, float]:
    """Return N, l and the most that |N a| can be, from C; the eigenvalues of G may err by the slack."""
    rank, stop = inside.shape
    values, vectors = np.linalg.eigh(np.eye(rank) - inside @ inside.T)
    values = np.clip(values, 0, 1) + slack
    highest = float(_up(np.array(bound.level(values, vectors, 1 - stop / pixels))))
    gains = np.sqrt(highest / (highest - values))
    return gains[:, None] * (vectors.T @ inside), highest, float(gains.max()) * (1 + slack)


def _up(values: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return float32 numbers that are not below."""
    return np.nextafter(values.astype(np.float32), np.float32(np.inf))
