"""Curl: what tells normals of a surface from others, whatever frame they are given in."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]

SCALE = 0.1  # of a Cauchy loss, over the median length of the terms: creases and noise count little beyond
BLACK = 0.05  # of the median length: below, the direction is noise's


def curl_terms(scaled: Doubles, mask: Mask) -> Doubles:
    r"""Return what the curl of a surface's slopes is made of in any frame, (m, 6), for pixels with four neighbours.

    In the frame A the scaled normals are A s, and slopes -b_x/b_z, -b_y/b_z have no curl where

    .. math:: P_1 \cdot (s \times \partial_x s) + P_2 \cdot (s \times \partial_y s) = 0

    with P_1 and P_2 the first rows of A's cofactor matrix (Yuille & Snow, Shape and albedo from multiple images using
    integrability, 1997). Both cross products are divided by the square of s, so that albedo counts for nothing.

    Parameters
    ----------
    scaled
        (p, 3) scaled normals of the masked pixels in any frame.
    mask
        (h, w) booleans.

    Examples
    --------
    >>> y, x = np.mgrid[0.8:-0.8:9j, -0.8:0.8:9j] / 2
    >>> sphere = np.stack([x, y, np.sqrt(1 - x**2 - y**2)], axis=2)
    >>> terms = curl_terms(sphere.reshape(-1, 3), np.ones((9, 9), bool))
    >>> terms.shape, bool(np.abs(terms[:, 0] + terms[:, 4]).max() < 1e-3)
    ((49, 6), True)
    """
    lengths = np.linalg.norm(scaled, axis=1)
    grid = np.full((*mask.shape, 3), np.nan)
    grid[mask] = np.where(lengths[:, None] > BLACK * np.median(lengths), scaled, np.nan)
    middle = grid[1:-1, 1:-1]
    right = (grid[1:-1, 2:] - grid[1:-1, :-2]) / 2
    up = (grid[:-2, 1:-1] - grid[2:, 1:-1]) / 2
    square = np.einsum("hwk,hwk->hw", middle, middle)
    with np.errstate(invalid="ignore"):
        whole = np.isfinite(right).all(axis=2) & np.isfinite(up).all(axis=2) & (square > 0)
    own, length = middle[whole], square[whole][:, None]
    return np.hstack([np.cross(own, right[whole]) / length, np.cross(own, up[whole]) / length])
