"""Colour: the albedo of each colour, once normals and lights are known from the grey photographs."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.appearance.irradiance import surface_irradiance
from harmonicface.lighting.light import HarmonicLight
from harmonicface.stereo.in_blocks import spread
from harmonicface.stereo.result import StereoResult
from harmonicface.surfaces.surface import Surface

LEAST, MOST = 0.5, 1.5  # of what the matte model predicts: below is shadow, above a highlight


def with_colours(result: StereoResult, photographs: Iterable[Floats], brightness: Floats | None = None) -> StereoResult:
    """Return a result whose albedo has colour, from the colours of the photographs.

    Parameters
    ----------
    result
        With grey albedo.
    photographs
        n of (p, 3) linear intensities of the masked pixels, one after the other; infinite where they are saturated.
    brightness
        (n, 3) of distant lamps in each colour; by default light is white, as bright as the result says.

    Returns
    -------
    StereoResult
    """
    surface = result.surface
    albedo = surface.grey_albedo
    kept = [index for index in range(len(result.lights)) if index not in result.left_out]
    strengths = (
        np.linalg.norm(result.lights[:, :3], axis=1) if result.lights.shape[1] == 3 else np.ones(len(result.lights))
    )
    shading = (shading_of(surface, result.lights[index] / strengths[index]) for index in kept)
    colours = np.repeat(strengths[:, None], 3, axis=1) if brightness is None else brightness
    white = (pixels / colours[index] for index, pixels in enumerate(photographs) if index not in result.left_out)
    found = spread(colour_albedo(white, shading, albedo), surface.mask)
    coloured = Surface(surface.normals, found, surface.mask, surface.depth, surface.pixel_size)
    return replace(result, surface=coloured)


def shading_of(surface: Surface, light: Floats) -> Floats:
    """Return what an albedo of 1 shows at the masked pixels, (p,), under a light as results have it.

    Parameters
    ----------
    surface
        Whose normals are lit.
    light
        (3,) direction times brightness, or (4,) or (9,) harmonic coefficients.
    """
    if len(light) == 3:
        return np.asarray(np.maximum(surface.pixel_normals @ light.astype(surface.normals.dtype), 0))
    return surface_irradiance(surface, HarmonicLight(light), {4: 1, 9: 2}[len(light)])


def colour_albedo(photographs: Iterable[Floats], shading: Iterable[Floats], albedo: Floats) -> NDArray[np.float32]:
    r"""Return the albedo of each colour: the grey albedo times the colours' share in what the photographs show.

    .. math:: \rho_c = \rho \sum_i I_{ic} \Big/ \sum_i \tfrac{1}{3} \sum_c I_{ic}

    White light shows a matte surface in its own colour wherever it is lit, whatever the shading. The sums are over
    photographs whose grey (the mean of the colours) lies between half and one and a half of what the grey albedo
    predicts, :math:`\rho s_i`: neither shadow nor highlight. Where there is none they are over all that are not
    saturated, and a pixel that is saturated or black in all of them is grey.

    Parameters
    ----------
    photographs
        n of (p, 3) linear intensities, one after the other, each divided by the colour of its light; infinite where
        they are saturated.
    shading
        n of (p,) irradiances: what an albedo of 1 would show.
    albedo
        (p,) grey albedo.

    Returns
    -------
    array
        (p, 3) float32, at least 0, whose mean is the grey albedo.

    Examples
    --------
    >>> shown = np.array([[0.2, 0.4, 0.6]])
    >>> colour_albedo([shown, 0.5 * shown], [np.array([1.0]), np.array([0.5])], np.array([0.4])).round(3)
    array([[0.2, 0.4, 0.6]], dtype=float32)
    """
    matte, anyhow = np.zeros((2, len(albedo), 3), np.float32)
    grey_albedo = albedo.astype(np.float32)
    for photograph, shade in zip(photographs, shading, strict=True):
        shown = photograph.astype(np.float32)
        shown[~np.isfinite(shown).all(axis=1)] = 0
        predicted, grey = grey_albedo * np.maximum(shade, 0).astype(np.float32), shown.mean(axis=1)
        anyhow += shown
        shown[(grey < LEAST * predicted) | (grey > MOST * predicted)] = 0
        matte += shown
    seen = np.where((matte.sum(axis=1) > 0)[:, None], matte, anyhow)
    grey = seen.mean(axis=1, keepdims=True)
    share = np.divide(seen, grey, out=np.ones_like(seen), where=grey > 0)
    return np.asarray(grey_albedo[:, None] * share)
