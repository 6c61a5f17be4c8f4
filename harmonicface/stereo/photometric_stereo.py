"""Photometric stereo: photographs under different lights, known or not -> a Surface, its lights, how sure both are."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.as_light import LightLike
from harmonicface.stereo.checks import (
    UNKNOWNS,
    checked_directions,
    checked_images,
    checked_intensities,
    checked_mask,
    checked_saturation,
    require_among,
    require_enough,
    require_unburnt,
)
from harmonicface.stereo.colour import balance, effective, with_colours
from harmonicface.stereo.depth.discontinuity import integrate_bilaterally
from harmonicface.stereo.depth.integration import integrate_normals
from harmonicface.stereo.depth.perspective_integration import integrate_perspective
from harmonicface.stereo.factors import leading_factors
from harmonicface.stereo.in_blocks import Pixels, Stack, spread
from harmonicface.stereo.known.given_lights import under_general_light, under_lamps
from harmonicface.stereo.result import Model, StereoResult
from harmonicface.stereo.unknown_lights import find_lights
from harmonicface.surfaces.surface import Surface

Integration = Literal["poisson", "weighted", "bilateral", "none"]
Method = Literal["robust", "matte", "least_squares"]
Progress = Callable[[str, int, int], None]

Mask = NDArray[np.bool_]
LEAST_TRUST = 60.0  # degrees: the standard error at which a normal says nothing


def photometric_stereo(
    images: ArrayLike,
    lights: ArrayLike | Sequence[LightLike] | None = None,
    mask: ArrayLike | None = None,
    *,
    model: Model | Literal["auto"] = "auto",
    method: Method = "robust",
    face: bool = False,
    intensities: ArrayLike | Literal["unknown"] | None = None,
    saturation: float = 1.0,
    integration: Integration = "poisson",
    pixel_size: float = 1.0,
    intrinsics: ArrayLike | None = None,
    distance: float = 1.0,
    tell: Progress = lambda *_: None,
) -> StereoResult:
    """Find the Surface in photographs of one thing that holds still before a still camera under changing light.

    Parameters
    ----------
    images
        (n, h, w) or (n, h, w, 3) linear intensities. An array mapped from a file is read in blocks of rows.
    lights
        (n, 3) unit directions to distant lamps, x right, y up, z toward the camera; or any light: (n, 4) or (n, 9)
        harmonic coefficients, or a list of what `as_light` takes, such as `EnvironmentMap`; None: unknown.
    mask
        (h, w) booleans, the pixels to solve; all by default. Elsewhere the images may hold anything.
    model
        "linear3", "ambient4" or "harmonic9" (see `StereoResult`); "auto" chooses for unknown lights. Directions are
        "linear3".
    method
        For known lamps: "robust" explains highlights and leaves shadows out (`robust_normals`), "matte" leaves shadows
        out (`calibrated_stereo`), "least_squares" trusts everything that is not saturated (Woodham 1980).
    face
        True if the images show a face from the front: its symmetry and a mean face resolve what is ambiguous.
    intensities
        (n,) or (n, 3) brightness of each lamp, in each colour; 1 by default, "unknown" to find it. With unknown
        directions they are divided out.
    saturation
        The top of the images' range: from there on an observation is left out. Infinity for none.
    integration
        "poisson", "weighted" (by the normals' standard errors), "bilateral" (keeps depth discontinuities) or "none".
    pixel_size
        World units a pixel, of parallel rays.
    intrinsics
        (fx, fy, cx, cy) in pixels of a pinhole camera, see `integrate_perspective`; parallel rays by default.
    distance
        World units from the pinhole to the thing, which make its size known.
    tell
        Called with what is being done, how much of it, of how much.

    Returns
    -------
    StereoResult

    Raises
    ------
    HarmonicFaceError
        Images of unlike sizes, fewer than the model's unknowns, lights of another number, directions that are not of
        unit length, an empty mask, NaN in the mask, images mostly burnt out, an option that is none.

    Examples
    --------
    >>> lights = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, 0.6, 0.8], [-0.6, 0.0, 0.8]])
    >>> wall = np.tile(0.5 * lights @ [0.0, 0.0, 1.0], (4, 5, 1)).T  # (4, 5, 4)
    >>> found = photometric_stereo(wall, lights)
    >>> found.surface.albedo[0, 0].round(4), found.ambiguity.name
    (np.float32(0.5), 'none')
    """
    require_among(integration, get_args(Integration), "integration")
    require_among(method, get_args(Method), "method")
    require_among(model, ("auto", *UNKNOWNS), "model")
    array = checked_images(images)
    inside = checked_mask(mask, (array.shape[1], array.shape[2]))
    semi = isinstance(intensities, str)
    if semi and intensities != "unknown":
        raise HarmonicFaceError(f"intensities: expected numbers or 'unknown', got {intensities!r}")
    brightness = None if semi or intensities is None else checked_intensities(intensities, len(array))
    stack = Stack(array, inside, balance(brightness), checked_saturation(saturation))
    require_unburnt(stack)
    if lights is None:
        require_enough(len(array), "linear3" if model == "auto" else model)
        grey = None if brightness is None else effective(brightness)
        found = find_lights(stack, model, method, face, grey, tell)
    elif _are_directions(lights):
        require_among(model, ("auto", "linear3"), "model of lamps whose directions are known")
        directions = checked_directions(lights, len(array))
        require_enough(len(array), "linear3")
        if brightness is not None:
            directions = directions * effective(brightness)[:, None]
        found = under_lamps(stack, directions, method, semi, tell)
    else:
        require_enough(len(array), "linear3")
        found = under_general_light(stack, lights, model, tell)
    factors = leading_factors(_told(stack, tell), min(UNKNOWNS[found.model], len(array)))
    surface = _surface(found.pixels, inside, pixel_size, integration, intrinsics, distance, tell)
    result = StereoResult(
        surface=surface,
        lights=found.lights,
        model=found.model,
        model_reason=found.model_reason,
        residual=spread(found.pixels.residual, inside),
        confidence=spread(found.pixels.confidence, inside),
        used=spread(found.pixels.used, inside),
        ambiguity=found.ambiguity,
        left_out=found.left_out,
        singular_values=factors.singular_values,
        rank=factors.above_noise(factors.residual(factors.rank)),
        gap=factors.gap,
        condition=factors.condition,
    )
    if array.ndim == 3:
        return result
    colours = (np.where(image[inside] < stack.saturation, image[inside], np.inf) for image in array)
    return with_colours(result, colours, brightness if brightness is not None and brightness.ndim == 2 else None)


def _are_directions(lights: ArrayLike | Sequence[LightLike]) -> bool:
    """Tell whether lights are numbers that are no harmonic coefficients."""
    try:
        rows = np.asarray(lights, np.float64)
    except (TypeError, ValueError):
        return False
    return not (rows.ndim == 2 and rows.shape[1] in (4, 9))


def _told(stack: Stack, tell: Progress) -> Iterator[Floats]:
    """Yield the blocks of photographs, telling how many pixels have been seen."""
    total, done = stack.pixels, 0
    for block in stack.blocks():
        yield block
        done += block.shape[1]
        tell("singular values", done, total)


def _surface(
    found: Pixels,
    inside: Mask,
    pixel_size: float,
    integration: Integration,
    intrinsics: ArrayLike | None,
    distance: float,
    tell: Progress,
) -> Surface:
    """Return normals and albedo as a Surface, with depth."""
    albedo = np.linalg.norm(found.scaled, axis=1)
    black = albedo == 0
    normals = found.scaled / np.where(black, 1.0, albedo)[:, None].astype(np.float32)
    normals[black] = 0, 0, 1
    grid, shades = spread(normals, inside), spread(albedo, inside)
    if integration == "none":
        return Surface(grid, shades, inside, None, pixel_size)
    tell("depth", 0, 1)
    weights = spread(_trust(found.confidence), inside) if integration == "weighted" else None
    if integration == "bilateral":
        depth = integrate_bilaterally(grid, inside, pixel_size, intrinsics=intrinsics, distance=distance)
    elif intrinsics is not None:
        depth = integrate_perspective(grid, intrinsics, inside, weights, distance=distance)
    else:
        depth = integrate_normals(grid, inside, pixel_size, weights)
    if intrinsics is not None:
        focal = np.sqrt(np.prod(np.asarray(intrinsics, np.float64)[:2]))
        pixel_size = float(-depth[inside].mean() / focal)
    tell("depth", 1, 1)
    return Surface(grid, shades, inside, depth.astype(np.float32), pixel_size)


def _trust(confidence: Floats) -> Floats:
    """Return inverse variances of normals, those that nothing determines as the least that is sensible."""
    return 1 / (1 + np.minimum(confidence, LEAST_TRUST).astype(np.float64) ** 2)
