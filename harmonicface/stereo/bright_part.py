"""Bright part: the mask of a thing before a dark background, where nobody drew one."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import binary_fill_holes, binary_opening, label
from skimage.filters import threshold_otsu

from harmonicface import _validate

DARK = 0.45  # of the bright part's square root of brightness: a background above it is none
LEAST = 0.02  # of the picture
SPECKS = 2  # pixels


def bright_part(brightest: ArrayLike) -> NDArray[np.bool_] | None:
    """Return the largest part that stands out from a dark background in some photograph; None where nothing does.

    Otsu's threshold (1979) parts the square roots of the brightest that each pixel shows; then specks go, the largest
    connected part stays, and its holes are filled. Corners lose up to three pixels.

    Parameters
    ----------
    brightest
        (h, w) linear, the most that each pixel shows in any photograph.

    Returns
    -------
    array or None
        (h, w) booleans.

    Raises
    ------
    HarmonicFaceError
        Another shape, NaN.

    Examples
    --------
    >>> picture = np.zeros((20, 20))
    >>> picture[4:16, 4:16] = 0.5
    >>> int(bright_part(picture).sum()), bright_part(np.full((20, 20), 0.5)) is None
    (132, True)
    """
    root = np.sqrt(np.maximum(_validate.image(brightest, "brightest"), 0))
    if root.min() == root.max():
        return None
    bright = root > threshold_otsu(root)
    if np.median(root[~bright]) > DARK * np.median(root[bright]):
        return None
    opened = binary_opening(bright, iterations=SPECKS)
    parts, count = label(opened)
    if count == 0:
        return None
    largest = parts == np.bincount(parts.ravel())[1:].argmax() + 1
    filled = np.asarray(binary_fill_holes(largest))
    return filled if filled.mean() >= LEAST and not filled.all() else None
