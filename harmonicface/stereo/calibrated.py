"""Photometric stereo with known lights: photographs under three or more distant lights -> normals and albedo."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.least_squares import scaled_normals
from harmonicface.surfaces.surface import Surface

T = TypeVar("T", bound=np.generic)
Mask = NDArray[np.bool_]

# Lights that multiply the noise of an image by more than this tell nothing of a normal: one grey level of eight bits
# would come out as an eighth of white.
HIGHEST_NOISE_GAIN = 30.0
ROUNDS = 50  # the lit images of most pixels are found in two or three; the sum falls each time, so the search ends
CHUNK = 1 << 18  # observations at a time: in float64 they stay in the processor's cache


@dataclass(frozen=True, eq=False)
class CalibratedStereo:
    """What photometric stereo with known lights found, and how far it can be trusted.

    Parameters
    ----------
    surface
        Normals and albedo, float32. The albedo is that of `image = albedo * max(normal . light, 0)`.
    residual
        (h, w) float32, root mean square of image minus model over the images that were used; 0 outside the mask.
    used
        (h, w) int32, how many images each pixel was solved from; 0 outside the mask.
    determined
        (h, w) booleans, true where the images in which a pixel is lit determine its normal. Elsewhere in the mask
        shadowed or saturated images were used too: the normal is a guess that at least shades like the images.
    """

    surface: Surface
    residual: NDArray[np.float32]
    used: NDArray[np.int32]
    determined: Mask


def calibrated_stereo(
    images: ArrayLike,
    lights: ArrayLike,
    mask: ArrayLike | None = None,
    *,
    saturation: float = 1.0,
) -> CalibratedStereo:
    """Find normals and albedo from images under known distant lights, each pixel from the images in which it is lit.

    A matte surface shows `I_i = b . l_i` where it is lit, `b = albedo * normal` (Woodham 1980), and next to nothing
    in a shadow. Each observation is taken for what explains it better, so that pixel by pixel

        sum_i min((I_i - max(b . l_i, 0))**2, I_i**2)

    becomes a minimum: starting from all images, least squares gives b, then those images are lit whose light stands
    before the surface, `b . l_i > 0`, and that show more than half of what b predicts. The two steps alternate
    until no image changes sides; none of them makes the sum larger. It needs no threshold, and a shadow may be
    attached or cast, as long as less than half of a pixel's light reaches it. Saturated observations are left out
    before. Highlights are not: this is the matte model.

    Where too few images are lit to determine the normal (fewer than three, or their lights near one plane), no hole is
    left: the pixel keeps the last estimate that was determined, from all its images at the worst, and is reported
    in `determined`. A pixel that is black in all images has albedo 0 and faces the camera. Nothing forces normals to
    face the camera.

    Parameters
    ----------
    images
        (n, h, w) linear grey intensities, n of at least 3. Slightly negative ones (camera noise) are fine.
    lights
        (n, 3) directions from the surface *to* each light (x right, y up, z toward the camera), times the light's
        brightness: unit vectors when all lights are equally bright.
    mask
        (h, w) booleans, the pixels to solve; all by default. Only there must the images be finite.
    saturation
        The top of the images' range: 1 for photographs read as 0 to 1, infinity for images without a ceiling.

    Returns
    -------
    CalibratedStereo
        The Surface, and the residual, count of images and trust of each pixel.

    Raises
    ------
    HarmonicFaceError
        Shapes that do not fit, fewer than three images, lights in a plane, NaN, an intensity above `saturation`,
        a parameter out of range, an empty mask.

    Examples
    --------
    >>> import numpy as np
    >>> lights = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, 0.6, 0.8], [-0.6, -0.0, 0.8]])
    >>> normal, albedo = np.array([0.48, 0.6, 0.64]), 0.5
    >>> images = np.maximum(albedo * lights @ normal, 0).reshape(4, 1, 1)
    >>> found = calibrated_stereo(images, lights)
    >>> found.surface.normals[0, 0].round(4), found.surface.albedo[0, 0].round(4)
    (array([0.48, 0.6 , 0.64], dtype=float32), np.float32(0.5))
    """
    stack = _checked_images(images)
    directions = _checked_lights(lights, len(stack))
    if isinstance(saturation, bool) or not saturation > 0:
        raise HarmonicFaceError(f"saturation: expected a number above 0, got {saturation}")
    height, width = stack.shape[1:]
    inside = _validate.mask(np.ones((height, width), bool) if mask is None else mask, "mask", (height, width))
    pixels = stack.reshape(len(stack), -1) if inside.all() else stack[:, inside]
    if not np.isfinite(pixels).all():
        raise HarmonicFaceError("images: expected finite intensities in the mask, got NaN or infinity")
    if (highest := pixels.max()) > saturation * (1 + 1e-6):  # of rounding in float32
        raise HarmonicFaceError(
            f"images: expected intensities up to saturation={saturation:g}, got {highest:.4g}"
            " (saturation=inf for images without a ceiling)"
        )
    step = max(CHUNK // len(pixels), 1)
    parts = [
        _solve(pixels[:, start : start + step].astype(np.float64), directions, saturation)
        for start in range(0, pixels.shape[1], step)
    ]
    scaled, residual, used, determined = (np.concatenate(part) for part in zip(*parts, strict=True))
    albedo = np.linalg.norm(scaled, axis=1)
    black = albedo == 0
    normals = np.where(black[:, None], [0.0, 0.0, 1.0], scaled / np.where(black, 1.0, albedo)[:, None])
    surface = Surface(_spread(normals.astype(np.float32), inside), _spread(albedo.astype(np.float32), inside), inside)
    return CalibratedStereo(
        surface,
        _spread(residual.astype(np.float32), inside),
        _spread(used.astype(np.int32), inside),
        _spread(determined, inside),
    )


def _solve(observations: Floats, lights: Floats, saturation: float) -> tuple[NDArray[Any], ...]:
    """Solve (n, p) observations below saturation: albedo times normal (p, 3), residual, count and trust (p,)."""
    return lit_least_squares(observations, lights, observations < saturation)


def lit_least_squares(observations: Floats, lights: Floats, trusted: Mask) -> tuple[NDArray[Any], ...]:
    """Solve each pixel by least squares over the trusted observations in which it is lit (see `calibrated_stereo`).

    Parameters
    ----------
    observations
        (n, p) float64 intensities.
    lights
        (n, 3) directions times brightness.
    trusted
        (n, p) booleans, the observations that may be used.

    Returns
    -------
    tuple of arrays
        Albedo times normal (p, 3), residual (p,), count of images (p,), and whether the lit ones determine it (p,).
    """
    scaled, gain = scaled_normals(observations, lights, trusted)
    used, enough = trusted.copy(), gain <= HIGHEST_NOISE_GAIN
    if not enough.all():
        used[:, ~enough] = True
        scaled[~enough] = scaled_normals(observations[:, ~enough], lights)[0]
    determined = _leave_shadows_out(observations, lights, trusted, enough, scaled, used)
    count = used.sum(axis=0)
    error = observations - lights @ scaled.T
    error *= used
    return scaled, np.sqrt(np.einsum("np,np->p", error, error) / count), count, determined


def _leave_shadows_out(
    observations: Floats, lights: Floats, trusted: Mask, start: Mask, scaled: Floats, used: Mask
) -> Mask:
    """Alternate between b and the set of lit images in the pixels of `start`, in place; return which ones settled."""
    settled = np.zeros_like(start)
    (pixels, seen, allowed, before) = _keep(start, np.arange(len(start)), observations, trusted, used)
    for _ in range(ROUNDS):
        predicted = lights @ scaled[pixels].T
        lit = 2 * seen > predicted
        lit &= predicted > 0
        lit &= allowed
        changed = (lit != before).any(axis=0)
        settled[pixels[~changed]] = True
        pixels, seen, allowed, lit = _keep(changed, pixels, seen, allowed, lit)
        if not pixels.size:
            break
        again, gain = scaled_normals(seen, lights, lit)
        enough = gain <= HIGHEST_NOISE_GAIN
        pixels, seen, allowed, before = _keep(enough, pixels, seen, allowed, lit)
        scaled[pixels], used[:, pixels] = again[enough], before
    return settled


def _keep(chosen: Mask, *arrays: NDArray[Any]) -> tuple[NDArray[Any], ...]:
    """Narrow arrays to the chosen pixels, their last axis; without a copy when that is all of them."""
    return arrays if chosen.all() else tuple(np.compress(chosen, array, axis=-1) for array in arrays)


def _spread(values: NDArray[T], inside: Mask) -> NDArray[T]:
    """Put the values of masked pixels back on the grid, zeros elsewhere."""
    grid = np.zeros(inside.shape + values.shape[1:], values.dtype)
    grid[inside] = values
    return grid


def _checked_images(images: ArrayLike) -> Floats:
    stack = _validate.floats(images, "images")
    if stack.ndim != 3 or stack.size == 0:
        raise HarmonicFaceError(f"images: expected an array of shape (n, h, w), got {_validate.describe(stack)}")
    if len(stack) < 3:
        raise HarmonicFaceError(f"images: expected at least 3 under different lights, got {len(stack)}")
    return stack


def _checked_lights(lights: ArrayLike, count: int) -> Floats:
    vectors = _validate.vectors(lights, "lights").astype(np.float64)
    if vectors.shape != (count, 3):
        raise HarmonicFaceError(f"lights: expected one vector an image, shape ({count}, 3), got {vectors.shape}")
    if not vectors.any(axis=1).all():
        raise HarmonicFaceError("lights: expected directions, got a vector of zero length")
    gain = float(scaled_normals(np.zeros((count, 1)), vectors)[1][0])
    if gain > HIGHEST_NOISE_GAIN:
        raise HarmonicFaceError(
            f"lights: expected directions that span space, got {count} near one plane"
            f" (they multiply noise by {gain:.3g}, at most {HIGHEST_NOISE_GAIN:g} is of use)"
        )
    return vectors
