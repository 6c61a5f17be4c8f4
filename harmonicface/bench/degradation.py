"""Degradation: what cameras, files and poor cropping do to a photograph before it is asked for."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError

Picture = NDArray[np.float32]


def noisy(photo: Picture, deviation: float, seed: int | np.random.Generator) -> Picture:
    """Return a photograph with Gaussian noise of a standard deviation, white being 1, clipped to 0 to 1.

    Examples
    --------
    >>> noisy(np.full((2, 2), 0.5, np.float32), 0.0, 0).tolist()
    [[0.5, 0.5], [0.5, 0.5]]
    """
    rng = np.random.default_rng(seed)
    return np.clip(photo + deviation * rng.standard_normal(photo.shape), 0, 1).astype(np.float32)


def compressed(photo: Picture, quality: int) -> Picture:
    """Return a photograph of 0 to 1 after 8 bits and JPEG of a quality, 1 to 100.

    Raises
    ------
    HarmonicFaceError
        Another quality.

    Examples
    --------
    >>> compressed(np.zeros((8, 8), np.float32), 50).max().item()
    0.0
    """
    if not 1 <= _validate.at_least(quality, 1, "jpeg") <= 100:
        raise HarmonicFaceError(f"jpeg: expected a quality from 1 to 100, got {quality}")
    data = cv2.imencode(".jpg", _bytes(photo), [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
    return _floats(np.asarray(cv2.imdecode(data, cv2.IMREAD_GRAYSCALE)))


def moved(photo: Picture, right: float = 0.0, down: float = 0.0, degrees: float = 0.0, scale: float = 1.0) -> Picture:
    """Return a photograph turned clockwise and scaled about its middle, then shifted by pixels; its border repeats.

    Examples
    --------
    >>> moved(np.eye(4, dtype=np.float32), right=1)[0].tolist()
    [1.0, 1.0, 0.0, 0.0]
    """
    height, width = photo.shape
    matrix = cv2.getRotationMatrix2D(((width - 1) / 2, (height - 1) / 2), -degrees, scale)
    matrix[:, 2] += right, down
    how = {"flags": cv2.INTER_LINEAR, "borderMode": cv2.BORDER_REPLICATE}
    return np.asarray(cv2.warpAffine(photo, matrix, (width, height), **how), np.float32)


def blurred(photo: Picture, deviation: float) -> Picture:
    """Return a photograph blurred by a Gaussian of so many pixels.

    Examples
    --------
    >>> blurred(np.ones((4, 4), np.float32), 2.0).round(3).min().item()
    1.0
    """
    if deviation == 0:
        return photo
    return np.asarray(cv2.GaussianBlur(photo, (0, 0), deviation, borderType=cv2.BORDER_REFLECT), np.float32)


def at_resolution(photo: Picture, width: int) -> Picture:
    """Return a photograph as a camera with so many pixels across sees it, enlarged to its own size again.

    Examples
    --------
    >>> at_resolution(np.eye(4, dtype=np.float32), 2).shape
    (4, 4)
    """
    height, full = photo.shape
    if width == full:
        return photo
    small = cv2.resize(photo, (width, max(1, round(height * width / full))), interpolation=cv2.INTER_AREA)
    large = cv2.resize(_floats(_bytes(small)), (full, height), interpolation=cv2.INTER_CUBIC)
    return np.asarray(np.clip(large, 0, 1), np.float32)


def with_gamma(photo: Picture, gamma: float) -> Picture:
    """Return a photograph from a camera whose grey levels go as a power of the light, in 8 bits.

    Examples
    --------
    >>> with_gamma(np.full((1, 1), 0.25, np.float32), 0.5).round(2).item()
    0.5
    """
    return _floats(_bytes(np.power(photo, np.float32(gamma))))


def _bytes(photo: Picture) -> NDArray[np.uint8]:
    return np.asarray(np.rint(255 * np.clip(photo, 0, 1)), np.uint8)


def _floats(image: NDArray[Any]) -> Picture:
    return np.asarray(image.astype(np.float32) / np.float32(255))
