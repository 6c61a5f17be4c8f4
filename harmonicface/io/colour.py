"""From linear colour to the grey that a monochrome camera records."""

from __future__ import annotations

import numpy as np

from harmonicface._validate import Floats

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of linear red, green and blue (ITU-R BT.709)


def luminance(colours: Floats) -> Floats:
    """Return the luminance of linear colours.

    Parameters
    ----------
    colours
        (..., 3) linear red, green, blue.

    Returns
    -------
    array
        (...) in the same type.

    Examples
    --------
    >>> float(luminance(np.array([1.0, 1.0, 1.0])))
    1.0
    """
    return np.asarray(colours @ LUMINANCE.astype(colours.dtype))
