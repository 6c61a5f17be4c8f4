"""Occlusion: what people wear or hold before their faces when a photograph is taken."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError

Picture = NDArray[np.float32]

BRIGHT = 95  # percentile of a photograph that a bright thing in its light reaches
LENS = (0.11, 0.16)  # half height and width of a lens, of the photograph's
RIM = 0.18  # of the lens, how thick the rim is
RIM_SHARE, DARK_SHARE = 0.05, 0.12  # of the light that a rim and a dark lens leave
GLARE = 0.2  # of the lens, the radius of a reflection of the lamp
FILLS = ("texture", "grey")


def behind_block(photo: Picture, share: float, seed: int | np.random.Generator, fill: str = "texture") -> Picture:
    """Return a photograph with a block before it at a random place.

    Parameters
    ----------
    photo
        (h, w) linear intensities.
    share
        Of the area, 0 to 1; the block has the photograph's proportions.
    seed
        Of the place and of what is on the block.
    fill
        "texture": a pattern with the spectrum of natural pictures (amplitude falls as one over the frequency), as
        bright as the face. "grey": one intensity between a fifth and all of that of the bright parts.

    Raises
    ------
    HarmonicFaceError
        Another shape, a share outside 0 to 1, another fill.

    Examples
    --------
    >>> hidden = behind_block(np.zeros((10, 20), np.float32) + 1, 0.25, seed=0, fill="grey")
    >>> int((hidden < 1).sum())
    50
    """
    pixels = _validate.finite(photo, "photo")
    if pixels.ndim != 2:
        raise HarmonicFaceError(f"photo: expected shape (h, w), got {_validate.describe(pixels)}")
    side = _validate.fraction(share, "share") ** 0.5
    if fill not in FILLS:
        raise HarmonicFaceError(f"fill: expected one of {', '.join(FILLS)}, got {fill!r}")
    rng = _validate.generator(seed, "seed")
    height, width = (round(side * size) for size in pixels.shape)
    top, left = (
        int(rng.integers(0, size - part + 1)) for size, part in zip(pixels.shape, (height, width), strict=True)
    )
    bright = np.percentile(pixels, BRIGHT)
    hidden = pixels.astype(np.float32)
    block = natural_texture((height, width), rng) if fill == "texture" else rng.uniform(0.2, 1)
    hidden[top : top + height, left : left + width] = bright * block
    return hidden


def behind_glasses(photo: Picture, eyes: tuple[float, float, float], dark: bool = False) -> Picture:
    """Return a photograph with glasses: rims, a reflection of the lamp on each lens, and lenses that may be dark.

    Parameters
    ----------
    photo
        (h, w) linear intensities.
    eyes
        Row of the eyes as a part of the height, columns of both as parts of the width.
    dark
        Whether the lenses are those of sunglasses, which leave 12 % of the light.

    Raises
    ------
    HarmonicFaceError
        Another shape; eyes outside the photograph.

    Examples
    --------
    >>> worn = behind_glasses(np.ones((60, 60), np.float32), (0.4, 0.3, 0.7), dark=True)
    >>> [round(float(worn[place]), 2) for place in ((24, 18), (24, 30), (50, 30))]
    [0.12, 0.05, 1.0]
    """
    pixels = _validate.finite(photo, "photo")
    if pixels.ndim != 2:
        raise HarmonicFaceError(f"photo: expected shape (h, w), got {_validate.describe(pixels)}")
    row, *columns = (_validate.fraction(part, "eyes") for part in eyes)
    height, width = pixels.shape
    down, across = np.mgrid[:height, :width]
    y = (down + 0.5 - row * height) / (LENS[0] * height)
    bright = np.percentile(pixels, BRIGHT)
    worn = pixels.astype(np.float32)
    between = (across + 0.5 > min(columns) * width) & (across + 0.5 < max(columns) * width)
    from_lens = [np.hypot(y, (across + 0.5 - column * width) / (LENS[1] * width)) for column in columns]
    bridge = between & (np.abs(y) < RIM) & (np.minimum(*from_lens) > 1)
    worn[bridge] *= RIM_SHARE
    for column, radius in zip(columns, from_lens, strict=True):
        if dark:
            worn[radius < 1] *= DARK_SHARE
        worn[(radius >= 1) & (radius < 1 + RIM)] = RIM_SHARE * pixels[(radius >= 1) & (radius < 1 + RIM)]
        x = (across + 0.5 - column * width) / (LENS[1] * width)
        worn[np.hypot(y + 0.4, x - 0.4) < GLARE] = 1.5 * bright
    return worn


def natural_texture(shape: tuple[int, int], rng: np.random.Generator) -> Floats:
    """Return noise from 0 to 1 whose amplitude falls as one over the frequency, as that of natural pictures does."""
    if min(shape) == 0:
        return np.zeros(shape)
    frequency = np.hypot(np.fft.fftfreq(shape[0])[:, None], np.fft.rfftfreq(shape[1])[None])
    frequency.flat[0] = 1
    noise = np.fft.irfft2(np.fft.rfft2(rng.standard_normal(shape)) / frequency, shape)
    spread = np.ptp(noise)
    return np.asarray((noise - noise.min()) / spread if spread else np.ones(shape))
