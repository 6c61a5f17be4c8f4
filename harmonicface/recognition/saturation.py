"""Saturation: pixels of a photograph that are burnt out, by how many are equally bright."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError

PILE = 0.8  # of the largest intensity: fewer pixels from there up to it than at it are a pile of burnt-out ones
LEAST_PILE = 0.001  # of all pixels


def burnt_out(photo: ArrayLike, mask: ArrayLike | None = None) -> NDArray[np.bool_]:
    """Return which pixels are burnt out: at the largest intensity, if more of them are there than a little below it.

    Nothing has to be known of the camera. What is exact, as renderings are, has its largest intensity once.

    Parameters
    ----------
    photo
        (h, w) intensities.
    mask
        (h, w) booleans: which pixels are looked at, all by default.

    Raises
    ------
    HarmonicFaceError
        Another shape, NaN or infinity, another mask.

    Examples
    --------
    >>> ramp = np.linspace(0, 2, 100).reshape(10, 10)
    >>> int(burnt_out(ramp).sum()), int(burnt_out(np.minimum(ramp, 1)).sum())
    (0, 50)
    """
    pixels = _validate.finite(photo, "photo")
    if pixels.ndim != 2 or pixels.size == 0:
        raise HarmonicFaceError(f"photo: expected shape (h, w), got {_validate.describe(pixels)}")
    seen = np.ones(pixels.shape, np.bool_) if mask is None else _validate.mask(mask, "mask", pixels.shape)
    largest = pixels[seen].max()
    top = seen & (pixels == largest)
    below = int((seen & (pixels >= PILE * largest)).sum()) - int(top.sum())
    piled = largest > 0 and top.sum() > max(below, LEAST_PILE * seen.sum(), 1)
    return top if piled else np.zeros(pixels.shape, np.bool_)
