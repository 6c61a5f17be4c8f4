"""From numbers to what a screen shows: linear light to display values, signed numbers to colours."""

from __future__ import annotations

import matplotlib
import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.io.transfer import linear_to_srgb

SIGNED_COLOURS = "RdBu_r"  # red adds, blue takes away, white is zero


def to_display(picture: Floats, scale: float | None = None) -> Floats:
    """Return a linear picture as display values, 0 to 1.

    Parameters
    ----------
    picture
        (h, w) or (h, w, 3) linear, at least 0.
    scale
        The value that is shown as white; by default the brightest hundredth of the lit pixels is.

    Returns
    -------
    array
        The same shape, sRGB-encoded, clipped to 0 ... 1.
    """
    if scale is None:
        lit = picture[picture > 0]
        scale = float(np.quantile(lit, 0.99)) if lit.size else 1.0
    return linear_to_srgb(np.clip(picture / scale, 0.0, 1.0))


def signed_colours(picture: Floats, mask: NDArray[np.bool_], scale: float | None = None) -> NDArray[np.float64]:
    """Return signed numbers as colours: red above zero, white at zero, blue below.

    Parameters
    ----------
    picture
        (h, w) numbers.
    mask
        (h, w) booleans; light grey is shown where it is false.
    scale
        The number that is shown as full red; by default the 99th percentile of the magnitude in the mask.

    Returns
    -------
    array
        (h, w, 3) display values, 0 to 1.
    """
    if scale is None:
        scale = float(np.quantile(np.abs(picture[mask]), 0.99))
    colours = matplotlib.colormaps[SIGNED_COLOURS](np.clip(picture / (scale or 1.0), -1, 1) / 2 + 0.5)[..., :3]
    colours[~mask] = 0.93
    return np.asarray(colours)
