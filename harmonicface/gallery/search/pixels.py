"""Pixels: everybody's stored rows, of which a search reads those of the people whom no bound excludes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from harmonicface.gallery.search.products import products
from harmonicface.recognition.subspace import Subspace

SINGLE = 2.0**-24


@dataclass(frozen=True, eq=False)
class Pixels:
    """Where the rows of each person are, and how orthonormal they are.

    Parameters
    ----------
    rows
        From a person's place to her (r, p) rows as they are stored; of memory maps these may be views.
    defects
        (n,) how far the rows are from orthonormal (`Sketch.defect`).
    size
        p.
    """

    rows: Callable[[int], NDArray[np.floating]]
    defects: NDArray[np.float64]
    size: int

    def closeness(self, person: int, units: NDArray[np.float32]) -> NDArray[np.float64]:
        r"""Return upper bounds of |Q y|^2 of a person for unit photographs, (q,) from (q, p), by one product.

        A product of float32 numbers errs by at most gamma_{p+2} |q_k| |y| in each row. Stored rows with
        |Q Q^T - I| <= d make |Q y| at least \sqrt{1 - d} times as long as with orthonormal rows.
        """
        rows = np.asarray(self.rows(person), np.float32)
        seen = products(rows, units.T).astype(np.float64)
        lengths = np.sqrt(np.einsum("rq,rq->q", seen, seen)) + 1.01 * self._rounding * math.sqrt(len(rows))
        return np.asarray(np.square(lengths) * ((1 + 1e-12) / (1 - float(self.defects[person]))))

    @cached_property
    def _rounding(self) -> float:
        """What a float32 product of unit photographs with unit rows loses."""
        operations = (self.size + 2) * SINGLE
        return operations / (1 - operations) if operations < 1 else math.inf  # of a picture of 16 million pixels

    def distance(self, person: int, unit: NDArray[np.float64]) -> float:
        """Return the exact distance of a person, as a scan of everybody computes it."""
        rows = np.asarray(self.rows(person), np.float32)
        return Subspace(rows, np.empty((len(rows), 0))).distance(unit)
