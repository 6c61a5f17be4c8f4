"""Texture and light of one photograph, told apart: what varies slowly with the normal is light, the rest is texture."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.appearance.inverse import LightEstimate, estimate_light
from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces.surface import Surface

ROUNDS = 20
DARKEST = 0.05  # of the largest irradiance: where the light is fainter, intensity over irradiance says nothing
SETTLED = 1e-6

AMBIGUITY = (
    "Texture and light are told up to a common factor q(n) > 0: irradiance times q and texture divided by q give the"
    " same photograph. A constant q is the scale, fixed here by the mean albedo. Any other q is taken for light as far"
    " as it leaves the irradiance a combination of the low harmonics of the normal, so a texture that follows the"
    " normal, as a dark chin does, counts as light."
)


@dataclass(frozen=True, eq=False)
class TextureSeparation:
    """A photograph as texture times irradiance.

    Parameters
    ----------
    texture
        (h, w) or (h, w, 3) albedo; 0 where `told` is false.
    shading
        The irradiance, of the same shape; 0 outside the mask.
    told
        (h, w) booleans: pixels of the mask that are light enough for a ratio.
    estimate
        The light, as for a Surface of even albedo.
    ambiguity
        What one photograph cannot tell, in words.
    """

    texture: Floats
    shading: Floats
    told: NDArray[np.bool_]
    estimate: LightEstimate
    ambiguity: str = AMBIGUITY


def separate_texture(
    photo: ArrayLike,
    surface: Surface,
    order: int = 2,
    *,
    mask: ArrayLike | None = None,
    mean_albedo: float = 1.0,
    spread: float = 0.2,
) -> TextureSeparation:
    r"""Split a photograph of known shape and unknown albedo into texture and light.

    .. math:: I(x) = \rho(x) E(n(x)), \quad E = \sum_{l \le order} A_l L_{lm} Y_{lm}

    Light cannot make fast changes on a matte surface, so these are texture (Ramamoorthi & Hanrahan, On the
    relationship between radiance and irradiance, 2001, section 7). The light is fitted to the photograph as if the
    albedo were even, each pixel weighted by 1 / E, for texture multiplies, and less the more its albedo departs from
    the mean (a smooth Huber loss), so that brows and lips do not count as shadows. `TextureSeparation.ambiguity` says
    what remains unknown in principle.

    Parameters
    ----------
    photo
        (h, w) or (h, w, 3) linear intensities of at least 0 in the mask; of colour each channel is split by itself.
    surface
        Its normals; its albedo is not read.
    order
        The highest degree of the light.
    mask
        (h, w) booleans, the pixels to use; all of the Surface by default.
    mean_albedo
        What the mean of the texture is set to: one photograph does not tell the scale.
    spread
        How much the albedo varies, as a fraction of its mean; departures beyond it lose weight.

    Returns
    -------
    TextureSeparation
        Texture, shading, light.

    Raises
    ------
    HarmonicFaceError
        What `estimate_light` refuses; a photo that is negative or dark everywhere; settings that are not above 0.

    Examples
    --------
    >>> import harmonicface as hf
    >>> person = hf.synthetic_person(0, 32)
    >>> even = hf.Surface(person.normals, person.mask * 0.5, person.mask)
    >>> split = separate_texture(hf.render(even, hf.lights.ambient(0.8)), person, mean_albedo=0.5)
    >>> float(split.texture[split.told].std().round(3)), float(split.shading[split.told].mean().round(3))
    (0.0, 0.8)
    """
    scale, width = _validate.positive(mean_albedo, "mean_albedo"), _validate.positive(spread, "spread")
    image = _validate.floats(photo, "photo")
    if image.shape not in (surface.shape, (*surface.shape, 3)):
        expected = f"shape {surface.shape} or {(*surface.shape, 3)}, as the surface"
        raise HarmonicFaceError(f"photo: expected {expected}, got {_validate.describe(image)}")
    inside = surface.mask if mask is None else surface.mask & _validate.mask(mask, "mask", surface.shape)
    if not inside.any():
        raise HarmonicFaceError("mask: expected pixels of the surface, got none of them")
    pixels = _validate.finite(image[inside], "photo").astype(np.float64)
    if pixels.min() < 0 or not pixels.reshape(len(pixels), -1).any(axis=0).all():
        expected = "intensities of at least 0 and some light in each channel"
        raise HarmonicFaceError(f"photo: expected {expected}, got values from {pixels.min():.4g} to {pixels.max():.4g}")
    weights = np.ones_like(pixels)
    shading = np.zeros_like(pixels)
    for _ in range(ROUNDS):
        estimate = _weighted(pixels, weights, surface, inside, order)
        before, shading = shading, np.asarray(estimate.light.irradiance(_double(surface, inside)))
        light = np.maximum(shading, DARKEST * shading.max(axis=0))
        if np.abs(shading - before).max() <= SETTLED * np.abs(shading).max():
            break
        departure = (pixels / light - 1) / width
        weights = 1 / (light * (1 + departure**2) ** 0.25)
    bright = (shading > DARKEST * shading.max(axis=0)).reshape(len(pixels), -1).all(axis=1)
    texture = np.where(bright.reshape(-1, *[1] * (pixels.ndim - 1)), pixels / light, 0.0)
    factor = scale / texture[bright].mean(axis=0)
    told = np.zeros(surface.shape, bool)
    told[inside] = bright
    return TextureSeparation(
        _picture(texture * factor, inside), _picture(shading / factor, inside), told, _scaled(estimate, 1 / factor)
    )


def _weighted(
    pixels: Floats, weights: Floats, surface: Surface, inside: NDArray[np.bool_], order: int
) -> LightEstimate:
    """Estimate the light by weighted least squares: weights are the albedo of a Surface seen in the weighted photo."""
    weights = weights / weights.mean()
    weighted = Surface(surface.normals, _picture(weights, inside), inside)
    return estimate_light(_picture(pixels * weights, inside), weighted, order)


def _double(surface: Surface, inside: NDArray[np.bool_]) -> Floats:
    """Return the normals inside in double precision, unit length."""
    normals = surface.normals[inside].astype(np.float64)
    return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))


def _picture(values: Floats, inside: NDArray[np.bool_]) -> Floats:
    """Return pixels as an image, 0 outside."""
    image = np.zeros((*inside.shape, *values.shape[1:]), values.dtype)
    image[inside] = values
    return image


def _scaled(estimate: LightEstimate, factor: Floats) -> LightEstimate:
    """Return the estimate of a light that is stronger by a factor."""
    names = ("coefficients", "std", "systematic", "residual", "noise")
    return replace(estimate, **{name: getattr(estimate, name) * factor for name in names})
