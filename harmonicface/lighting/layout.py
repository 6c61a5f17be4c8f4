"""What a layout of an environment map has to know: where on the sphere each pixel is, and how large it is."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from harmonicface import _memory, _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError

Shape = tuple[int, ...]


class Layout(ABC):
    """A way to draw the whole sphere as a picture.

    Pixels are addressed by the shape of the picture without its colours: (rows, columns), or (6, rows, columns) for
    the faces of a cube. Axes as everywhere: x right, y up, z toward the camera; row 0 is the top.
    """

    name: str

    @abstractmethod
    def shape(self, size: int) -> Shape:
        """Return the shape of a map with `size` rows (of each face)."""

    @abstractmethod
    def check(self, radiance: Floats) -> None:
        """Raise HarmonicFaceError unless the array has a shape of this layout, without or with three colours."""

    def directions(self, shape: Shape, across: float = 0.5, down: float = 0.5) -> NDArray[np.float64]:
        """Return a unit direction in each pixel, (*shape, 3): by default that of its centre.

        `across` and `down` are fractions of the pixel from its left and its top.

        Raises
        ------
        HarmonicFaceError
            More pixels than the memory holds directions of.
        """
        self.require_memory(shape)
        return self._directions(shape, across, down)

    @abstractmethod
    def _directions(self, shape: Shape, across: float, down: float) -> NDArray[np.float64]:
        """Return the directions of as many pixels as the memory holds."""

    def require_memory(self, shape: Shape) -> None:
        """Raise HarmonicFaceError unless the memory holds a map of directions and the parts it is made of."""
        _memory.require(2 * 3 * 8 * math.prod(shape), f"{self.name} map of {' x '.join(map(str, shape))} pixels")

    @abstractmethod
    def area_element(self, shape: Shape, across: float = 0.5, down: float = 0.5) -> NDArray[np.float64]:
        """Return how much sphere there is around these directions for the same area of picture, up to a factor."""

    @abstractmethod
    def solid_angles(self, shape: Shape) -> NDArray[np.float64]:
        """Return the solid angle of each pixel; they sum to 4 pi."""

    @abstractmethod
    def sample(self, radiance: Floats, directions: NDArray[np.float64]) -> Floats:
        """Return the radiance toward (..., 3) directions, bilinear between the centres of pixels, across all seams."""

    def fold(self, values: Floats) -> tuple[Floats, Floats] | None:
        """Return the values (one a pixel, colours last) of half of the pixels and those of their antipodes.

        None where the antipode of a pixel is not a pixel.
        """
        return None

    def spacing(self, shape: Shape) -> float:
        """Return the typical angle between neighbouring pixels in radians."""
        return float(np.sqrt(4 * np.pi / np.count_nonzero(self.solid_angles(shape))))


def bilinear(picture: Floats, row: NDArray[np.float64], column: NDArray[np.float64]) -> Floats:
    """Return a picture's values at real-valued rows and columns; the borders repeat."""
    planes = picture[..., None] if picture.ndim == 2 else picture
    values = [
        ndimage.map_coordinates(planes[..., colour], [row, column], order=1, mode="nearest", prefilter=False)
        for colour in range(planes.shape[-1])
    ]
    return np.stack(values, axis=-1) if picture.ndim == 3 else np.asarray(values[0])


def check_image(radiance: Floats) -> None:
    """Raise HarmonicFaceError unless an array is a picture of rows and columns."""
    if radiance.ndim not in (2, 3) or radiance.shape[2:] not in ((), (3,)) or radiance.size == 0:
        expected = "an image of shape (h, w) or (h, w, 3)"
        raise HarmonicFaceError(f"radiance: expected {expected}, got {_validate.describe(radiance)}")
