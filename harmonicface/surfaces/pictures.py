"""Pictures: what a Surface looks like, to be shown on a screen."""

from __future__ import annotations

import math

import matplotlib
import numpy as np

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.pictures import signed_colours, to_display
from harmonicface.surfaces._resampling import spread
from harmonicface.surfaces.surface import Surface

HEIGHTS = "cividis"  # dark blue is far, yellow is near; the same to colour-blind eyes
LAMP = np.array([-0.45, 0.6, 0.66])  # upper left, as maps are lit
CONTOURS = 12  # about so many


def surface_pictures(surface: Surface) -> dict[str, Floats]:
    """Return pictures of what a Surface is made of, in display values from 0 to 1, black outside the mask.

    Parameters
    ----------
    surface
        What is shown.

    Returns
    -------
    dict
        - "normals", (h, w, 3): rgb = (n + 1) / 2, as normal maps have it; x to the right is red, y up green, z blue.
        - "albedo", (h, w) or (h, w, 3): sRGB-encoded; white is 1, or the largest albedo if that is more.
        - "depth", (h, w, 3), if there is depth: a relief lit from the upper left, blue far to yellow near, with a dark
          contour every `contour_interval` of depth.
        - "mask", (h, w): white inside.

    Examples
    --------
    >>> wall = Surface(np.tile([0.0, 0.0, 1.0], (1, 1, 1)), np.full((1, 1), 1.0))
    >>> {name: picture.round(2).tolist() for name, picture in surface_pictures(wall).items()}
    {'normals': [[[0.5, 0.5, 1.0]]], 'albedo': [[1.0]], 'mask': [[1.0]]}
    """
    normals = (surface.normals.clip(-1, 1) + 1) / 2
    normals[~surface.mask] = 0
    pictures = {"normals": normals, "albedo": to_display(surface.albedo, max(1.0, float(surface.albedo.max())))}
    if surface.depth is not None:
        pictures["depth"] = _relief(surface)
    pictures["mask"] = surface.mask.astype(surface.normals.dtype)
    return pictures


def harmonic_pictures(surface: Surface, images: Floats, scale: float | None = None) -> list[Floats]:
    """Return harmonic images as colours: red adds light, white is zero, blue takes it away, grey is outside.

    Parameters
    ----------
    surface
        Whose images they are.
    images
        (k, p) as `harmonic_images` returns them, or any others with a column for each masked pixel.
    scale
        The number that is shown as full red; by default `common_scale`, so that colours compare.

    Returns
    -------
    list
        k pictures (h, w, 3) of display values, 0 to 1.

    Raises
    ------
    HarmonicFaceError
        Another shape, NaN.

    Examples
    --------
    >>> wall = Surface(np.tile([0.0, 0.0, 1.0], (1, 2, 1)), np.ones((1, 2)))
    >>> [picture] = harmonic_pictures(wall, np.array([[1.0, -1.0]]))
    >>> picture.round(1)
    array([[[0.4, 0. , 0.1], [0. , 0.2, 0.4]]])
    """
    values = _validate.finite(images, "images")
    if values.ndim != 2 or values.shape[1] != surface.mask.sum():
        expected = f"(k, {surface.mask.sum()}), a column for each masked pixel"
        raise HarmonicFaceError(f"images: expected shape {expected}, got {_validate.describe(values)}")
    full = common_scale(values) if scale is None else _validate.positive(scale, "scale")
    return [signed_colours(spread(image, surface.mask, values.dtype), surface.mask, full) for image in values]


def common_scale(images: Floats) -> float:
    """Return one scale for several images (k, p): the 99th percentile of the strongest one's magnitude, 1 if all are 0.

    Examples
    --------
    >>> common_scale(np.array([[0.0, 0.5], [-3.0, -3.0]]))
    3.0
    """
    return max((float(np.quantile(np.abs(image), 0.99)) for image in images), default=0.0) or 1.0


def contour_interval(surface: Surface) -> float | None:
    """Return the depth between the contours of a Surface's picture: 1, 2 or 5 times a power of ten, about 12 in all.

    Returns
    -------
    float or None
        World units; None without depth, and where all depths are the same.

    Examples
    --------
    >>> ramp = Surface(np.tile([0.0, 0.0, 1.0], (1, 5, 1)), np.ones((1, 5)), depth=[[0.0, 6, 12, 18, 25]])
    >>> contour_interval(ramp)
    2.0
    """
    if surface.depth is None:
        return None
    depths = surface.depth[surface.mask].astype(np.float64)
    extent = float(depths.max() - depths.min())
    if extent == 0:
        return None
    power = 10.0 ** math.floor(math.log10(extent / CONTOURS))
    factors = np.array([1.0, 2.0, 5.0, 10.0])
    return float(power * factors[np.abs(np.log(factors * power * CONTOURS / extent)).argmin()])


def _relief(surface: Surface) -> Floats:
    """Return depth as colours, shaded by the normals, with contours."""
    assert surface.depth is not None
    inside = surface.mask
    depth = np.where(inside, surface.depth, np.nan).astype(np.float64)
    low, high = np.nanmin(depth), np.nanmax(depth)
    height = np.zeros(depth.shape) if high == low else np.where(inside, (depth - low) / (high - low), 0.0)
    shade = 0.25 + 0.75 * np.clip(surface.normals @ LAMP, 0, 1)
    relief = matplotlib.colormaps[HEIGHTS](height)[..., :3] * shade[..., None]
    interval = contour_interval(surface)
    if interval is not None:
        band = np.floor((depth - low) / interval)
        line = np.zeros(inside.shape, bool)
        line[:, 1:] |= np.abs(np.diff(band, axis=1)) > 0  # NaN, beside what is outside, is not above 0
        line[1:] |= np.abs(np.diff(band, axis=0)) > 0
        relief[line] *= 0.55
    relief[~inside] = 0
    return np.asarray(relief.astype(surface.normals.dtype))
