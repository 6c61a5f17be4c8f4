"""Texture lookup: an image wrapped around a mesh, seen at the raster's own density."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from harmonicface._validate import Floats


def shrink_to_density(texture: Floats, texels: float) -> Floats:
    """Average a texture until a pixel of the raster covers about one of its texels.

    Parameters
    ----------
    texture
        (h, w) or (h, w, 3) linear values.
    texels
        Texels a pixel covers along one side; at most 1 leaves the texture as it is.

    Returns
    -------
    array
        The smaller texture; each value is the mean over the area that it stands for.

    Examples
    --------
    >>> shrink_to_density(np.eye(4, dtype=np.float32), 4.0)
    array([[0.25]], dtype=float32)
    """
    if texels <= 1:
        return texture
    height, width = (max(1, round(side / texels)) for side in texture.shape[:2])
    return np.asarray(cv2.resize(texture, (width, height), interpolation=cv2.INTER_AREA))


def look_up(texture: Floats, uv: Floats) -> NDArray[np.float32]:
    """Return the bilinear values of a texture that repeats in both directions.

    Texel centres are at half-integers, and v points up: (0, 1) is the top left corner.

    Parameters
    ----------
    texture
        (h, w) or (h, w, 3) linear values.
    uv
        (p, 2) texture coordinates.

    Returns
    -------
    (p,) or (p, 3) float32.

    Examples
    --------
    >>> look_up(np.array([[0.0, 1.0], [2.0, 3.0]]), np.array([[0.25, 0.75], [0.5, 0.5]]))
    array([0. , 1.5], dtype=float32)
    """
    height, width = texture.shape[:2]
    rows = (1 - uv[:, 1]) * height - 0.5
    columns = uv[:, 0] * width - 0.5
    channels = np.atleast_3d(texture)
    values = np.empty((len(uv), channels.shape[2]), dtype=np.float32)
    for channel in range(channels.shape[2]):
        map_coordinates(
            channels[..., channel],
            (rows, columns),
            output=values[:, channel],
            order=1,
            mode="grid-wrap",
            prefilter=False,
        )
    return values if texture.ndim == 3 else values[:, 0]
