"""The grid on which fine detail is compared: at most 96 rows, whatever the size of the photographs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.blocks import BLOCK

ROWS = 96  # photographs with fewer keep theirs
SMALLEST = 2 * BLOCK  # pixels a side: fewer than 2 x 2 blocks tell little
NEIGHBOURHOOD = 3.0  # standard deviation in pixels of what counts as local

Picture = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class OnGrid:
    """A picture on its grid.

    Parameters
    ----------
    light
        (h, w) float32; what the mask hides is filled from its surroundings, so that the mask draws no edge.
    seen
        (h, w) booleans, false where the mask hides most of a pixel; None where there was no mask.
    """

    light: Picture
    seen: NDArray[np.bool_] | None


def grid(shape: tuple[int, int]) -> tuple[int, int]:
    """Return height and width at which photographs of this shape are compared: 96 rows, or their own if they have less.

    Raises
    ------
    HarmonicFaceError
        Fewer than 24 pixels a side on that grid.

    Examples
    --------
    >>> grid((192, 168)), grid((64, 64))
    ((96, 84), (64, 64))
    """
    rows = min(ROWS, shape[0])
    columns = round(shape[1] * rows / shape[0]) if shape[0] else 0
    if min(rows, columns) < SMALLEST:
        expected = f"at least {SMALLEST} pixels a side, for two blocks of {BLOCK}"
        raise HarmonicFaceError(f"photo: expected {expected}, got {rows} x {columns} (at most {ROWS} rows are used)")
    return rows, columns


def on_grid(photo: ArrayLike, mask: ArrayLike | None = None) -> OnGrid:
    """Return a photograph on its grid, by averages over areas, its largest magnitude 1.

    Parameters
    ----------
    photo
        (h, w) linear intensities in any unit, at least 24 pixels a side.
    mask
        (h, w) booleans, false where the photograph is bad.

    Raises
    ------
    HarmonicFaceError
        Another shape, too few pixels, NaN or infinity, another mask.

    Examples
    --------
    >>> on_grid(np.ones((192, 168))).light.shape
    (96, 84)
    """
    pixels = _validate.finite(photo, "photo")
    if pixels.ndim != 2:
        raise HarmonicFaceError(f"photo: expected shape (h, w), got {_validate.describe(pixels)}")
    shape = (pixels.shape[0], pixels.shape[1])
    size = grid(shape)
    good = None if mask is None else _validate.mask(mask, "mask", shape)
    if good is not None and good.all():
        good = None
    largest = float(np.abs(pixels if good is None else pixels[good]).max()) or 1.0
    scaled = np.asarray(pixels / largest, np.float32) if good is None else np.zeros(shape, np.float32)
    if good is None:
        return OnGrid(resized(scaled, size), None)
    scaled[good] = pixels[good] / largest
    cover = resized(good.astype(np.float32), size)
    return OnGrid(filled(resized(scaled, size), cover), cover > 0.5)


def resized(picture: Picture, size: tuple[int, int]) -> Picture:
    """Return a picture at a smaller size by averaging areas."""
    if picture.shape == size:
        return picture
    return np.asarray(cv2.resize(picture, size[::-1], interpolation=cv2.INTER_AREA))


def filled(light: Picture, cover: Picture) -> Picture:
    """Return a picture, of which each pixel holds so much light of the cover, filled where it covers less than half.

    Linear in the light, so that a combination of pictures stays one.
    """
    tiny = np.float32(1e-12)
    near = blurred(cover, NEIGHBOURHOOD)
    everywhere = light.sum() / max(float(cover.sum()), 1e-12)
    around = np.where(near > tiny, blurred(light, NEIGHBOURHOOD) / np.maximum(near, tiny), everywhere)
    return np.asarray(np.where(cover > 0.5, light / np.maximum(cover, tiny), around), np.float32)


def blurred(picture: Picture, deviation: float) -> Picture:
    """Return a picture seen through a Gaussian that ends at four deviations, reflected at its borders."""
    kernel = _kernel(deviation)
    return np.asarray(cv2.sepFilter2D(picture, cv2.CV_32F, kernel, kernel, borderType=cv2.BORDER_REFLECT))


@lru_cache(maxsize=16)
def _kernel(deviation: float) -> Picture:
    """Return the taps of a Gaussian."""
    reach = int(4 * deviation + 0.5)
    taps = np.exp(-0.5 * np.square(np.arange(-reach, reach + 1) / deviation))
    return np.asarray(taps / taps.sum(), np.float32)
