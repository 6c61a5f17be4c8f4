"""Photometric stereo: photographs under different lights, known or not -> a Surface, its lights, how sure both are."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo import known_lights
from harmonicface.stereo.in_blocks import Pixels, gram, solved, spread
from harmonicface.stereo.integration import integrate_normals
from harmonicface.stereo.result import Ambiguity, Model, StereoResult
from harmonicface.surfaces.surface import Surface

Integration = Literal["poisson", "weighted", "bilateral", "none"]
Method = Literal["robust", "least_squares"]
Progress = Callable[[str, int, int], None]

Mask = NDArray[np.bool_]
Stack = NDArray[np.floating[Any]]
UNKNOWNS: dict[str, int] = {"linear3": 3, "ambient4": 4, "harmonic9": 9}
UNIT = 0.02  # of a direction's length: two decimals in a file


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
        For known lamps: "robust" leaves shadows and highlights out, "least_squares" trusts everything (Woodham).
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
        World units a pixel.
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
    stack = _checked_images(images)
    inside = checked_mask(mask, (stack.shape[1], stack.shape[2]))
    if lights is None:
        raise HarmonicFaceError("lights: expected directions, got none: unknown lights cannot be solved yet")
    directions = _checked_directions(lights, len(stack), intensities)
    _enough(len(stack), "linear3")
    tell("photographs against one another", 0, 1)
    values = np.sqrt(np.maximum(np.linalg.eigvalsh(gram(stack, inside))[::-1], 0))
    tell("photographs against one another", 1, 1)
    solve = partial(known_lights.matte, lights=directions, saturation=saturation)
    found = solved(stack, inside, solve, lambda done, of: tell("normals", done, of))
    surface = _surface(found, inside, pixel_size, integration, tell)
    size = 3
    return StereoResult(
        surface=surface,
        lights=directions,
        model="linear3",
        model_reason="the directions of distant lamps were given",
        residual=spread(found.residual, inside),
        confidence=spread(found.confidence, inside),
        used=spread(found.used, inside),
        ambiguity=Ambiguity("none", "the lights are known"),
        left_out={},
        singular_values=values,
        rank=int((values > values[0] * 1e-3).sum()),
        gap=float(values[size - 1] / values[size]) if len(values) > size and values[size] > 0 else np.inf,
        condition=float(values[0] / values[size - 1]) if values[size - 1] > 0 else np.inf,
    )


def _surface(found: Pixels, inside: Mask, pixel_size: float, integration: Integration, tell: Progress) -> Surface:
    """Return normals and albedo as a Surface, with depth."""
    albedo = np.linalg.norm(found.scaled, axis=1)
    black = albedo == 0
    normals = np.where(black[:, None], [0.0, 0.0, 1.0], found.scaled / np.where(black, 1.0, albedo)[:, None])
    grid = spread(normals.astype(np.float32), inside)
    if integration == "none":
        return Surface(grid, spread(albedo, inside), inside, None, pixel_size)
    tell("depth", 0, 1)
    depth = integrate_normals(grid, inside, pixel_size)
    tell("depth", 1, 1)
    return Surface(grid, spread(albedo, inside), inside, depth.astype(np.float32), pixel_size)


def _checked_images(images: ArrayLike) -> Stack:
    if isinstance(images, Sequence) and len({np.shape(image) for image in images}) > 1:
        shapes = [np.shape(image) for image in images]
        odd = next(index for index, shape in enumerate(shapes) if shape != shapes[0])
        raise HarmonicFaceError(f"images: expected one shape, got {shapes[0]} of the first and {shapes[odd]} of {odd}")
    stack = images if isinstance(images, np.memmap) and images.dtype.kind == "f" else _validate.floats(images, "images")
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


def _checked_directions(lights: ArrayLike, count: int, intensities: ArrayLike | None) -> Floats:
    """Return directions times brightness."""
    rows = _validate.vectors(lights, "lights").astype(np.float64)
    if rows.shape != (count, 3):
        raise HarmonicFaceError(f"lights: expected one direction an image, shape ({count}, 3), got {rows.shape}")
    lengths = np.linalg.norm(rows, axis=1)
    for index in np.flatnonzero(np.abs(lengths - 1) > UNIT):
        got = "zero" if lengths[index] == 0 else f"one of length {lengths[index]:.4g}"
        raise HarmonicFaceError(
            f"lights: expected unit directions (brightness goes into intensities), got {got} for image {index}"
        )
    rows /= lengths[:, None]
    return rows if intensities is None else rows * _checked_intensities(intensities, count)[:, None]


def _checked_intensities(intensities: ArrayLike, count: int) -> Floats:
    """Return the mean brightness of each light."""
    values = _validate.finite(intensities, "intensities").astype(np.float64)
    if values.shape not in ((count,), (count, 3)):
        raise HarmonicFaceError(f"intensities: expected shape ({count},) or ({count}, 3), got {values.shape}")
    if not (values > 0).all():
        raise HarmonicFaceError(f"intensities: expected numbers above 0, got {values.min():.4g}")
    return values if values.ndim == 1 else np.asarray(values.mean(axis=1))


def _enough(count: int, model: str) -> None:
    if count < UNKNOWNS[model]:
        raise HarmonicFaceError(
            f"images: expected at least {UNKNOWNS[model]}, as many as {model} has unknowns a pixel, got {count}"
        )


def _among(value: object, known: Sequence[str], name: str) -> None:
    if value not in known:
        raise HarmonicFaceError(f"{name}: expected one of {', '.join(known)}, got {value!r}")
