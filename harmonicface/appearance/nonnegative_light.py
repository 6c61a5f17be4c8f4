"""Inverse lighting with light that cannot be negative: non-negative least squares over lamps on a spherical grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import nnls

from harmonicface import _memory, _validate
from harmonicface._validate import Floats
from harmonicface.appearance._inverse_problem import Pixels, photographed
from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.sources import DirectionalLights
from harmonicface.surfaces.surface import Surface

Array = NDArray[np.float64]

NUMERICAL_RANK = 1e-9  # of the largest singular value of the pictures under each lamp: what is below is rounding
HIDDEN = 0.01  # of the brightest lamp's picture: lamps behind the surface would be fitted to noise alone
ROWS = 1 << 14  # pixels at a time


@dataclass(frozen=True, eq=False)
class NonnegativeLight:
    """Lamps of strength 0 or more that explain a photograph.

    Parameters
    ----------
    light
        The lamps of the grid that shine. One of many such lights: see `harmonicface.appearance.uniqueness`.
    residual
        Root mean square of photograph minus picture, one number, or three of a colour photograph.
    pixels
        How many pixels were used.
    """

    light: DirectionalLights
    residual: Floats
    pixels: int


def fibonacci_sphere(count: int) -> Array:
    """Return nearly evenly spread directions, (count, 3), on a spiral of golden angles.

    Raises
    ------
    HarmonicFaceError
        A count below 1, or more than the memory holds.

    Examples
    --------
    >>> fibonacci_sphere(500).mean(axis=0).round(2) + 0.0
    array([0., 0., 0.])
    """
    _memory.require(8 * 8 * _validate.at_least(count, 1, "count"), f"{count} directions")
    steps = np.arange(count) + 0.5
    z = 1 - 2 * steps / count
    angle = np.pi * (1 + np.sqrt(5)) * steps
    ring = np.sqrt(1 - z**2)
    return np.stack([ring * np.cos(angle), ring * np.sin(angle), z], axis=-1)


def nonnegative_light(
    photo: ArrayLike,
    surface: Surface,
    directions: ArrayLike | int = 500,
    *,
    mask: ArrayLike | None = None,
    saturation: float = np.inf,
) -> NonnegativeLight:
    r"""Explain a photograph by non-negative lamps on a grid.

    .. math:: \min_{s \ge 0} \sum_x \Big( I(x) - \rho(x) \sum_i s_i \max(n(x) \cdot w_i, 0) \Big)^2

    With exact clamped cosines instead of harmonics, so that nothing is cut off at an order. No negative light makes
    some cases unique that are otherwise ambiguous (Ramamoorthi & Hanrahan, On the relationship between radiance and
    irradiance, 2001, section 5.B) and keeps noise from being amplified into light of either sign. Least squares of
    this kind ends in few lamps; they stand for the light's low frequencies, not for lamps that are there. A lamp
    whose picture has less than 1 % of the brightest one's norm, as one behind a face, is left out.

    Parameters
    ----------
    photo
        (h, w) or (h, w, 3) linear intensities.
    surface
        Its normals and albedo.
    directions
        (n, 3) directions of the grid, or how many to spread evenly over the sphere.
    mask
        (h, w) booleans, the pixels to use; all of the Surface by default.
    saturation
        Pixels at or above it, in any channel, are left out.

    Returns
    -------
    NonnegativeLight
        The lamps and how well they explain the photograph.

    Raises
    ------
    HarmonicFaceError
        A photo of another shape, NaN in the mask, no pixel left, no albedo, directions that are none.

    Examples
    --------
    >>> import numpy as np, harmonicface as hf
    >>> wall = hf.Surface(np.tile([0.0, 0.0, 1.0], (4, 4, 1)), np.ones((4, 4)))
    >>> float(nonnegative_light(np.full((4, 4), 0.5), wall).light.irradiance([0.0, 0.0, 1.0]).round(6))
    0.5
    """
    towards = (
        fibonacci_sphere(directions if isinstance(directions, bool) else int(directions))
        if isinstance(directions, (int, np.integer))
        else _validate.directions(directions, "directions").astype(np.float64)
    )
    if towards.ndim != 2 or len(towards) == 0:
        raise HarmonicFaceError(f"directions: expected shape (n, 3) or a number of them, got shape {towards.shape}")
    _memory.require(8 * 2 * len(towards) ** 2, f"lamps in {len(towards)} directions")
    pixels = photographed(photo, surface, mask, saturation)
    strengths, squares = nonnegative_strengths(pixels, towards)
    shines = np.flatnonzero(strengths.any(axis=1))
    if not len(shines):
        shines = np.array([0])  # in the dark one lamp of strength 0 is left
    coloured = strengths.shape[1] == 3
    lamps = strengths[shines] if coloured else strengths[shines, 0]
    residual = np.sqrt(squares / len(pixels.normals))
    return NonnegativeLight(
        DirectionalLights(towards[shines], lamps), residual if coloured else residual[0], len(pixels.normals)
    )


def nonnegative_strengths(pixels: Pixels, towards: Array) -> tuple[Array, Array]:
    """Return each lamp's strength, (n, channels), and the sum of squares that they leave."""
    strengths, squares = [], []
    parts = np.hsplit(pixels.intensities, len(pixels.albedos))
    for albedo, part in zip(pixels.albedos, parts, strict=True):
        pictures, images, rest = _compressed(pixels.normals, albedo, towards, part)
        for image, unexplained in zip(images.T, rest, strict=True):
            found = np.zeros(len(towards))
            lit = np.asarray(np.linalg.norm(pictures, axis=0))
            useful = np.flatnonzero(lit > HIDDEN * lit.max())
            found[useful], misfit = nnls(pictures[:, useful], image, maxiter=50 * len(towards))
            strengths.append(found)
            squares.append(misfit**2 + unexplained)
    return np.stack(strengths, axis=-1), np.array(squares)


def _compressed(normals: Array, albedo: Array, towards: Array, part: Array) -> tuple[Array, Array, Array]:
    """Return the least squares problem on its few numerically independent rows, and the squares outside of them."""
    count = len(towards)
    triangle = np.zeros((0, count + part.shape[1]))
    for first in range(0, len(normals), ROWS):
        block = slice(first, first + ROWS)
        pictures = albedo[block, None] * np.maximum(normals[block] @ towards.T, 0)
        stacked = np.concatenate([triangle, np.concatenate([pictures, part[block]], axis=1)])
        triangle = np.asarray(np.linalg.qr(stacked, mode="r"))
    left, values, right = np.linalg.svd(triangle[:, :count], full_matrices=False)
    rank = int((values > NUMERICAL_RANK * values[0]).sum())
    images = left[:, :rank].T @ triangle[:, count:]
    outside = triangle[:, count:] - left[:, :rank] @ images
    return values[:rank, None] * right[:rank], images, np.asarray((outside**2).sum(axis=0))
