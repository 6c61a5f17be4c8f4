"""Sky cells: the sphere of directions in equal cells, how much of each a pixel sees, and how it is lit from there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.surfaces.horizon import horizons

AZIMUTHS, HEIGHTS = 16, 12
SOLID_ANGLE = 4 * np.pi / (AZIMUTHS * HEIGHTS)

Doubles = NDArray[np.float64]
Singles = NDArray[np.float32]
Mask = NDArray[np.bool_]


def _angles() -> Doubles:
    """Return the azimuths of the cells' middles."""
    return np.asarray(2 * np.pi * np.arange(AZIMUTHS) / AZIMUTHS)


def cell_directions() -> Doubles:
    """Return the middles of the cells, (192, 3) unit vectors: 16 azimuths about the camera's axis, 12 heights each.

    Examples
    --------
    >>> directions = cell_directions()
    >>> directions.shape, bool(np.allclose(directions.mean(axis=0), 0))
    ((192, 3), True)
    """
    z = (2 * np.arange(HEIGHTS) + 1) / HEIGHTS - 1
    across = np.sqrt(1 - z**2)
    parts = np.outer(np.cos(_angles()), across), np.outer(np.sin(_angles()), across), np.tile(z, (AZIMUTHS, 1))
    return np.stack(parts, axis=-1).reshape(-1, 3)


def cell_visibility(depth: Floats, mask: Mask) -> Singles:
    """Return how much of each cell a depth map in pixels leaves to its pixels, (p, 192) from 0 to 1."""
    edges = np.linspace(-1, 1, HEIGHTS + 1)[1:]
    lowest = np.sin(horizons(depth, mask, 1.0, _angles())).T
    free = np.clip((edges - lowest[:, :, None]) * (HEIGHTS / 2), 0, 1)
    return np.asarray(free.reshape(len(free), -1), np.float32)


def cell_shades(normals: Floats, visibility: Singles | None = None) -> Singles:
    r"""Return the irradiance of pixels per radiance of each cell, (192, p): `max(n . w, 0)` times its solid angle.

    Parameters
    ----------
    normals
        (p, 3) unit vectors.
    visibility
        (p, 192) of `cell_visibility`; by default nothing is hidden.
    """
    cosine = normals.astype(np.float32) @ cell_directions().astype(np.float32).T
    shades = np.maximum(cosine, 0) * np.float32(SOLID_ANGLE)
    return np.ascontiguousarray((shades if visibility is None else shades * visibility).T)


def cell_flow(normals: Floats, radiance: Floats, visibility: Singles | None = None) -> Doubles:
    r"""Return the vectors e of irradiance, (p, n, 3), of pixels under n lights: `irradiance = n . e`.

    The sum of radiance times direction over what of the cells is above a pixel's tangent plane and not hidden; it is
    also the derivative of the irradiance by the normal.

    Parameters
    ----------
    normals
        (p, 3) unit vectors.
    radiance
        (n, 192) of the cells.
    visibility
        (p, 192) of `cell_visibility`; by default nothing is hidden.
    """
    towards = cell_directions()
    cosine = normals.astype(np.float32) @ towards.astype(np.float32).T
    above = (cosine > 0).astype(np.float32)
    if visibility is not None:
        above *= visibility
    sources = (radiance[:, None, :] * towards.T * SOLID_ANGLE).reshape(-1, len(towards)).astype(np.float32)
    return np.asarray((above @ sources.T).reshape(len(normals), len(radiance), 3), np.float64)
