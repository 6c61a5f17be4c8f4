"""The frame of a gallery: the one pixel grid and mask in which everybody is compared."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.colour import luminance
from harmonicface.stereo.motion import Matrix, seen_through

LARGEST = 1e30  # sums over pixels stay finite in float32
WHOLE = 0.99  # of a pixel must be good for it to be good where it is moved to


@dataclass(frozen=True, eq=False)
class Frame:
    """The pixels that are compared.

    Parameters
    ----------
    mask
        (h, w) booleans with at least one true.
    """

    mask: NDArray[np.bool_]

    @classmethod
    def of(cls, mask: ArrayLike) -> Frame:
        """Make a frame of a mask that a user gives.

        Raises
        ------
        HarmonicFaceError
            Not a (h, w) array of booleans, or nothing in it.
        """
        given = np.asarray(mask)
        if given.ndim != 2:
            raise HarmonicFaceError(f"mask: expected shape (h, w), got {_validate.describe(given)}")
        return cls(_validate.mask(given, "mask", (given.shape[0], given.shape[1])).copy())

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the photographs."""
        return self.mask.shape[0], self.mask.shape[1]

    @property
    def pixels(self) -> int:
        """How many pixels are compared."""
        return int(self.mask.sum())

    def take(self, picture: ArrayLike, name: str) -> Floats:
        """Return the compared pixels of a picture, (p,); colour becomes luminance.

        Raises
        ------
        HarmonicFaceError
            Another shape than the frame's, NaN or infinity, more negative than positive intensities.
        """
        array = _validate.image(picture, name)
        if array.shape[:2] != self.shape:
            raise HarmonicFaceError(f"{name}: expected the gallery's shape {self.shape}, got {array.shape[:2]}")
        if not -array.min() <= array.max() <= LARGEST:
            expected = f"intensities of at least 0 (noise may be below) and at most {LARGEST:g}"
            raise HarmonicFaceError(f"{name}: expected {expected}, got {array.min():.4g} to {array.max():.4g}")
        return (array if array.ndim == 2 else luminance(array))[self.mask]

    def place(self, images: Floats, mask: NDArray[np.bool_]) -> Floats:
        """Return images of masked pixels in this frame, (k, p), 0 where the frame is outside that mask.

        Raises
        ------
        HarmonicFaceError
            The mask is of another shape, or no pixel of it is in the frame.
        """
        if mask.shape != self.shape:
            raise HarmonicFaceError(f"surface: expected the gallery's shape {self.shape}, got {mask.shape}")
        shared = mask & self.mask
        if not shared.any():
            raise HarmonicFaceError("surface: expected some of its pixels inside the gallery's mask, got none")
        placed = np.zeros((len(images), self.pixels), images.dtype)
        placed[:, mask[self.mask]] = images[:, self.mask[mask]]
        return placed

    def picture(self, pixels: Floats) -> Floats:
        """Return compared pixels as a picture, (h, w), 0 elsewhere."""
        result = np.zeros(self.shape, pixels.dtype)
        result[self.mask] = pixels
        return result

    def moved(
        self, pixels: Floats, good: NDArray[np.bool_], shift: tuple[int, int]
    ) -> tuple[Floats, NDArray[np.bool_]]:
        """Return compared pixels, and which are good, of the picture moved to the right and down.

        What comes in from outside the frame is not good.
        """
        right, down = shift
        height, width = self.shape
        target = np.s_[max(down, 0) : height + min(down, 0), max(right, 0) : width + min(right, 0)]
        origin = np.s_[max(-down, 0) : height + min(-down, 0), max(-right, 0) : width + min(-right, 0)]
        picture, known = np.zeros(self.shape, pixels.dtype), np.zeros(self.shape, np.bool_)
        picture[target] = self.picture(pixels)[origin]
        known[target] = self.picture(good.astype(np.float32))[origin] > 0
        return picture[self.mask], known[self.mask]

    def seen_through(self, pixels: Floats, good: NDArray[np.bool_], motion: Matrix) -> tuple[Floats, NDArray[np.bool_]]:
        """Return compared pixels, and which are good, of the picture as seen through a motion (`seen_through`).

        Beyond the frame its border is repeated.
        """
        picture = seen_through(np.asarray(self.picture(pixels), np.float32), motion)
        known = seen_through(np.asarray(self.picture(good.astype(np.float32)), np.float32), motion) > WHOLE
        return picture[self.mask], known[self.mask]
