"""The linear algebra of inverse lighting: pixels -> a small triangular system -> coefficients and their errors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface.appearance.choose_modes import undetermined
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.reflectance.filters import lambertian_filter, lambertian_weights
from harmonicface.surfaces.surface import Surface

Array = NDArray[np.float64]

BEYOND = 6  # degrees above the order whose light may pass for light of the order: the filter lets next to none above
LIKELY = 0.3  # strength of a mode above the order, over the ambient one: natural light's, and a third of a lamp's
RANK = 1e-6  # of the largest singular value of the images; below, float32 normals differ by rounding alone
CUT = 2.0  # of the ambient light: a direction with a larger error is filled by smoothness, not by the photograph
TRUSTED = 0.5  # of the ambient light: coefficients and directions with a smaller error are recoverable
BRIGHTEST = 1e30  # squares of brighter pixels, summed, leave the range of numbers
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

    triangle: Array  # R, (r, n): the k modes of the order first, then those of the degrees above it
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
    dropped: Array


def shown(order: int) -> NDArray[np.intp]:
    """Return where the modes with A_l other than 0 are stored: degrees 0, 1, 2, 4, 6 ..."""
    return np.flatnonzero(lambertian_weights(order))


def above_zero(value: float, name: str) -> None:
    """Refuse what is no number above 0; infinity is one."""
    number = isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)
    if not (number and value > 0):
        got = value if number else _validate.describe(value)
        raise HarmonicFaceError(f"{name}: expected a number above 0, got {got}")


def photographed(
    photo: ArrayLike, surface: Surface, mask: ArrayLike | None, saturation: float, brightest: float = BRIGHTEST
) -> Pixels:
    """Return the pixels that count: in both masks, below saturation in every channel, and none beyond the brightest."""
    array = _validate.floats(photo, "photo")
    if array.shape not in (surface.shape, (*surface.shape, 3)):
        expected = f"shape {surface.shape} or {(*surface.shape, 3)}, as the surface"
        raise HarmonicFaceError(f"photo: expected {expected}, got {_validate.describe(array)}")
    above_zero(saturation, "saturation")
    inside = surface.mask if mask is None else surface.mask & _validate.mask(mask, "mask", surface.shape)
    intensities = _validate.finite(array[inside], "photo").astype(np.float64)
    intensities = intensities.reshape(len(intensities), 3 if array.ndim == 3 else 1)
    usable = np.asarray((intensities < saturation).all(axis=1))
    if not usable.any():
        raise HarmonicFaceError(
            f"photo: expected pixels in the masks below saturation={saturation:g}, got none of {len(usable)}"
        )
    intensities = intensities[usable]
    least, most = float(intensities.min()), float(intensities.max())
    if most <= 0 and least < 0:  # noise around black is no fault
        raise HarmonicFaceError(f"photo: expected some light, got values from {least:.4g} to {most:.4g}")
    if max(-least, most) > brightest:
        expected = f"intensities of at most {brightest:g}"
        raise HarmonicFaceError(f"photo: expected {expected}, got values from {least:.4g} to {most:.4g}")
    coloured = intensities.shape[1] == 3 and surface.albedo.ndim == 3
    albedo = surface.pixel_albedo.T if coloured else surface.grey_albedo[None]
    chosen = inside[surface.mask]
    albedos = [each[chosen][usable].astype(np.float64) for each in albedo]
    if not all(each.any() for each in albedos):
        raise HarmonicFaceError("surface: expected some albedo above 0 among the pixels used, got 0 everywhere")
    normals = surface.pixel_normals[chosen][usable].astype(np.float64)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Pixels(normals, intensities, albedos)


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
    n = len(columns)
    return [
        Factors(
            triangle[:n, :n],
            triangle[:n, n + channel],
            float(np.linalg.norm(triangle[n:, n + channel])),
            float(np.linalg.norm(intensities[:, channel]) / np.sqrt(len(normals))),
            len(normals),
            order,
        )
        for channel in range(intensities.shape[1])
    ]


def solved(factors: Factors, noise: float | None, ridge: float | None, dropping: bool = False) -> Solution:
    """Solve the reduced system, if asked without modes that noise decides, and tell each coefficient's error."""
    k = len(shown(factors.order))
    values = np.asarray(np.linalg.svd(factors.triangle[:, :k], compute_uv=False), np.float64)
    values = np.concatenate([values, np.zeros(k - len(values))])  # fewer pixels than modes
    rank = int((values > RANK * values[0]).sum())
    sigma, freedom = _noise(factors, k) if noise is None else (float(noise), np.inf)
    first = float(np.linalg.norm(factors.triangle[:, 0]))  # of the ambient light's image
    ambient = max(factors.brightness, sigma) / (first / np.sqrt(factors.pixels))
    relative = sigma / ambient if ambient else 0.0
    tail = _tail(factors.order + BEYOND) * first  # over few modes, so that pixels do not average it out
    modes = 2 * (factors.order + BEYOND) + 5
    doubt = float(np.hypot(relative, LIKELY * tail * np.sqrt(modes / factors.pixels)))  # a pixel's own

    decay = _decay(factors.order)
    plain = _inverse(factors.triangle, np.zeros(k), doubt)
    noisy, error = _errors(factors.triangle, plain, relative, tail)
    squares, directions = np.linalg.eigh(error)
    blind = np.asarray(np.linalg.norm(factors.triangle[:, :k] @ directions, axis=0) <= RANK * values[0])
    lost = squares > TRUSTED**2
    drowned = lost & (np.einsum("aj,ab,bj->j", directions, noisy, directions) > squares / 2)
    held = decay * (relative if ridge is None else np.sqrt(ridge) * first)
    inverse = _inverse(factors.triangle, held, doubt) if held.any() else plain
    cut = directions[:, blind | (squares > CUT**2) if ridge == 0 else blind]  # a ridge too weak for rounding is none
    inverse = _smoothest(decay, cut.T) @ (inverse - cut @ (cut.T @ inverse))
    dropped = undetermined(factors.triangle[:, :k], plain, factors.image, sigma, freedom) if dropping else cut[:, :0]
    inverse = inverse - dropped @ (dropped.T @ inverse)
    coefficients = inverse @ factors.image
    noisy, error = _errors(factors.triangle, inverse, relative, tail)
    misfit = np.hypot(np.linalg.norm(factors.triangle[:, :k] @ coefficients - factors.image), factors.rest)
    return Solution(
        coefficients,
        sigma * np.linalg.norm(inverse, axis=1),
        ambient * np.sqrt(np.maximum(np.diag(error - noisy), 0)),
        np.diag(error) <= TRUSTED**2,
        values**2,
        float((values[0] / values[-1]) ** 2) if rank == k else np.inf,
        float(misfit / np.sqrt(factors.pixels)),
        sigma,
        directions[:, ~lost].T,
        directions[:, lost & ~drowned].T[::-1],
        directions[:, drowned].T[::-1],
        dropped.T,
    )


