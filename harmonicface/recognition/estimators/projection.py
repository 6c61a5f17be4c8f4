"""Nearest subspace: everybody's orthonormal rows in one array, so that all distances are one matrix product."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from harmonicface._validate import Floats
from harmonicface.recognition.estimators.base import FaceClassifier
from harmonicface.recognition.subspace import ROUNDINGS


class NearestSubspace(FaceClassifier):
    r"""A method in which a person is the span of a few pictures.

    .. math:: d = \sqrt{1 - |Q y|^2 / |y|^2}

    the sine of the angle between photograph and subspace, 0 to 1. Angles that rounding cannot tell from 0 are 0:
    below 0.003 in float32, 1e-7 in float64. A photograph that is all 0 is at 1 from everybody.

    Attributes
    ----------
    rows_
        (m, p) orthonormal rows of everybody.
    starts_
        (c,) the first row of each person.
    """

    def _stack(self, rows: Sequence[Floats]) -> None:
        """Keep each person's orthonormal rows (r, p)."""
        dark = np.zeros((1, rows[0].shape[1]), rows[0].dtype)
        filled = [own if len(own) else dark for own in rows]
        self.rows_ = np.concatenate(filled)
        self.starts_ = np.cumsum([0, *(len(own) for own in filled[:-1])])

    def _distances(self, pixels: Floats) -> Floats:
        unit = unit_length(pixels.astype(self.rows_.dtype, copy=False))
        products = unit @ self.rows_.T
        explained = np.add.reduceat(np.square(products, out=products), self.starts_, axis=1)
        unexplained = 1 - explained
        unexplained[unexplained < 64 * np.finfo(unexplained.dtype).eps] = 0
        return np.asarray(np.sqrt(unexplained))


def orthonormal(pictures: Floats, most: int | None = None) -> Floats:
    """Return orthonormal rows that span pictures (k, p), of the same type: the directions with most in them first.

    Parameters
    ----------
    pictures
        (k, p) of any scale.
    most
        Keep at most so many rows. Directions that rounding cannot tell from nothing are left out anyway.

    Examples
    --------
    >>> len(orthonormal(np.array([[3.0, 0.0, 0.0], [0.0, 2.0, 0.0], [3.0, 2.0, 0.0]])))
    2
    """
    scale = np.abs(pictures).max() or 1.0
    _, values, rows = np.linalg.svd(pictures.astype(np.float64) / scale, full_matrices=False)
    rounding = ROUNDINGS * np.finfo(pictures.dtype).eps * np.sqrt(len(pictures))
    rank = int((values > values[0] * rounding).sum()) if values[0] > 0 else 0
    return np.ascontiguousarray(rows[: rank if most is None else min(rank, most)], pictures.dtype)


def unit_length(pixels: Floats) -> Floats:
    """Return photographs (n, p) scaled to length 1, safely for any brightness; those that are all 0 stay so."""
    largest = np.abs(pixels).max(axis=1, keepdims=True)
    scaled = pixels / np.where(largest == 0, 1, largest)
    lengths = np.linalg.norm(scaled, axis=1, keepdims=True)
    return np.asarray(scaled / np.where(lengths == 0, 1, lengths), pixels.dtype)
