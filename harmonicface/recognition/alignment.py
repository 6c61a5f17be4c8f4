"""Alignment: where a person is in a photograph, found while her pictures explain it under whatever light."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.subspace import Subspace
from harmonicface.stereo.motion import STILL, Matrix, checked_motion, displacement, seen_through, then

MOTIONS = {"shift": 2, "rigid": 3, "similarity": 4}  # parameters: right, down, turn, growth
ROUNDS = 20  # most photographs need four to eight
SMALLEST_STEP = 0.01  # pixels in the mean: what is nearer is the same place
SHORTEST = 1 / 16  # of a step: what does not improve the distance then is its minimum


@dataclass(frozen=True, eq=False)
class Alignment:
    """Where a person was found in a photograph.

    Parameters
    ----------
    motion
        (2, 3), from pixel coordinates (x to the right, y down) of the frame in which she is enrolled to those of the
        photograph.
    distance
        The sine of the angle between her subspace and the photograph seen through the motion, 0 to 1, at the finest
        size that was compared.
    """

    motion: Matrix
    distance: float


def align(
    photo: ArrayLike, pyramid: Sequence[ArrayLike], start: ArrayLike = STILL, motion: str = "similarity"
) -> Alignment:
    r"""Register a photograph to a person by Gauss-Newton steps in which the light is eliminated.

    With the person's orthonormal pictures Q, the photograph seen through the motion, y, and its derivatives J by the
    parameters of a small motion before it, each step solves

    .. math:: \min_d \| (I - Q^T Q) (y + J d) \|

    so that what light can explain moves nothing (Hager & Belhumeur, Efficient region tracking with parametric models
    of geometry and illumination, 1998), and is shortened until the distance falls. Coarse sizes come first.

    Parameters
    ----------
    photo
        (h, w) linear intensities of the size of the last pictures.
    pyramid
        Her orthonormal pictures, each (r, h, w) at its size, from coarse to fine (`pyramid_of`).
    start
        (2, 3) motion to begin with, in pixels of the photograph.
    motion
        "shift", "rigid" (and a rotation) or "similarity" (and a scale).

    Returns
    -------
    Alignment
        Never farther than the start at any size.

    Raises
    ------
    HarmonicFaceError
        Shapes that do not fit, NaN, a black photograph, a motion of another kind or without an inverse.

    Examples
    --------
    >>> from scipy.ndimage import gaussian_filter, shift
    >>> face = gaussian_filter(np.random.default_rng(0).uniform(0, 1, (32, 32)), 3)
    >>> found = align(shift(face, (0.5, -1), mode="nearest"), pyramid_of(face[None], (1,)), motion="shift")
    >>> found.motion.round(1) + 0.0
    array([[ 1. ,  0. , -1. ],
           [ 0. ,  1. ,  0.5]])
    """
    if motion not in MOTIONS:
        raise HarmonicFaceError(f"motion: expected one of {', '.join(MOTIONS)}, got {motion!r}")
    pixels = _checked_photo(photo)
    levels = [_checked_rows(rows) for rows in pyramid]
    if not levels or levels[-1].shape[1:] != pixels.shape:
        sizes = [rows.shape[1:] for rows in levels]
        raise HarmonicFaceError(f"pyramid: expected pictures up to the photo's size {pixels.shape}, got {sizes}")
    found = Alignment(checked_motion(start), 1.0)
    for rows in levels:
        factor = pixels.shape[0] // rows.shape[1]
        found = _descend(_small(pixels, factor), rows, _resized(found.motion, 1 / factor), MOTIONS[motion])
        found = Alignment(_resized(found.motion, factor), found.distance)
    return found


def pyramid_of(images: ArrayLike, factors: Sequence[int] = (2, 1)) -> list[NDArray[np.float32]]:
    """Return orthonormal pictures with the span of some pictures at reduced sizes.

    Parameters
    ----------
    images
        (k, h, w) pictures of a person.
    factors
        By how much each size is smaller, from coarse to fine; each divides h and w.

    Returns
    -------
    list of arrays
        (r, h / factor, w / factor) float32, orthonormal as vectors.

    Raises
    ------
    HarmonicFaceError
        Another shape, NaN, a factor that does not divide the size, pictures that are all 0.

    Examples
    --------
    >>> [rows.shape for rows in pyramid_of(np.ones((1, 8, 4)))]
    [(1, 4, 2), (1, 8, 4)]
    """
    pictures = _checked_rows(images)
    small = [reduced(pictures, factor) for factor in factors]
    return [Subspace.of(level.reshape(len(level), -1)).rows.reshape(-1, *level.shape[1:]) for level in small]


def reduced(images: Floats, factor: int) -> Floats:
    """Return pictures (k, h, w) with squares of pixels averaged, (k, h / factor, w / factor).

    Raises
    ------
    HarmonicFaceError
        A factor below 1, or one that does not divide height and width.
    """
    _validate.at_least(factor, 1, "factor")
    count, height, width = images.shape
    if height % factor or width % factor:
        raise HarmonicFaceError(f"factor: expected a divisor of {height} and {width}, got {factor}")
    if factor == 1:
        return images
    return np.asarray(images.reshape(count, height // factor, factor, width // factor, factor).mean(axis=(2, 4)))


def _descend(photo: NDArray[np.float32], rows: NDArray[np.float32], motion: Matrix, parameters: int) -> Alignment:
    """Step downhill from a motion at one size."""
    flat = rows.reshape(len(rows), -1)
    seen = seen_through(photo, motion)
    residual, distance = _unexplained(seen, flat)
    for _ in range(ROUNDS):
        derivatives = _derivatives(seen)[:parameters]
        derivatives -= (derivatives @ flat.T) @ flat
        curvature = (derivatives @ derivatives.T).astype(np.float64)
        step = np.linalg.lstsq(curvature, -(derivatives @ residual).astype(np.float64), rcond=1e-9)[0]
        share, moved = 1.0, False
        while share >= SHORTEST:
            small = _small_motion(share * step, photo.shape)
            candidate = then(small, motion)
            seen_there = seen_through(photo, candidate)
            residual_there, distance_there = _unexplained(seen_there, flat)
            if distance_there < distance:
                motion, seen, residual, distance, moved = candidate, seen_there, residual_there, distance_there, True
                break
            share /= 2
        if not moved or displacement(small, photo.shape) < SMALLEST_STEP:
            break
    return Alignment(motion, distance)


def _small(photo: NDArray[np.float32], factor: int) -> NDArray[np.float32]:
    """Return a photograph at a reduced size."""
    return np.ascontiguousarray(reduced(photo[None], factor)[0], np.float32)


def _unexplained(seen: NDArray[np.float32], rows: NDArray[np.float32]) -> tuple[NDArray[np.float32], float]:
    """Return what of a photograph no light explains, and its share of the photograph's length."""
    pixels = seen.ravel()
    length = float(np.linalg.norm(pixels))
    if length == 0:  # it was moved out of sight
        return pixels, 1.0
    residual = np.asarray(pixels - (rows @ pixels) @ rows, np.float32)
    return residual, min(1.0, float(np.linalg.norm(residual)) / length)


