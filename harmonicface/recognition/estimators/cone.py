"""Nearest cone: pictures of a person under lamps, added with weights that are not negative."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from harmonicface._validate import Floats
from harmonicface.recognition.estimators.from_surfaces import SurfaceClassifier
from harmonicface.recognition.estimators.nonnegative_least_squares import nonnegative_solutions
from harmonicface.recognition.estimators.projection import unit_length
from harmonicface.surfaces.surface import Surface

HIDDEN = 0.01  # of the brightest lamp's picture: lamps behind the surface would be fitted to noise alone
KEPT = 1e-3  # of the largest singular value of the rays
BATCH = 16  # photographs at a time


class NearestCone(SurfaceClassifier):
    r"""A method in which a person is the convex cone of a few pictures, its rays.

    .. math:: d = \min_{a \ge 0} |y - R^T a| / |y|

    The rays R of length 1 are factored as C Q, with orthonormal rows Q for their principal directions down to a
    thousandth of the largest. A query costs one product with everybody's Q, and then small problems with the normal
    matrices C C^T, which are prepared (`nonnegative_solutions`).

    Attributes
    ----------
    rows_
        (c, r, p) float32, each person's Q; rows of 0 where she has fewer than others.
    factors_
        (c, k, r) each person's C; 0 for lamps whose picture has less than 1 % of the brightest one's length.
    grams_
        (c, k, k) float64.
    """

    def _enroll(self, surfaces: Sequence[Surface]) -> None:
        factored = [_factored(self._placed(surface)) for surface in surfaces]
        rank = max(len(rows) for _, rows in factored)
        self.factors_ = np.stack([np.pad(own, ((0, 0), (0, rank - own.shape[1]))) for own, _ in factored])
        self.rows_ = np.stack([np.pad(rows, ((0, rank - len(rows)), (0, 0))) for _, rows in factored])
        self.grams_ = self.factors_ @ self.factors_.transpose(0, 2, 1)

    def _distances(self, pixels: Floats) -> Floats:
        parts = [self._unexplained(pixels[first : first + BATCH]) for first in range(0, len(pixels), BATCH)]
        return np.asarray(np.sqrt(np.concatenate(parts)))

    def _unexplained(self, pixels: Floats) -> Floats:
        """Return the share of the energy that no positive light explains, (n, c)."""
        people, rank, size = self.rows_.shape
        unit = unit_length(pixels.astype(np.float32, copy=False))
        seen = (self.rows_.reshape(-1, size) @ unit.T).reshape(people, rank, -1).astype(np.float64)
        targets = np.moveaxis(self.factors_ @ seen, 2, 0)
        weights = nonnegative_solutions(self.grams_, targets)
        explained = np.einsum("nck,nck->nc", weights, targets)  # at a minimum x.Gx = x.b
        energy = np.einsum("np,np->n", unit, unit, dtype=np.float64)
        return np.asarray(np.clip(energy[:, None] - explained, 0, 1))


def _factored(rays: Floats) -> tuple[Floats, Floats]:
    """Return C (k, r) float64 and Q (r, p) float32 of the rays scaled to length 1."""
    lengths = np.linalg.norm(rays, axis=1, keepdims=True)
    seen = lengths > HIDDEN * lengths.max()
    unit = np.where(seen, rays / np.where(seen, lengths, 1), 0)
    gram = unit @ unit.T if unit.dtype == np.float64 else unit.astype(np.float64) @ unit.T.astype(np.float64)
    squares, directions = np.linalg.eigh(gram)
    squares, directions = squares[::-1], directions[:, ::-1]
    rank = max(int((squares > KEPT**2 * squares[0]).sum()), 1)
    values = np.sqrt(np.maximum(squares[:rank], np.finfo(float).tiny))
    rows = (directions[:, :rank] / values).T @ unit
    return directions[:, :rank] * values, rows.astype(np.float32)
