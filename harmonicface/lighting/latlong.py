"""The latitude-longitude layout: rows are latitudes, columns are longitudes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.lighting.layout import Layout, Shape, bilinear, check_image


class LatLongLayout(Layout):
    """The top row looks up (+y), the middle column away from the camera (-z), the right half to the right (+x).

    The left and right borders meet behind the camera (+z), which is what lights a face from the front. Maps are
    usually twice as wide as high; any shape is the whole sphere.
    """

    name = "latlong"

    def shape(self, size: int) -> Shape:
        return size, 2 * size

    def check(self, radiance: Floats) -> None:
        check_image(radiance)

    def _directions(self, shape: Shape, across: float, down: float) -> NDArray[np.float64]:
        height, width = shape
        latitude = np.pi * (0.5 - (np.arange(height) + down) / height)[:, None]
        longitude = 2 * np.pi * ((np.arange(width) + across) / width - 0.5)[None, :]
        right = np.cos(latitude) * np.sin(longitude)
        up = np.broadcast_to(np.sin(latitude), right.shape)
        return np.stack([right, up, -np.cos(latitude) * np.cos(longitude)], axis=-1)

    def area_element(self, shape: Shape, across: float = 0.5, down: float = 0.5) -> NDArray[np.float64]:
        height = shape[0]
        return np.broadcast_to(np.sin(np.pi * (np.arange(height) + down) / height)[:, None], shape)

    def solid_angles(self, shape: Shape) -> NDArray[np.float64]:
        """Return the areas of the spherical quadrangles: 2 pi / columns times the difference of sines."""
        height, width = shape
        return np.repeat(row_angles(height, width)[:, None], width, axis=1)

    def fold(self, values: Floats) -> tuple[Floats, Floats] | None:
        height, width = values.shape[:2]
        if height % 2 or width % 2:
            return None
        return values[: height // 2], np.roll(values[: height // 2 - 1 : -1], width // 2, axis=1)

    def sample(self, radiance: Floats, directions: NDArray[np.float64]) -> Floats:
        height, width = radiance.shape[:2]
        x, y, z = np.moveaxis(directions, -1, 0)
        row = (0.5 - np.arctan2(y, np.hypot(x, z)) / np.pi) * height - 0.5
        column = (np.arctan2(x, -z) / (2 * np.pi) + 0.5) * width - 0.5
        return bilinear(_wrapped(radiance), row + 1, column + 1)


def row_angles(height: int, width: int) -> NDArray[np.float64]:
    """Return the solid angle of a pixel in each row, exactly: their sum over all pixels is 4 pi."""
    edges = np.pi * np.arange(height + 1) / height
    middle, half = (edges[1:] + edges[:-1]) / 2, np.pi / (2 * height)
    return np.asarray(2 * np.sin(middle) * np.sin(half) * (2 * np.pi / width))  # no difference of cosines near a pole


def _wrapped(radiance: Floats) -> Floats:
    """Add a pixel at each border: what lies beyond it on the sphere."""
    columns = np.arange(radiance.shape[1])
    beyond = (columns + radiance.shape[1] // 2) % radiance.shape[1]  # over a pole one comes down on the other side
    rows = np.concatenate([radiance[:1, beyond], radiance, radiance[-1:, beyond]])
    return np.concatenate([rows[:, -1:], rows, rows[:, :1]], axis=1)
