"""Photometric stereo: photographs under different lights, known or not -> a Surface, its lights, how sure both are."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo import known_lights
from harmonicface.stereo.colour import with_colours
from harmonicface.stereo.discontinuity import integrate_bilaterally
from harmonicface.stereo.factors import leading_factors
from harmonicface.stereo.in_blocks import Images, Pixels, Stack, solved, spread
from harmonicface.stereo.integration import integrate_normals
from harmonicface.stereo.perspective_integration import integrate_perspective
from harmonicface.stereo.result import Ambiguity, Model, StereoResult
from harmonicface.stereo.unknown_lights import Found, find_lights
from harmonicface.surfaces.surface import Surface

Integration = Literal["poisson", "weighted", "bilateral", "none"]
Method = Literal["robust", "matte", "least_squares"]
Progress = Callable[[str, int, int], None]

Mask = NDArray[np.bool_]
UNKNOWNS: dict[str, int] = {"linear3": 3, "ambient4": 4, "harmonic9": 9}
UNIT = 0.02  # of a direction's length: two decimals in a file
LEAST_TRUST = 60.0  # degrees: the standard error at which a normal says nothing


def photometric_stereo(
    images: ArrayLike,
    lights: ArrayLike | None = None,
    mask: ArrayLike | None = None,
    *,
    model: Model | Literal["auto"] = "auto",
    method: Method = "robust",
    face: bool = False,
    intensities: ArrayLike | None = None,
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
        (n, 3) unit directions to distant lamps, x right, y up, z toward the camera; None: unknown.
    mask
        (h, w) booleans, the pixels to solve; all by default. Elsewhere the images may hold anything.
    model
        "linear3", "ambient4" or "harmonic9" (see `StereoResult`); "auto" chooses for unknown lights.
    method
        For known lamps: "robust" explains highlights and leaves shadows out (`robust_normals`), "matte" leaves shadows
        out (`calibrated_stereo`), "least_squares" trusts everything that is not saturated (Woodham 1980).
    face
        True if the images show a face from the front: its symmetry and a mean face resolve what is ambiguous.
    intensities
        (n,) or (n, 3) brightness of each light, in each colour; 1 by default. With unknown directions they are
        divided out.
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
        unit length, an empty mask, NaN in the mask, an option that is none.

    Examples
    --------
    >>> lights = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, 0.6, 0.8], [-0.6, 0.0, 0.8]])
    >>> wall = np.tile(0.5 * lights @ [0.0, 0.0, 1.0], (4, 5, 1)).T  # (4, 5, 4)
    >>> found = photometric_stereo(wall, lights)
    >>> found.surface.albedo[0, 0].round(4), found.ambiguity.name
    (np.float32(0.5), 'none')
    """
    _among(integration, get_args(Integration), "integration")
    _among(method, get_args(Method), "method")
    _among(model, ("auto", *UNKNOWNS), "model")
    array = _checked_images(images)
    inside = checked_mask(mask, (array.shape[1], array.shape[2]))
    brightness = None if intensities is None else _checked_intensities(intensities, len(array))
    stack = Stack(array, inside, balance(brightness), _checked_saturation(saturation))
    if lights is None:
        _enough(len(array), "linear3" if model == "auto" else model)
        grey = None if brightness is None else effective(brightness)
        found = find_lights(stack, model, method, face, grey, tell)
    else:
        found = _under(stack, _checked_directions(lights, len(array)), brightness, method, tell)
    factors = leading_factors(_told(stack, tell), UNKNOWNS[found.model])
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


def _under(stack: Stack, lights: Floats, brightness: Floats | None, method: str, tell: Progress) -> Found:
    """Return what is found under known lamps."""
    _enough(len(lights), "linear3")
    if brightness is not None:
        lights = lights * effective(brightness)[:, None]
    solve = partial(known_lights.solve, lights=lights, method=method, saturation=stack.saturation)
    pixels = solved(stack, solve, lambda done, of: tell("normals", done, of))
    reason = "the directions of distant lamps were given"
    return Found(lights, pixels, "linear3", reason, Ambiguity("none", "the lights are known"), {})


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


