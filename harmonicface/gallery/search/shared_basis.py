"""SharedBasis: the few pictures whose combinations look most like any photograph of anybody."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike, NDArray
from sklearn.utils.extmath import randomized_svd

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.search.products import products

ORTHONORMAL = 1e-7  # how far the rows may be from it; what is left is part of every bound
UNIT_ROUNDING = 2.0**-53
TOGETHER = 4096  # rows whose products are summed in their own precision


@dataclass(frozen=True, eq=False)
class SharedBasis:
    """Orthonormal rows, the most telling first.

    Parameters
    ----------
    rows
        (m, p) float64, orthonormal.

    Raises
    ------
    HarmonicFaceError
        Not a (m, p) array, NaN or infinity, rows that are not orthonormal.
    """

    rows: NDArray[np.float64]

    def __post_init__(self) -> None:
        rows = _validate.finite(self.rows, "rows")
        if rows.ndim != 2 or rows.size == 0:
            raise HarmonicFaceError(f"rows: expected shape (m, p), got {_validate.describe(rows)}")
        object.__setattr__(self, "rows", np.ascontiguousarray(rows, np.float64))
        if self.defect > ORTHONORMAL:
            raise HarmonicFaceError(f"rows: expected orthonormal rows, got some that are not, by {self.defect:.2g}")

    @classmethod
    def of(cls, rows: ArrayLike, weights: ArrayLike, m: int, seed: int = 0) -> SharedBasis:
        r"""Learn the basis from a sample of people.

        The m rows U minimize \sum_k w_k |q_k - U^T U q_k|^2: the principal directions of the weighted rows, not
        centred. With w_k the energy that photographs have along q_k, that is the energy which U leaves over of
        photographs. Found from the products of all pixels with each other if there are fewer pixels than rows, else
        by a randomized factorization (Halko, Martinsson and Tropp 2011); any other orthonormal rows would give right
        answers too, only later.

        Parameters
        ----------
        rows
            (n, p) orthonormal rows of the people of the sample, one person after the other.
        weights
            (n,) above 0: how strong photographs are along each row, in any unit.
        m
            How many rows, at least 1; fewer come back if n or p is less, or the sample spans less.
        seed
            Of the randomized factorization, at least 0.

        Raises
        ------
        HarmonicFaceError
            Other shapes, NaN or infinity, weights that are not above 0, rows that are all 0, m below 1.

        Examples
        --------
        >>> SharedBasis.of([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]], [1.0, 4.0], 1).rows.round(6) + 0.0
        array([[1., 0., 0.]])
        """
        sample, energies = _validate.finite(rows, "rows"), _validate.finite(weights, "weights")
        if sample.ndim != 2 or sample.size == 0:
            raise HarmonicFaceError(f"rows: expected shape (n, p), got {_validate.describe(sample)}")
        if energies.shape != (len(sample),) or not (energies > 0).all():
            expected = f"{len(sample)} numbers above 0"
            raise HarmonicFaceError(f"weights: expected {expected}, got {_validate.describe(energies)}")
        if not sample.any():
            raise HarmonicFaceError(f"rows: expected some that are not 0, got {len(sample)} of zeros")
        count = min(_validate.at_least(m, 1, "m"), *sample.shape)
        scales = np.sqrt(energies / energies.max()).astype(sample.dtype)
        first = _validate.at_least(seed, 0, "seed")
        weighted = sample * scales[:, None]
        if len(weighted) > weighted.shape[1]:
            values, directions = _principal(weighted, count)
        else:
            _, values, directions = randomized_svd(weighted, count, n_oversamples=16, n_iter=2, random_state=first)
        kept = directions[values > values[0] * np.finfo(sample.dtype).eps]
        orthonormal, triangle = np.linalg.qr(kept.T.astype(np.float64))
        return cls(np.ascontiguousarray((orthonormal * np.where(np.diag(triangle) < 0, -1.0, 1.0)).T))

    @cached_property
    def defect(self) -> float:
        """How far the rows are from orthonormal: |U U^T - I|, with what its computation may have lost."""
        count, pixels = self.rows.shape
        gram = self.rows @ self.rows.T
        measured = float(np.linalg.norm(gram - np.eye(count)))
        return float(measured + 2 * count * pixels * UNIT_ROUNDING)

    @cached_property
    def doubt(self) -> float:
        """What must be added to 1 - |a|^2 to bound the squared length that the basis leaves over of a unit photograph.

        With the computed a = U y + e, y = U^T a + r has |r|^2 = |y|^2 - |a|^2 + 2 a e + a^T (U U^T - I) a; the rounding
        of each number of a and of |y|^2 is at most p units.
        """
        count, pixels = self.rows.shape
        return float(self.defect + 4 * (count**0.5 + 1) * (pixels + count) * UNIT_ROUNDING)


def _principal(rows: NDArray[np.floating], count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the largest singular values of rows, falling, and their directions, by the products of the columns."""
    pixels = rows.shape[1]
    gram = np.zeros((pixels, pixels))
    for start in range(0, len(rows), TOGETHER):
        block = rows[start : start + TOGETHER]
        gram += block.T @ block
    squares, directions = scipy.linalg.eigh(gram, subset_by_index=(pixels - count, pixels - 1), overwrite_a=True)
    squares[squares < squares[-1] * 16 * np.finfo(rows.dtype).eps] = 0  # rounding, where the rows span less
    return np.sqrt(squares[::-1]), directions.T[::-1]


class Question:
    """Unit photographs as the shared basis sees them, as far as they have been looked at.

    Parameters
    ----------
    basis
        Over p pixels.
    units
        (q, p) photographs of unit length, float64.
    """

    def __init__(self, basis: SharedBasis, units: NDArray[np.float64]) -> None:
        self._basis, self._units = basis, units.T
        self._coordinates = np.empty((len(basis.rows), len(units)), np.float32)
        self._explained = {0: np.zeros(len(units))}  # by the stops that were looked at
        self._seen = 0

    def coordinates(self, stop: int) -> NDArray[np.float32]:
        """Return the first `stop` coordinates, (stop, q)."""
        if stop > self._seen:
            new = products(self._basis.rows[self._seen : stop], self._units)
            self._coordinates[self._seen : stop] = new
            self._explained[stop] = self._explained[self._seen] + np.square(new).sum(axis=0)
            self._seen = stop
        return self._coordinates[:stop]

    def left(self, stop: int) -> NDArray[np.float32]:
        """Return upper bounds of the squared lengths that the first `stop` rows leave over, (q,); in rising order."""
        if stop not in self._explained:
            self.coordinates(stop)
        left = np.maximum(1 - self._explained[stop], 0) + self._basis.doubt
        # cast up: the float next to one that is rounded to nearest is never below
        return np.asarray(np.nextafter(left.astype(np.float32), np.float32(np.inf)))
