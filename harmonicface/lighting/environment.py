"""Environment maps: light measured in every direction, as a picture of the whole sphere."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import count
from harmonicface.io.colour import luminance
from harmonicface.io.images import read_image
from harmonicface.lighting._clamped_cosine import sum_clamped_cosine
from harmonicface.lighting.light import Light


@dataclass(frozen=True, eq=False)
class EnvironmentMap(Light):
    """Radiance from every direction on a latitude-longitude grid.

    The top row looks up (+y), the middle column looks away from the camera (-z), the right half is to the right
    (+x); the left and right borders meet behind the camera (+z), which is what lights a face from the front.

    Parameters
    ----------
    radiance
        (h, w) or (h, w, 3) linear radiances of at least 0.

    Raises
    ------
    HarmonicFaceError
        Not an image, NaN, infinite or negative radiance.

    Examples
    --------
    >>> import numpy as np
    >>> white = EnvironmentMap(np.ones((16, 32)))
    >>> white.coefficients(order=1).round(4) + 0.0  # sqrt(4 pi), and nothing else
    array([3.5449, 0.    , 0.    , 0.    ])
    """

    radiance: Floats

    def __post_init__(self) -> None:
        radiance = _validate.image(self.radiance, "radiance")
        if radiance.min() < 0:
            raise HarmonicFaceError(f"radiance: expected at least 0, got {radiance.min():.4g}")
        object.__setattr__(self, "radiance", radiance)

    @classmethod
    def load(cls, path: str | os.PathLike[str], layout: str = "latlong") -> EnvironmentMap:
        """Read an environment map from a picture of the whole sphere.

        Parameters
        ----------
        path
            A Radiance HDR file, or any picture that the package reads.
        layout
            "latlong": twice as wide as high, as the class describes.

        Raises
        ------
        HarmonicFaceError
            Another layout, a file that is missing or damaged, a picture that is not twice as wide as high.
        """
        if layout != "latlong":
            raise HarmonicFaceError(f"layout: expected 'latlong', got {layout!r}")
        picture = read_image(path)
        height, width = picture.shape[:2]
        if width != 2 * height:
            raise HarmonicFaceError(f"{path}: expected a map twice as wide as high, got {width} x {height}")
        return cls(picture)

    @property
    def channels(self) -> int:
        return 1 if self.radiance.ndim == 2 else 3

    @property
    def directions(self) -> NDArray[np.float64]:
        """Unit direction through the centre of each pixel, (h, w, 3)."""
        height, width = self.radiance.shape[:2]
        latitude = np.pi * (0.5 - (np.arange(height) + 0.5) / height)[:, None]
        longitude = 2 * np.pi * ((np.arange(width) + 0.5) / width - 0.5)[None, :]
        across = np.cos(latitude) * np.sin(longitude)
        up = np.broadcast_to(np.sin(latitude), across.shape)
        return np.stack([across, up, -np.cos(latitude) * np.cos(longitude)], axis=-1)

    @property
    def solid_angles(self) -> NDArray[np.float64]:
        """Solid angle of each pixel, (h, w), exactly; they sum to 4 pi."""
        height, width = self.radiance.shape[:2]
        bands = -np.diff(np.cos(np.pi * np.arange(height + 1) / height))
        return np.repeat(bands[:, None] * (2 * np.pi / width), width, axis=1)

    @property
    def strengths(self) -> Floats:
        """Irradiance that each pixel gives to a surface facing it: radiance times solid angle, in double precision."""
        angles = self.solid_angles
        return self.radiance * (angles if self.channels == 1 else angles[..., None])

    def irradiance(self, normals: ArrayLike) -> Floats:
        strengths = self.strengths.reshape(-1, *self.radiance.shape[2:])
        lit = strengths.any(axis=-1) if self.channels == 3 else strengths > 0
        towards = self.directions.reshape(-1, 3)
        return sum_clamped_cosine(_validate.unit_normals(normals, "normals"), towards[lit], strengths[lit])

    def coefficients(self, order: int = 2) -> Floats:
        strengths = self.strengths
        result = np.zeros((count(order), *self.radiance.shape[2:]))
        for directions, row in zip(self.directions, strengths, strict=True):
            result += real_harmonics(directions, order) @ row
        return result

    def grey(self) -> EnvironmentMap:
        """Return the map as grey light."""
        return self if self.channels == 1 else EnvironmentMap(luminance(self.radiance))

    def __mul__(self, factor: float) -> EnvironmentMap:
        return EnvironmentMap(self.radiance * factor)