def _inverse(triangle: Array, held: Array, doubt: float) -> Array:
    """Return the matrix from z to the k coefficients; light above the order is fitted too, as far as it is likely."""
    above = np.full(triangle.shape[1] - len(held), doubt / LIKELY)
    stacked = np.concatenate([triangle, np.diag(np.concatenate([held, above]))])
    left, right = np.linalg.qr(stacked)
    size = np.abs(np.diag(right))
    if size.min() > RANK * size.max():
        return np.asarray(np.linalg.solve(right, left[: len(triangle)].T)[: len(held)])
    return np.asarray(np.linalg.pinv(stacked, rcond=RANK)[: len(held), : len(triangle)])


def _errors(triangle: Array, inverse: Array, relative: float, tail: float) -> tuple[Array, Array]:
    """Return the covariance (k, k) of the noise's errors, and of all, for all modes as strong as the ambient one."""
    spread = inverse @ inverse.T
    noisy = relative**2 * spread
    unseen = inverse @ triangle - np.eye(len(inverse), triangle.shape[1])
    return noisy, noisy + tail**2 * spread + unseen @ unseen.T


def _tail(order: int) -> float:
    """Return how bright each mode above an order is under a lamp, over the ambient light's image."""
    below = ((2 * np.arange(order + 1) + 1) * (lambertian_filter(order) / np.pi) ** 2).sum()
    modes = 2 * order + 5  # as if all of it were in the next degree but one
    return float(np.sqrt(max(8 / 3 - below, 0.0) / modes))  # 8/3: all that a lamp's clamped cosine has


def _smoothest(decay: Array, free: Array) -> Array:
    """Return the matrix that adds free directions (rows) to a light until its decay-weighted energy is least."""
    steps = np.linalg.pinv(decay[:, None] * free.T)  # the ambient light has no weight: pinv moves it least
    return np.asarray(np.eye(len(decay)) - free.T @ steps @ np.diag(decay))


def _decay(order: int) -> Array:
    """Return the root of A_0 / A_l of each mode that is shown; 0 for the ambient light, which nothing holds back."""
    weight = np.sqrt(np.abs(np.pi / lambertian_weights(order)[shown(order)]))
    weight[0] = 0.0
    return weight


def _noise(factors: Factors, k: int) -> tuple[float, float]:
    """Return a pixel's standard deviation, and of how many degrees of freedom it is.

    It is that of what no light up to the degrees above the order explains; of few pixels, no light of the order.
    """
    for modes in (factors.triangle.shape[1], k):
        left, values, _ = np.linalg.svd(factors.triangle[:, :modes], full_matrices=False)
        left = left[:, values > RANK * values[0]]
        freedom = factors.pixels - left.shape[1]
        if freedom >= 1:
            unexplained = factors.image - left @ (left.T @ factors.image)
            return float(np.hypot(factors.rest, np.linalg.norm(unexplained)) / np.sqrt(freedom)), freedom
    raise HarmonicFaceError(
        "noise: expected a number, for no more pixels are left than modes to estimate it from; got None"
    )
