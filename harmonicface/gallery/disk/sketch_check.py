r"""Sketch check: whether a sketch bounds what its person can explain, of every photograph there is.

With C = Q U^T, G = I - C C^T and a level l above the eigenvalues of G, the closest photograph whose coordinates in U
are a has |Q y|^2 = a^T C^T l (l - G)^{-1} C a + l |r|^2. So the bound |N a|^2 + l |r|^2 holds for all of them if no
eigenvalue of C^T l (l - G)^{-1} C - N^T N is above what the sketch adds for rounding.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.search.packing import DEFECT, FORM, unpacked
from harmonicface.gallery.search.sketch import ORTHONORMAL, Sketch, form_columns
from harmonicface.store.entry import Entry

ROUNDING = 1e-9  # of this check's own float64
BEYOND = 1e6
Matrix = NDArray[np.float64]


def check_sketch(entry: Entry, rows: NDArray[np.floating], seen: Matrix, stops: tuple[int, ...]) -> None:
    """Refuse a sketch by which a search could miss its person; nobody has to have one.

    Parameters
    ----------
    entry
        Of a gallery's folder with a shared basis.
    rows
        Hers, (r, p), orthonormal up to the rounding of their type.
    seen
        (r, m) float64 products of her rows with those of the shared basis.
    stops
        How many rows of the shared basis each stage has seen.

    Raises
    ------
    HarmonicFaceError
        A sketch of another shape, one of other rows, or numbers that are not finite.
    """
    arrays = {name: array for name, array in entry.arrays.items() if name.startswith("sketch_")}
    if not any(len(array) for array in arrays.values()):
        return
    try:
        sketch = unpacked(arrays)
        fits = sketch.stops == stops and all(len(numbers) == len(rows) for numbers in sketch.numbers)
        fits = fits and len(sketch.levels) == len(sketch.doubts) == len(stops) + 1
        fits = fits and len(arrays[FORM]) == len(arrays[DEFECT]) == 1 and sketch.defect <= ORTHONORMAL
    except (IndexError, KeyError, ValueError):
        fits = False
    if not fits or _excess(np.asarray(rows, np.float64), seen, sketch) > ROUNDING:
        raise HarmonicFaceError(f"{ascii(entry.key)!s:.80}: expected a sketch of her rows, got another one")


def _excess(rows: Matrix, seen: Matrix, sketch: Sketch) -> float:
    """Return by how much some photograph may be closer than a bound of the sketch says; 0 or less of a right one."""
    kept = (*sketch.numbers, sketch.form, sketch.levels, sketch.doubts, np.array(sketch.defect))
    if not all(np.isfinite(array).all() for array in kept):
        return np.inf
    gram = rows @ rows.T
    values, vectors = np.linalg.eigh(gram)
    inside = (vectors / np.sqrt(values)) @ vectors.T @ seen
    worst = float(np.linalg.norm(gram - np.eye(len(rows)))) - sketch.defect
    least = _least(inside[:, : form_columns(sketch.stops)], float(sketch.levels[0]))
    over = least.T @ least - _symmetric(sketch.form)
    worst = max(worst, float(np.linalg.eigvalsh(over)[-1]) - float(sketch.doubts[0]))
    for stop, numbers, level, doubt in zip(
        sketch.stops, sketch.numbers, sketch.levels[1:], sketch.doubts[1:], strict=True
    ):
        both = np.concatenate([_least(inside[:, :stop], float(level)), numbers.astype(np.float64)])
        triangle = np.linalg.qr(both.T)[1]  # in the span of both, outside which nothing differs
        signs = np.repeat([1.0, -1.0], len(rows))
        worst = max(worst, float(np.linalg.eigvalsh((triangle * signs) @ triangle.T)[-1]) - float(doubt))
    return worst


def _least(inside: Matrix, level: float) -> Matrix:
    """Return the N of which N^T N is C^T l (l - G)^{-1} C; numbers that nothing reaches if l is not above G."""
    values, vectors = np.linalg.eigh(np.eye(len(inside)) - inside @ inside.T)
    if not level > max(values[-1], 0):
        return np.full_like(inside, BEYOND)
    return np.asarray(np.sqrt(level / (level - values))[:, None] * (vectors.T @ inside))


def _symmetric(form: NDArray[np.floating]) -> Matrix:
    """Return the matrix of a quadratic form from its upper triangle, whose numbers beside the diagonal are doubled."""
    side = int((np.sqrt(8 * len(form) + 1) - 1) / 2)
    upper = np.zeros((side, side))
    upper[np.triu_indices(side)] = form
    return np.asarray((upper + upper.T) / 2)
