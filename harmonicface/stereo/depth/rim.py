"""The rim: whether a surface is seen as it is or inside out, which photographs under unknown lights leave open."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]

WIDTH = 0.04  # of the root of the mask's area: how far the rim reaches inward
DECIDED = 0.15  # mean outward slant of the rim's normals, as a sine: below, it may be a dent as well


def outward_slant(scaled: Doubles, mask: Mask) -> float:
    """Return how much normals near the edge of the mask point out of it: the mean sine, 1 for a rim seen edge-on.

    Things bulge toward whoever looks at them, and turn away at their rim. The border of the picture is rim as well.

    Parameters
    ----------
    scaled
        (p, 3) scaled normals of the masked pixels.
    mask
        (h, w) booleans.

    Examples
    --------
    >>> y, x = np.mgrid[0.8:-0.8:33j, -0.8:0.8:33j]
    >>> inside = x**2 + y**2 < 0.8**2
    >>> ball = np.stack([x, y, np.sqrt(np.maximum(1 - x**2 - y**2, 0))], axis=2)[inside]
    >>> outward_slant(ball, inside).__round__(1), outward_slant(ball * [-1, -1, 1], inside).__round__(1)
    (0.8, -0.8)
    """
    width = max(WIDTH * np.sqrt(mask.sum()), 1.0)
    margin = int(np.ceil(4 * width))
    soft = gaussian_filter(np.pad(mask, margin).astype(np.float64), width)[margin:-margin, margin:-margin]
    down, right = np.gradient(np.pad(soft, 1, mode="edge"))
    outward = np.stack([-right[1:-1, 1:-1][mask], down[1:-1, 1:-1][mask]], axis=1)
    steepness = np.linalg.norm(outward, axis=1)
    near = steepness > 0.5 * steepness.max()
    outward = outward[near] / steepness[near][:, None]
    lengths = np.linalg.norm(scaled[near], axis=1)
    sines = np.einsum("pk,pk->p", scaled[near][:, :2], outward) / np.where(lengths > 0, lengths, 1.0)
    return float(sines.mean())
