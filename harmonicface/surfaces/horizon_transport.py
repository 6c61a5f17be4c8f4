"""Transport of a depth map: light past its horizons, exact in elevation and summed over azimuths."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from harmonicface import _memory, _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import count, degrees, modes
from harmonicface.reflectance.filters import lambertian_weights
from harmonicface.surfaces._terrain import Terrain
from harmonicface.surfaces.horizon import horizon_slopes
from harmonicface.surfaces.surface import Surface

Doubles = NDArray[np.float64]

AZIMUTHS = 48
TOGETHER = 8  # azimuths of one matrix product
BLOCK = 1 << 10  # pixels of one matrix product
STEEPEST = 1e12  # slopes beyond are vertical: their angle is pi/2 to the last digit


def horizon_transport(surface: Surface, order: int, azimuths: int = AZIMUTHS) -> Floats:
    r"""Return the transport of direct light of a Surface whose own depth is all that casts shadows, (k, p).

    With the horizon h and the directions (cos e cos phi, cos e sin phi, sin e)

    .. math:: T_{lm}(x) = A_l Y_{lm}(n) - \frac{2\pi}{a} \sum_\phi \{\cos m\phi, \sin|m|\phi\} \int_{e_0}^{\max(e_0, h)}
              Y_{l|m|}(e) (n_\phi \cos e + n_z \sin e) \cos e \, de

    where e_0 is the elevation at which the tangent plane ends, and n_phi the normal's part along the azimuth phi. The
    integrand is a trigonometric polynomial in e, so that the elevations are integrated exactly; only what is
    hidden is summed over azimuths, so that pixels without cast shadows are exact.

    Parameters
    ----------
    surface
        A Surface with depth.
    order
        The highest degree l, at least 0.
    azimuths
        How many azimuths are summed, at least 3.

    Returns
    -------
    array
        (k, p) of the type of the normals, k = (order + 1)^2 and p masked pixels in row-major order.

    Raises
    ------
    HarmonicFaceError
        A Surface without depth, a negative order, too few azimuths.

    Examples
    --------
    >>> wall = Surface(np.tile([0.0, 0.0, 1.0], (1, 2, 1)), np.ones((1, 2)), depth=np.zeros((1, 2)))
    >>> horizon_transport(wall, 1).round(4) + 0.0
    array([[0.8862, 0.8862],
           [0.    , 0.    ],
           [1.0233, 1.0233],
           [0.    , 0.    ]])
    """
    if surface.depth is None:
        raise HarmonicFaceError("surface: expected one with depth, got none (surface_from_depth and meshes have it)")
    number = _validate.at_least(azimuths, 3, "azimuths")
    pixels = int(surface.mask.sum())
    _memory.require(24 * count(order) * pixels, f"transport of order {order} at {pixels} pixels")
    result = real_harmonics(surface.pixel_normals, order)
    result *= lambertian_weights(order).astype(result.dtype)[:, None]
    angles = 2 * np.pi * np.arange(number) / number
    terrain = Terrain.of(surface.depth, surface.mask, surface.pixel_size)
    slopes = horizon_slopes(terrain, angles, _tangent_planes(surface, angles))
    integrals = hidden_integrals(order)
    for first in range(0, number, TOGETHER):
        some = angles[first : first + TOGETHER]
        seen = np.stack([next(slopes)[surface.mask] for _ in some])
        _take_away(result, surface.pixel_normals, seen, some, integrals, 2 * math.pi / number)
    return result


def hidden_integrals(order: int) -> Doubles:
    r"""Return the antiderivatives of Y_lm(e) cos^2 e and Y_lm(e) sin e cos e as trigonometric sums, (2, k, 2 d + 1).

    Y_lm(e) is the harmonic of mode |m| at (cos e, 0, sin e). Columns are the coefficients of e, cos e ... cos(d e), sin
    e ... sin(d e) with d = order + 2.
    """
    degree = order + 2
    samples = 2 * degree + 2
    e = 2 * np.pi * np.arange(samples) / samples
    cosine, sine = np.cos(e), np.sin(e)
    l, m = degrees(order), np.abs(modes(order))  # noqa: E741
    harmonics = real_harmonics(np.stack([cosine, np.zeros(samples), sine], axis=1), order)[l * (l + 1) + m]
    waves = np.fft.rfft(np.stack([harmonics * cosine**2, harmonics * sine * cosine]))[..., : degree + 1] / samples
    k = np.arange(1, degree + 1)
    return np.concatenate([waves[..., :1].real, 2 * waves[..., 1:].imag / k, 2 * waves[..., 1:].real / k], axis=-1)


def _tangent_planes(surface: Surface, azimuths: Doubles) -> Iterator[Doubles]:
    """Yield the slopes of the tangent planes along azimuths, (h, w); where normals point down, no slope matters."""
    for azimuth in azimuths:
        along = -math.cos(azimuth) * surface.normals[..., 0] - math.sin(azimuth) * surface.normals[..., 1]
        slope = np.full(surface.shape, STEEPEST)
        up = surface.normals[..., 2] > 0
        np.divide(along, surface.normals[..., 2], out=slope, where=up)
        slope[surface.mask & ~up] = -STEEPEST
        yield np.clip(slope, -STEEPEST, STEEPEST, out=slope)


def _take_away(
    result: Floats, normals: Floats, slopes: Doubles, azimuths: Doubles, integrals: Doubles, weight: float
) -> None:
    """Subtract what lies between the tangent planes and the horizons (a, p) of some azimuths."""
    order = math.isqrt(len(result)) - 1
    m = modes(order)[:, None]
    waves = weight * np.where(m < 0, np.sin(-m * azimuths), np.cos(m * azimuths))
    matrix = np.einsum("ka,ckd->kacd", waves, integrals).reshape(len(result), -1)
    across = np.stack([np.cos(azimuths), np.sin(azimuths)], axis=1)
    for first in range(0, slopes.shape[1], BLOCK):
        pixels = slice(first, first + BLOCK)
        normal = normals[pixels].astype(np.float64)
        along, up = across @ normal[:, :2].T, normal[:, 2]
        lower, upper = _hidden_range(along, up, slopes[:, pixels])
        waves_between = _waves(upper, order + 2) - _waves(lower, order + 2)  # (d, a, n)
        parts = np.empty((len(azimuths), 2, len(waves_between), along.shape[1]))
        np.multiply(waves_between.transpose(1, 0, 2), along[:, None], out=parts[:, 0])
        np.multiply(waves_between.transpose(1, 0, 2), up, out=parts[:, 1])
        result[:, pixels] -= matrix @ parts.reshape(-1, along.shape[1])


def _hidden_range(along: Doubles, up: Doubles, slopes: Doubles) -> tuple[Doubles, Doubles]:
    """Return the slopes between which light in front of the tangent plane is hidden, both (a, n)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        plane = np.clip(np.nan_to_num(-along / up, nan=0.0), -STEEPEST, STEEPEST)
    lower = np.where(up > 0, plane, -STEEPEST)
    upper = np.clip(slopes, lower, np.where(up > 0, STEEPEST, plane))
    return lower, np.maximum(lower, upper)


def _waves(slopes: Doubles, degree: int) -> Doubles:
    """Return e, cos e ... cos(d e), sin e ... sin(d e) of the angles with some tangents, (2 d + 1, a, n)."""
    result = np.empty((2 * degree + 1, *slopes.shape))
    cosine = 1 / np.sqrt(1 + slopes * slopes)
    sine = slopes * cosine
    result[0] = np.arctan(slopes)
    for first, start in ((1, 1.0), (1 + degree, 0.0)):
        waves = result[first : first + degree]
        waves[0] = cosine if start else sine
        for k in range(1, degree):
            np.multiply(waves[k - 1], 2 * cosine, out=waves[k])
            waves[k] -= waves[k - 2] if k > 1 else start
    return result