def _derivatives(seen: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return how a picture changes as it is seen from a little to the right, below, turned, grown: (4, p)."""
    down, right = np.gradient(seen)
    y, x = (_centred(size) for size in seen.shape)
    x, y = x[None, :], y[:, None]
    changes = [right, down, down * x - right * y, right * x + down * y]
    return np.stack([change.ravel() for change in changes]).astype(np.float32)


def _small_motion(parameters: Floats, shape: tuple[int, ...]) -> Matrix:
    """Return the motion of these parameters about the centre of a picture."""
    right, down, turn, growth = np.pad(parameters, (0, 4 - len(parameters)))
    linear = (1 + growth) * np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    centre = (np.array(shape[::-1]) - 1) / 2
    return np.column_stack([linear, centre - linear @ centre + [right, down]])


def _resized(motion: Matrix, factor: float) -> Matrix:
    """Return the same motion in pixels that are smaller by a factor."""
    offset = (factor - 1) / 2  # the centre of pixel 0 in the new pixels
    grow = np.array([[factor, 0, offset], [0, factor, offset]])
    shrink = np.array([[1 / factor, 0, -offset / factor], [0, 1 / factor, -offset / factor]])
    return then(then(shrink, motion), grow)


def _centred(size: int) -> NDArray[np.float32]:
    """Return the coordinates of pixels from the centre of their row."""
    return np.arange(size, dtype=np.float32) - (size - 1) / 2


def _checked_photo(photo: ArrayLike) -> NDArray[np.float32]:
    pixels = _validate.finite(photo, "photo")
    if pixels.ndim != 2 or min(pixels.shape) < 2:
        raise HarmonicFaceError(f"photo: expected shape (h, w), at least 2 x 2, got {_validate.describe(pixels)}")
    if not pixels.any():
        raise HarmonicFaceError("photo: expected some light in it, got one that is all 0")
    return np.asarray(pixels / np.abs(pixels).max(), np.float32)


def _checked_rows(rows: ArrayLike) -> NDArray[np.float32]:
    pictures = _validate.finite(rows, "pictures")
    if pictures.ndim != 3 or pictures.size == 0:
        raise HarmonicFaceError(f"pictures: expected shape (k, h, w), got {_validate.describe(pictures)}")
    return np.asarray(pictures, np.float32)
