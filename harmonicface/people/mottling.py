"""Random fields on the face: knots on a grid of the mean face, and the smooth field through them."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FIELD = (-84.0, -124.0, 84.0, 70.0)  # mm: left, bottom, right and top of the area that knots cover
REMAPPED = 1024  # pixels a line: OpenCV takes lines of less than 32,768


def draw_knots(rng: np.random.Generator, across: float, up: float) -> NDArray[np.float32]:
    """Draw a grid of standard normal numbers over the face with some mm between them."""
    left, bottom, right, top = FIELD
    shape = int((top - bottom) / up) + 2, int((right - left) / across) + 2
    return rng.standard_normal(shape, dtype=np.float32)


def field_at(knots: NDArray[np.float32], x: Array, y: Array, across: float, up: float) -> Array:
    """Return the cubic field through knots at places in mm, (p,); beyond the area it is mirrored."""
    if not len(x):
        return np.zeros(0)
    lines = -(-len(x) // REMAPPED)
    columns, rows = (
        np.resize(((place - start) / spacing).astype(np.float32), (lines, REMAPPED))
        for place, start, spacing in ((x, FIELD[0], across), (y, FIELD[1], up))
    )
    values = cv2.remap(knots, columns, rows, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT)
    return np.asarray(values.ravel()[: len(x)], dtype=np.float64)


def edge(distance: Array, softness: float) -> Array:
    """Return 0 well outside a border, 1 well inside, by the distance to it in mm, over about +-softness."""
    t = np.clip(0.5 + 0.5 * distance / softness, 0, 1)
    return np.asarray(t * t * (3 - 2 * t))
