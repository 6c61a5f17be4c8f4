"""One check per kind of array, named by what it holds; each message says what was expected and what came."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface.errors import HarmonicFaceError

Floats = NDArray[np.floating[Any]]


def describe(value: object) -> str:
    """Name what came, for the second half of a message: its shape and dtype, or its type."""
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape} and type {value.dtype}"
    return " ".join(f"{type(value).__name__} {value!r}".split())[:120]


def floats(value: ArrayLike, name: str) -> Floats:
    """Return real numbers as a float array: float32 and float64 stay as they are, the rest becomes float64."""
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "biuf":
            raise TypeError
    except (TypeError, ValueError):
        raise HarmonicFaceError(f"{name}: expected an array of real numbers, got {describe(value)}") from None
    if array.dtype in (np.float32, np.float64):
        return array
    return array.astype(np.float64)


def finite(value: ArrayLike, name: str) -> Floats:
    """Return a float array without NaN or infinity."""
    array = floats(value, name)
    if not np.isfinite(array).all():
        count = int(array.size - np.isfinite(array).sum())
        raise HarmonicFaceError(
            f"{name}: expected finite numbers, got {count} NaN or infinite of {array.size} in {describe(array)}"
        )
    return array


def vectors(value: ArrayLike, name: str) -> Floats:
    """Return finite vectors of shape (..., 3)."""
    array = finite(value, name)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise HarmonicFaceError(f"{name}: expected vectors of shape (..., 3), got {describe(array)}")
    return array


def directions(value: ArrayLike, name: str) -> Floats:
    """Return vectors of shape (..., 3) scaled to unit length; a zero vector has no direction."""
    array = vectors(value, name)
    largest = np.abs(array).max(axis=-1, keepdims=True, initial=0.0)
    if (largest == 0).any():
        raise HarmonicFaceError(f"{name}: expected directions, got a vector of zero length")
    scaled = array / largest  # a vector of tiny or huge numbers keeps its direction
    return np.asarray(scaled / np.linalg.norm(scaled, axis=-1, keepdims=True))


def unit_normals(value: ArrayLike, name: str) -> Floats:
    """Return vectors of shape (..., 3) that already have unit length (to 1e-3)."""
    array = vectors(value, name)
    squared = np.einsum("...i,...i->...", array, array)
    if array.size and np.abs(squared - 1).max() > 2e-3:
        worst = np.sqrt(squared.flat[np.abs(squared - 1).argmax()])
        raise HarmonicFaceError(f"{name}: expected unit vectors, got one of length {worst:.4g}")
    return array


def image(value: ArrayLike, name: str) -> Floats:
    """Return a finite image of shape (h, w) or (h, w, 3)."""
    array = finite(value, name)
    if not (array.ndim == 2 or (array.ndim == 3 and array.shape[2] == 3)) or array.size == 0:
        raise HarmonicFaceError(f"{name}: expected an image of shape (h, w) or (h, w, 3), got {describe(array)}")
    return array


def mask(value: ArrayLike, name: str, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Return a boolean mask of the given shape with at least one pixel in it."""
    array = np.asarray(value)
    if array.shape != shape or array.dtype != np.bool_:
        raise HarmonicFaceError(f"{name}: expected a boolean mask of shape {shape}, got {describe(array)}")
    if not array.any():
        raise HarmonicFaceError(f"{name}: expected at least one pixel in the mask, got an empty one of shape {shape}")
    return array


def positive(value: float, name: str) -> float:
    """Return a finite number above zero."""
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise HarmonicFaceError(f"{name}: expected a number above 0, got {describe(value)}")
    try:
        number = float(value)
    except OverflowError:
        number = np.inf  # an integer beyond the largest float
    if not (np.isfinite(number) and number > 0):
        raise HarmonicFaceError(f"{name}: expected a finite number above 0, got {number}")
    return number


def fraction(value: float, name: str) -> float:
    """Return a number from 0 to 1."""
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise HarmonicFaceError(f"{name}: expected a number from 0 to 1, got {describe(value)}")
    if not 0 <= value <= 1:
        raise HarmonicFaceError(f"{name}: expected a number from 0 to 1, got {value}")
    return float(value)


def at_least(value: int, least: int, name: str) -> int:
    """Return an integer that is not below `least`."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < least:
        raise HarmonicFaceError(f"{name}: expected an integer of at least {least}, got {describe(value)}")
    return int(value)


def generator(value: int | np.random.Generator, name: str) -> np.random.Generator:
    """Return a random generator; an integer of at least 0 seeds one."""
    return value if isinstance(value, np.random.Generator) else np.random.default_rng(at_least(value, 0, name))