def _checked_images(images: ArrayLike) -> Images:
    if isinstance(images, Sequence) and len({np.shape(image) for image in images}) > 1:
        shapes = [np.shape(image) for image in images]
        odd = next(index for index, shape in enumerate(shapes) if shape != shapes[0])
        raise HarmonicFaceError(
            f"images: expected all of one shape, got {shapes[0]} of the first and {shapes[odd]} of image {odd}"
        )
    mapped = isinstance(images, np.memmap) and images.dtype in (np.float32, np.float64)
    stack: Images = images if mapped else _validate.floats(images, "images")  # type: ignore[assignment]
    if stack.ndim not in (3, 4) or stack.shape[3:] not in ((), (3,)) or stack.size == 0:
        raise HarmonicFaceError(
            f"images: expected an array of shape (n, h, w) or (n, h, w, 3), got {_validate.describe(stack)}"
        )
    return stack


def checked_mask(mask: ArrayLike | None, shape: tuple[int, int]) -> Mask:
    """Return the mask, or one of all pixels.

    Raises
    ------
    HarmonicFaceError
        Another shape or type, an empty mask.
    """
    return _validate.mask(np.ones(shape, bool) if mask is None else mask, "mask", shape)


def _checked_directions(lights: ArrayLike, count: int) -> Floats:
    """Return unit directions exactly, from those that have two decimals."""
    rows = _validate.vectors(lights, "lights").astype(np.float64)
    if rows.shape != (count, 3):
        raise HarmonicFaceError(f"lights: expected one direction an image, shape ({count}, 3), got {rows.shape}")
    lengths = np.linalg.norm(rows, axis=1)
    for index in np.flatnonzero(np.abs(lengths - 1) > UNIT):
        got = "zero" if lengths[index] == 0 else f"one of length {lengths[index]:.4g}"
        raise HarmonicFaceError(
            f"lights: expected unit directions (brightness goes into intensities), got {got} for image {index}"
        )
    return np.asarray(rows / lengths[:, None])


def _checked_intensities(intensities: ArrayLike, count: int) -> Floats:
    values = _validate.finite(intensities, "intensities").astype(np.float64)
    if values.shape not in ((count,), (count, 3)):
        raise HarmonicFaceError(f"intensities: expected shape ({count},) or ({count}, 3), got {values.shape}")
    if not (values > 0).all():
        raise HarmonicFaceError(f"intensities: expected numbers above 0, got {values.min():.4g}")
    return values


def _checked_saturation(saturation: float) -> float:
    if isinstance(saturation, bool) or not saturation > 0:
        raise HarmonicFaceError(f"saturation: expected a number above 0, got {saturation}")
    return float(saturation)


def balance(brightness: Floats | None) -> Floats | None:
    """Return by what colours are multiplied so that each light is white: 1 / brightness, with mean 1."""
    if brightness is None or brightness.ndim == 1:
        return None
    return np.asarray(1 / brightness / (1 / brightness).mean(axis=1, keepdims=True))


def effective(brightness: Floats) -> Floats:
    """Return the brightness of each light in the grey of balanced colours, (n,)."""
    return brightness if brightness.ndim == 1 else np.asarray(1 / (1 / brightness).mean(axis=1))


def _enough(count: int, model: str) -> None:
    if count < UNKNOWNS[model]:
        raise HarmonicFaceError(
            f"images: expected at least {UNKNOWNS[model]}, as many as {model} has unknowns a pixel, got {count}"
        )


def _among(value: object, known: Sequence[str], name: str) -> None:
    if value not in known:
        raise HarmonicFaceError(f"{name}: expected one of {', '.join(known)}, got {value!r}")
