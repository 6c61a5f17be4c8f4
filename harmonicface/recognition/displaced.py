"""Displaced: compare a photograph with everybody at every small shift, by few matrix products at a reduced size."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.alignment import pyramid_of, reduced
from harmonicface.recognition.subspace import unit_photo

FACTOR, REACH, RELUCTANCE = 2, 6, 0.02


@dataclass(frozen=True, eq=False)
class Displacements:
    """How well a photograph fits each of n people at the shift that suits them best.

    Parameters
    ----------
    scores
        (n,) what to rank by: distances, times the reluctance to shift.
    distances
        (n,) sines of the angle between subspace and shifted photograph, 0 to 1; below 0.001 they are rounding.
    shifts
        (n, 2) pixels of the photograph to the right and down by which it shows the person displaced.
    """

    scores: NDArray[np.float64]
    distances: NDArray[np.float64]
    shifts: NDArray[np.int64]


class ShiftSearch:
    r"""People, each as a subspace of pictures at a reduced size, in a photograph that may be shifted.

    A wrong person gains from a free search as much as the right one does. People in front of a camera move little, so
    a shift s costs its share: what is ranked is distance * exp(reluctance * |s|), the most probable explanation
    where shifts are distributed as exp(-c |s|).

    Parameters
    ----------
    factor
        The photograph is averaged over squares of so many pixels; a shift is a multiple of it.
    reach
        Largest shift in pixels, at least 0; 0 compares at rest.
    reluctance
        Of a pixel of shift, at least 0. The default was chosen on people 1 to 5 of Yale B by the margins of right
        answers; a search that costs nothing errs twice as often on them (7.4 instead of 3.2 % on subset 5).

    Examples
    --------
    >>> faces = np.random.default_rng(0).uniform(0, 1, (2, 1, 24, 24))
    >>> search = ShiftSearch(factor=1, reach=2)
    >>> for face in faces:
    ...     search.enroll(face)
    >>> found = search.match(np.roll(faces[1, 0], 2, axis=1))
    >>> int(found.scores.argmin()), found.shifts[1].tolist()
    (1, [2, 0])
    """

    def __init__(self, factor: int = FACTOR, reach: int = REACH, reluctance: float = RELUCTANCE) -> None:
        self._factor = _validate.at_least(factor, 1, "factor")
        self._shifts = self._factor * _square(_validate.at_least(reach, 0, "reach") // self._factor)
        costs = np.linalg.norm(self._shifts, axis=1)
        self._costs = np.exp((0 if reluctance == 0 else _validate.positive(reluctance, "reluctance")) * costs)
        self._rows: list[NDArray[np.float32]] = []
        self._stacked = np.empty((0, 0), np.float32)
        self._shape: tuple[int, int] | None = None

    def __len__(self) -> int:
        return len(self._rows)

    @property
    def bytes_per_person(self) -> float:
        """Memory of a person's rows, on average."""
        return sum(rows.nbytes for rows in self._rows) / len(self._rows) if self._rows else 0.0

    def enroll(self, images: ArrayLike) -> None:
        """Add a person by the pictures (k, h, w) that span hers.

        Raises
        ------
        HarmonicFaceError
            Another shape than those before, a size that the factor does not divide, NaN, pictures that are all 0.
        """
        (rows,) = pyramid_of(images, (self._factor,))
        shape = (rows.shape[1], rows.shape[2])
        if self._shape not in (None, shape):
            raise HarmonicFaceError(f"images: expected the size of those before, {self._shape}, got {shape} (reduced)")
        self._shape = shape
        self._rows.append(rows.reshape(len(rows), -1))
        self._stacked = np.empty((0, 0), np.float32)

    def match(self, photo: ArrayLike) -> Displacements:
        """Compare a photograph (h, w) with everybody at all shifts.

        Raises
        ------
        HarmonicFaceError
            Nobody is enrolled, another shape, NaN, a photograph that is all 0.
        """
        if self._shape is None:
            raise HarmonicFaceError("match: expected somebody to be enrolled, got nobody")
        pixels = _validate.finite(photo, "photo")
        expected = (self._factor * self._shape[0], self._factor * self._shape[1])
        if pixels.shape != expected:
            raise HarmonicFaceError(f"photo: expected shape {expected}, got {_validate.describe(pixels)}")
        small = reduced(unit_photo(pixels.ravel(), pixels.size).reshape(1, *pixels.shape), self._factor)[0]
        shifted = self._shifted(small.astype(np.float32))
        starts = np.cumsum([0, *(len(rows) for rows in self._rows[:-1])])
        if not len(self._stacked):
            self._stacked = np.concatenate(self._rows)
            self._rows = np.split(self._stacked, starts[1:])  # views: nobody is held twice
        products = self._stacked @ shifted.T
        np.square(products, out=products)
        explained = np.add.reduceat(products, starts, axis=0) / np.maximum(
            np.einsum("sp,sp->s", shifted, shifted), np.finfo(np.float32).tiny
        )
        distances = np.sqrt(np.clip(1.0 - explained.astype(np.float64), 0.0, 1.0))
        scores = distances * self._costs
        best = scores.argmin(axis=1)
        everybody = np.arange(len(self._rows))
        return Displacements(scores[everybody, best], distances[everybody, best], self._shifts[best])

    def _shifted(self, photo: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the photograph seen from all shifts, its border repeated, (s, p)."""
        height, width = photo.shape
        steps = self._shifts // self._factor
        edge = int(np.abs(steps).max())
        padded = np.pad(photo, edge, mode="edge")
        result = np.empty((len(steps), height * width), np.float32)
        for row, (right, down) in zip(result, steps, strict=True):
            row[:] = padded[edge + down : edge + down + height, edge + right : edge + right + width].ravel()
        return result


def _square(reach: int) -> NDArray[np.int64]:
    """Return all whole-numbered shifts (right, down) up to a reach, nearest first, (s, 2)."""
    steps = np.arange(-reach, reach + 1)
    grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    return np.asarray(grid[np.argsort(np.linalg.norm(grid, axis=1), kind="stable")], np.int64)
