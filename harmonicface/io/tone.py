"""Tone mapping: pictures of high dynamic range for the screen."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.colour import luminance
from harmonicface.io.transfer import linear_to_srgb


def tone_mapped(radiance: ArrayLike, key: float = 0.18, white: float | None = None) -> Floats:
    r"""Return display values of a picture whose brightness spans many orders of magnitude.

    .. math:: L = \mathrm{key} \, Y / \exp(\overline{\log Y}), \quad L_d = L (1 + L / L_{white}^2) / (1 + L)

    the global operator of Reinhard, Stark, Shirley & Ferwerda, Photographic tone reproduction for digital images,
    2002 (equations 2 and 4), on luminances Y; colours keep their ratios and are clipped and sRGB-encoded at the end.
    The mean of logarithms is over pixels that are not black. For looking at, not for measuring.

    Parameters
    ----------
    radiance
        (...), or (..., 3) colours, linear, at least 0.
    key
        The linear display value of the mean brightness before compression, above 0.
    white
        The least scaled luminance L that is shown as white; by default the picture's largest.

    Returns
    -------
    array
        The same shape, display values 0 to 1.

    Raises
    ------
    HarmonicFaceError
        NaN, infinite or negative radiance, a key or white that is not above 0.

    Examples
    --------
    >>> tone_mapped([[0.0, 1.0, 10000.0]]).round(3)
    array([[0.   , 0.023, 1.   ]])
    """
    values = _validate.finite(radiance, "radiance")
    if values.size and values.min() < 0:
        raise HarmonicFaceError(f"radiance: expected at least 0, got {values.min():.4g}")
    coloured = values.ndim > 2 and values.shape[-1] == 3
    bright = luminance(values) if coloured else values
    lit = bright[bright > 0]
    if lit.size == 0:
        return np.zeros_like(values)
    exposure = _validate.positive(key, "key") / float(np.exp(np.log(lit, dtype=np.float64).mean()))
    scaled = bright * exposure
    top = float(scaled.max()) if white is None else _validate.positive(white, "white")
    compression = exposure * (1 + scaled / top**2) / (1 + scaled)
    shown = values * (compression[..., None] if coloured else compression)
    return linear_to_srgb(np.clip(shown, 0, 1).astype(values.dtype, copy=False))
