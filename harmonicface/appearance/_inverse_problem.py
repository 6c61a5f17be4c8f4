"""The linear algebra of inverse lighting: pixels -> a small triangular system -> coefficients and their errors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import degrees
from harmonicface.reflectance.filters import lambertian_weights
from harmonicface.surfaces.surface import Surface

Array = NDArray[np.float64]

BEYOND = 6  # degrees above the order whose light may pass for light of the order: the filter lets next to none above
RANK = 1e-6  # of the largest singular value of the images; below, float32 normals differ by rounding alone
CUT = 1.0  # a direction whose error exceeds the ambient light is not returned as a number
TRUSTED = 0.5  # a coefficient is recoverable while its error stays below this share of the ambient light
ROWS = 1 << 15  # pixels at a time


@dataclass(frozen=True, eq=False)
class Pixels:
    """What is read of a photograph: (p, 3) normals, (p, channels) intensities, and one albedo or one a channel."""

    normals: Array
    intensities: Array
    albedos: list[Array]


@dataclass(frozen=True, eq=False)
class Factors:
    """Least squares over p pixels, reduced: |images.T @ L - photo|^2 = |R L - z|^2 + rest^2."""

    triangle: Array  # R, (r, k)
    beyond: Array  # the same of the degrees above the order, (r, n)
    image: Array  # z, (r,)
    rest: float
    brightness: float  # root of the mean square of the photograph
    pixels: int
    order: int


@dataclass(frozen=True, eq=False)
class Solution:
    """The solved system; directions are rows over the k modes that a matte surface shows."""

    values: Array
    std: Array
    systematic: Array
    recoverable: NDArray[np.bool_]
    singular_values: Array
    condition: float
    residual: float
    noise: float
    kept: Array
    hidden: Array
    drowned: Array


def shown(order: int) -> NDArray[np.intp]:
    """Return where the modes with A_l > 0 are stored: degrees 0, 1, 2, 4, 6 ..."""
    return np.flatnonzero(lambertian_weights(order))


def photographed(photo: ArrayLike, surface: Surface, mask: ArrayLike | None, saturation: float) -> Pixels:
    """Return the pixels that count: in both masks, and below saturation in every channel."""
    array = _validate.floats(photo, "photo")
    if array.shape not in (surface.shape, (*surface.shape, 3)):
        expected = f"shape {surface.shape} or {(*surface.shape, 3)}, as the surface"
        raise HarmonicFaceError(f"photo: expected {expected}, got {_validate.describe(array)}")
    if isinstance(saturation, bool) or not saturation > 0:
        raise HarmonicFaceError(f"saturation: expected a number above 0, got {saturation}")
    inside = surface.mask if mask is None else surface.mask & _validate.mask(mask, "mask", surface.shape)
    intensities = _validate.finite(array[inside], "photo").astype(np.float64)
    intensities = intensities.reshape(len(intensities), 3 if array.ndim == 3 else 1)
    usable = np.asarray((intensities < saturation).all(axis=1))
    if not usable.any():
        raise HarmonicFaceError(
            f"photo: expected pixels in the masks below saturation={saturation:g}, got none of {len(usable)}"
        )
    coloured = intensities.shape[1] == 3 and surface.albedo.ndim == 3
    albedo = surface.pixel_albedo.T if coloured else surface.grey_albedo[None]
    chosen = inside[surface.mask]
    albedos = [each[chosen][usable].astype(np.float64) for each in albedo]
    if not all(each.any() for each in albedos):
        raise HarmonicFaceError("surface: expected some albedo above 0 among the pixels used, got 0 everywhere")
    normals = surface.pixel_normals[chosen][usable].astype(np.float64)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Pixels(normals, intensities[usable], albedos)


def reduced(normals: Array, albedo: Array, intensities: Array, order: int) -> list[Factors]:
    """Reduce p equations of each channel to a triangle, a block of pixels at a time."""
    far = order + BEYOND
    weights = lambertian_weights(far)
    columns = np.flatnonzero(weights)
    triangle = np.zeros((0, len(columns) + intensities.shape[1]))
    for first in range(0, len(normals), ROWS):
        block = slice(first, first + ROWS)
        images = real_harmonics(normals[block], far)[columns] * weights[columns, None] * albedo[block]
        rows = np.concatenate([images.T, intensities[block]], axis=1)
        triangle = np.asarray(np.linalg.qr(np.concatenate([triangle, rows]), mode="r"))
    k, n = int((degrees(far)[columns] <= order).sum()), len(columns)
    return [
        Factors(
            triangle[:k, :k],
            triangle[:k, k:n],
            triangle[:k, n + channel],
            float(np.linalg.norm(triangle[k:, n + channel])),
            float(np.linalg.norm(intensities[:, channel]) / np.sqrt(len(normals))),
            len(normals),
            order,
        )
        for channel in range(intensities.shape[1])
    ]


def solved(factors: Factors, noise: float | None, ridge: float | None) -> Solution:
    """Solve the reduced system and tell the error of each coefficient."""
    left, values, right = np.linalg.svd(factors.triangle)
    values = np.concatenate([values, np.zeros(len(right) - len(values))])  # fewer pixels than modes
    rank = int((values > RANK * values[0]).sum())
    left, rows = left[:, :rank], right[:rank]
    seen = left.T @ factors.image
    unexplained = np.hypot(factors.rest, np.linalg.norm(factors.image - left @ seen))
    sigma = _noise(float(unexplained), factors.pixels - rank) if noise is None else float(noise)
    ambient = max(factors.brightness, sigma) / (np.linalg.norm(factors.triangle[:, 0]) / np.sqrt(factors.pixels))
    relative = sigma / ambient if ambient else 0.0

    gain = 1 / values[:rank]
    alias = np.linalg.norm(left.T @ factors.beyond, axis=1) * gain
    loud, masked = relative * gain > CUT, alias > CUT
    kept = ~(loud | masked)
    if ridge == 0:
        inverse = _smoothest(factors.order, np.concatenate([rows[~kept], right[rank:]])) @ (
            (rows[kept].T * gain[kept]) @ left[:, kept].T
        )
    else:
        inverse = _ridged(factors, relative, ridge)
    coefficients = inverse @ factors.image
    std = sigma * np.linalg.norm(inverse, axis=1)
    unseen = inverse @ factors.triangle - np.eye(len(right))
    other = np.hypot(np.linalg.norm(inverse @ factors.beyond, axis=1), np.linalg.norm(unseen, axis=1))
    error = np.hypot(relative * np.linalg.norm(inverse, axis=1), other)
    misfit = np.hypot(np.linalg.norm(factors.triangle @ coefficients - factors.image), factors.rest)
    return Solution(
        coefficients,
        std,
        other * ambient,
        error <= TRUSTED,
        values**2,
        float((values[0] / values[-1]) ** 2) if rank == len(values) else np.inf,
        float(misfit / np.sqrt(factors.pixels)),
        sigma,
        rows[kept],
        np.concatenate([right[rank:], rows[masked]]),
        rows[loud & ~masked],
    )


def _noise(unexplained: float, freedom: int) -> float:
    """Return a pixel's standard deviation from what no light explains."""
    if freedom < 1:
        raise HarmonicFaceError(
            "noise: expected a number, for no more pixels are left than modes to estimate it from; got None"
        )
    return unexplained / float(np.sqrt(freedom))


def _smoothest(order: int, free: Array) -> Array:
    """Return the matrix that adds free directions (rows) to a light until its decay-weighted energy is least."""
    weight = _decay(order)
    steps = np.linalg.pinv(weight[:, None] * free.T)  # the ambient light has no weight: pinv moves it least
    return np.asarray(np.eye(len(weight)) - free.T @ steps @ np.diag(weight))


def _decay(order: int) -> Array:
    """Return A_0 / A_l of each mode that is shown; 0 for the ambient light itself, which nothing holds back."""
    weight = np.pi / lambertian_weights(order)[shown(order)]
    weight[0] = 0.0
    return np.abs(weight)


def _ridged(factors: Factors, relative: float, ridge: float | None) -> Array:
    """Return the matrix from reduced image to coefficients that the decay of the filter holds back."""
    strength = relative if ridge is None else np.sqrt(ridge) * np.linalg.norm(factors.triangle[:, 0])
    stacked = np.concatenate([factors.triangle, strength * np.diag(_decay(factors.order))])
    return np.asarray(np.linalg.pinv(stacked, rcond=RANK**2)[:, : len(factors.triangle)])
