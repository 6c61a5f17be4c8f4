"""Rows of a table as the images that they are."""

from __future__ import annotations

import numpy as np

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError


def as_images(pixels: Floats, image_shape: tuple[int, int] | None) -> Floats:
    """Return rows (n, h * w) as images (n, h, w), without copying them.

    Raises
    ------
    HarmonicFaceError
        No shape, or one of another number of pixels.

    Examples
    --------
    >>> as_images(np.zeros((5, 12)), (3, 4)).shape
    (5, 3, 4)
    """
    if image_shape is None or len(image_shape) != 2:
        given = _validate.describe(image_shape)
        raise HarmonicFaceError(f"image_shape: expected (height, width) of the photographs in the table, got {given}")
    height, width = (_validate.at_least(size, 1, "image_shape") for size in image_shape)
    if height * width != pixels.shape[1]:
        expected = f"the height and width of {pixels.shape[1]} pixels"
        raise HarmonicFaceError(f"image_shape: expected {expected}, got {(height, width)}")
    return np.asarray(pixels.reshape(-1, height, width))
