"""Checks of what photometric stereo is given; each refuses in one line what cannot be solved."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.in_blocks import Images, Stack

Mask = NDArray[np.bool_]
UNKNOWNS: dict[str, int] = {"linear3": 3, "ambient4": 4, "harmonic9": 9}
UNIT = 0.02  # of a direction's length: two decimals in a file
ASKED = 50_000  # pixels, about, that tell whether the images are burnt out
FEWEST = 3  # photographs that a pixel is solved from


def checked_images(images: ArrayLike) -> Images:
    """Return images as an array, mapped ones as they are; refuse unlike shapes."""
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


def checked_directions(lights: Any, count: int) -> Floats:
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


def checked_intensities(intensities: ArrayLike, count: int) -> Floats:
    """Return brightness above 0 of each light, (n,) or (n, 3)."""
    values = _validate.finite(intensities, "intensities").astype(np.float64)
    if values.shape not in ((count,), (count, 3)):
        raise HarmonicFaceError(f"intensities: expected shape ({count},) or ({count}, 3), got {values.shape}")
    if not (values > 0).all():
        raise HarmonicFaceError(f"intensities: expected numbers above 0, got {values.min():.4g}")
    return values


def checked_saturation(saturation: float) -> float:
    """Return a ceiling above 0, or infinity."""
    if isinstance(saturation, bool) or not saturation > 0:
        raise HarmonicFaceError(f"saturation: expected a number above 0, got {saturation}")
    return float(saturation)


def require_unburnt(stack: Stack) -> None:
    """Refuse photographs of which most pixels are burnt out in all but two, as of another range than was said."""
    step = max(int(np.sqrt(stack.pixels / ASKED)), 1)
    thin = Stack(stack.images[:, ::step, ::step], stack.mask[::step, ::step], stack.balance, stack.saturation)
    if not thin.mask.any():
        return
    enough = min(FEWEST, len(stack))
    burnt = np.concatenate([(block < stack.saturation).sum(axis=0) < enough for block in thin.blocks()])
    if burnt.mean() > 0.5:
        raise HarmonicFaceError(
            f"images: expected intensities below saturation={stack.saturation:g} in {enough} photographs of most"
            f" pixels, got {burnt.mean():.0%} of them burnt out in too many (saturation=inf: images have no ceiling)"
        )


def require_enough(count: int, model: str) -> None:
    """Refuse fewer images than a model of light has unknowns a pixel."""
    if count < UNKNOWNS[model]:
        raise HarmonicFaceError(
            f"images: expected at least {UNKNOWNS[model]}, as many as {model} has unknowns a pixel, got {count}"
        )


def require_among(value: object, known: Sequence[str], name: str) -> None:
    """Refuse an option that is none."""
    if value not in known:
        raise HarmonicFaceError(f"{name}: expected one of {', '.join(known)}, got {value!r}")
