"""Resampling: means over larger pixels, or lines between pixel centres, of what lies inside a mask."""

from __future__ import annotations

import numpy as np
from numpy.typing import DTypeLike, NDArray
from scipy.sparse import csr_array

from harmonicface._validate import Floats
from harmonicface.surfaces.windows import Window

ROUNDING = 1e-9  # of a pixel's area


class MaskedMean:
    """The mean of pictures over the part of each window's pixel that lies inside a mask.

    Where the window's pixels are larger than the picture's (step of at least 1), the mean over their area; where they
    are smaller, the straight line between the nearest pixel centres in both directions.

    Parameters
    ----------
    mask
        (H, W) booleans.
    window
        The pixels that are wanted.
    """

    def __init__(self, mask: NDArray[np.bool_], window: Window) -> None:
        self._mask = mask
        self._rows = _weights(mask.shape[0], window.shape[0], window.top, window.step)
        self._columns = _weights(mask.shape[1], window.shape[1], window.left, window.step)
        self._coverage = self._sums(mask.astype(np.float64))
        self.inside: NDArray[np.bool_] = self._coverage >= 0.5 - ROUNDING

    def __call__(self, values: Floats) -> Floats:
        """Return the means of (p,) or (p, c) values of the masked pixels, for the window's pixels inside."""
        sums = self._sums(spread(values, self._mask, np.float64))[self.inside]
        return np.asarray(sums / self._coverage[self.inside].reshape(-1, *[1] * (values.ndim - 1)))

    def weighted(self, values: Floats, weights: Floats) -> Floats:
        """Return means of (p,) values by weights of at least 0; the plain mean where all weights are 0."""
        total = self(weights)
        means = self(values)
        np.divide(self(values * weights), total, out=means, where=total > 0)
        return means

    def _sums(self, picture: Floats) -> Floats:
        """Apply the weights of rows and of columns, (h, w, ...)."""
        height, width = self._rows.shape[0], self._columns.shape[0]
        rest = picture.shape[2:]
        tall = self._rows @ picture.reshape(len(picture), -1)
        tall = tall.reshape(height, picture.shape[1], -1).transpose(1, 0, 2)
        wide = self._columns @ tall.reshape(picture.shape[1], -1)
        return np.asarray(wide.reshape(width, height, -1).transpose(1, 0, 2).reshape(height, width, *rest))


def spread(values: Floats, mask: NDArray[np.bool_], dtype: DTypeLike) -> Floats:
    """Lay (p,) or (p, c) values of the masked pixels out as a picture, 0 outside."""
    picture = np.zeros((*mask.shape, *values.shape[1:]), dtype)
    picture[mask] = values
    return picture


def _weights(old: int, new: int, start: float, step: float) -> csr_array:
    """Return how much each old pixel of a line counts for each new one, (new, old), rows summing to 1 inside."""
    if step >= 1:
        low = (start + step * np.arange(new))[:, None]
        pixel = np.floor(low).astype(np.int64) + np.arange(int(np.ceil(step)) + 1)
        weight = np.clip(np.minimum(low + step, pixel + 1) - np.maximum(low, pixel), 0, None) / step
    else:
        centre = (start + step * (np.arange(new) + 0.5))[:, None]
        first = np.floor(centre - 0.5)
        part = centre - 0.5 - first
        pixel = np.clip(np.concatenate([first, first + 1], axis=1).astype(np.int64), 0, old - 1)
        weight = np.concatenate([1 - part, part], axis=1) * ((centre > 0) & (centre < old))
    known = (pixel >= 0) & (pixel < old)
    row = np.broadcast_to(np.arange(new)[:, None], pixel.shape)
    return csr_array((weight[known], (row[known], pixel[known])), shape=(new, old))
