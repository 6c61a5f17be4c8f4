"""Environment maps: light measured in every direction, as a picture of the whole sphere."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.rotation import rotate
from harmonicface.io.colour import luminance
from harmonicface.io.tone import tone_mapped
from harmonicface.lighting._clamped_cosine import sum_clamped_cosine
from harmonicface.lighting._latlong_coefficients import latlong_coefficients
from harmonicface.lighting._resampling import resampled
from harmonicface.lighting._rotation import rotation_matrix
from harmonicface.lighting.cube import cross_of_faces
from harmonicface.lighting.layouts import layout_named
from harmonicface.lighting.light import BRIGHTEST, Light, no_coefficients, require_at_most, scaled
from harmonicface.lighting.reading import read_environment

BLOCK = 1 << 14  # pixels whose harmonics are held at once


@dataclass(frozen=True, eq=False)
class EnvironmentMap(Light):
    """Radiance from every direction: a picture of the whole sphere, each pixel a small lamp at its centre.

    Parameters
    ----------
    radiance
        Linear radiances of 0 to 1e30: (h, w) or (h, w, 3); for a cube (6, n, n) or (6, n, n, 3), the faces px nx py
        ny pz nz.
    layout
        "latlong": the top row looks up (+y), the middle column away from the camera (-z), the right half to the right
        (+x). "angular": a light probe, its centre looks at -z, its rim at +z. "cube": faces as OpenGL turns them.
        "mirrorball": a photograph of a mirror ball, its centre shows the camera (+z).
    rotation
        Turns the whole light: what the picture has at w comes from rotation @ w. scipy Rotation or 3 x 3.

    Raises
    ------
    HarmonicFaceError
        A shape that is not of the layout, an unknown layout, radiance that is NaN, negative or beyond 1e30, no
        rotation.

    Examples
    --------
    >>> import numpy as np
    >>> white = EnvironmentMap(np.ones((16, 32)))
    >>> white.coefficients(order=1).round(4) + 0.0  # sqrt(4 pi), and nothing else
    array([3.5449, 0.    , 0.    , 0.    ])
    """

    radiance: Floats
    layout: str = "latlong"
    rotation: Any = None

    def __post_init__(self) -> None:
        radiance = _validate.finite(self.radiance, "radiance")
        layout_named(self.layout).check(radiance)
        if radiance.min() < 0:
            raise HarmonicFaceError(f"radiance: expected at least 0, got {radiance.min():.4g}")
        require_at_most(BRIGHTEST, radiance, "radiance")
        object.__setattr__(self, "radiance", radiance)
        object.__setattr__(self, "rotation", None if self.rotation is None else rotation_matrix(self.rotation))

    @classmethod
    def load(
        cls,
        path: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
        layout: str = "latlong",
        transfer: str | None = None,
    ) -> EnvironmentMap:
        """Read an environment map.

        Parameters
        ----------
        path
            Radiance HDR, OpenEXR, PFM, TIFF, NPY, PNG or JPEG. For a cube: a picture of its cross (4 x 3 or 3 x 4
            squares), or six files, px nx py ny pz nz, or their folder.
        layout
            "latlong" (twice as wide as high), "angular" (square), "cube" or "mirrorball" (square).
        transfer
            "srgb" or "linear"; by default what such files usually are (8-bit PNG, JPEG and TIFF: srgb).

        Raises
        ------
        HarmonicFaceError
            Another layout, a file that is missing or damaged, a face that is missing or of another size, a picture
            without the layout's proportions, NaN or negative radiance.
        """
        layout_named(layout)
        return cls(read_environment(path, layout, transfer), layout)

    @property
    def shape(self) -> tuple[int, ...]:
        """Rows and columns of the picture, or (6, rows, columns)."""
        return self.radiance.shape[: 3 if self.layout == "cube" else 2]

    @property
    def channels(self) -> int:
        return 1 if self.radiance.ndim == len(self.shape) else 3

    @property
    def directions(self) -> NDArray[np.float64]:
        """Unit direction through the centre of each pixel, (h, w, 3) or (6, n, n, 3)."""
        towards = layout_named(self.layout).directions(self.shape)
        return towards if self.rotation is None else towards @ self.rotation.T

    @property
    def solid_angles(self) -> NDArray[np.float64]:
        """Solid angle of each pixel, (h, w) or (6, n, n), exactly; they sum to 4 pi."""
        return layout_named(self.layout).solid_angles(self.shape)

    @property
    def strengths(self) -> Floats:
        """Irradiance that each pixel gives to a surface facing it: radiance times solid angle, in double precision."""
        angles = self.solid_angles
        return self.radiance * (angles if self.channels == 1 else angles[..., None])

    def lamps(self) -> tuple[NDArray[np.float64], Floats]:
        """Return directions (n, 3) and strengths (n,) or (n, 3) of the pixels that give light."""
        colours = () if self.channels == 1 else (3,)
        strengths = self.strengths.reshape(-1, *colours)
        lit = strengths.any(axis=-1) if colours else strengths > 0
        return self.directions.reshape(-1, 3)[lit], strengths[lit]

    def irradiance(self, normals: ArrayLike) -> Floats:
        unit = _validate.unit_normals(normals, "normals")
        layout = layout_named(self.layout)
        folded = layout.fold(self.strengths)
        if folded is None:
            return sum_clamped_cosine(unit, *self.lamps())
        # opposite pixels share their cosine c: max(-c, 0) = max(c, 0) - c
        halves = layout.fold(self.directions)
        assert halves is not None
        towards = halves[0].reshape(-1, 3)
        front, back = (part.reshape(len(towards), *folded[0].shape[len(self.shape) :]) for part in folded)
        both = front + back
        lit = both.reshape(len(towards), -1).any(axis=1)
        linear = unit @ np.asarray(towards.T @ back, dtype=np.float64)
        result = sum_clamped_cosine(unit, towards[lit], both[lit]) - linear
        return np.maximum(result, 0).astype(unit.dtype, copy=False)

    def coefficients(self, order: int = 2) -> Floats:
        if self.layout == "latlong":
            result = latlong_coefficients(self.radiance, order)
            return result if self.rotation is None else rotate(result, self.rotation)
        towards, strengths = self.lamps()
        result = no_coefficients(order, strengths.shape[1:])
        for start in range(0, len(towards), BLOCK):
            result += real_harmonics(towards[start : start + BLOCK], order) @ strengths[start : start + BLOCK]
        return result

    def radiance_toward(self, directions: ArrayLike) -> Floats:
        """Return the radiance from (..., 3) unit directions, bilinear between pixels: (...) or (..., 3)."""
        towards = _validate.unit_normals(directions, "directions").astype(np.float64, copy=False)
        turned = towards if self.rotation is None else towards @ self.rotation
        found = layout_named(self.layout).sample(self.radiance, turned.reshape(-1, 3))
        return found.reshape(towards.shape[:-1] + found.shape[1:])

    def converted(self, layout: str, size: int | None = None) -> EnvironmentMap:
        """Return the map redrawn in a layout (its own too), its rotation applied.

        Each pixel is the mean of bilinear samples on a grid in it that is at least twice as fine as the pixels of
        this map, weighted by solid angle: nothing small is lost or counted twice when the new map is coarser.

        Parameters
        ----------
        layout
            "latlong", "angular", "cube" or "mirrorball".
        size
            Rows of the new map, of each face of a cube; by default as many as keep the size of a pixel.

        Raises
        ------
        HarmonicFaceError
            Another layout, a size below 1 or beyond the memory.

        Examples
        --------
        >>> import numpy as np
        >>> EnvironmentMap(np.ones((16, 32))).converted("cube", 8).radiance.shape
        (6, 8, 8)
        """
        target = layout_named(layout)
        spacing = layout_named(self.layout).spacing(self.shape)
        if size is None:
            size = max(1, round(target.spacing(target.shape(64)) * 64 / spacing))
        shape = target.shape(_validate.at_least(size, 1, "size"))
        drawn = resampled(self.radiance_toward, spacing, target, shape)
        return EnvironmentMap(drawn.astype(self.radiance.dtype), layout)

    def picture(self, key: float = 0.18, white: float | None = None) -> Floats:
        """Return the map as a picture for the screen: tone-mapped display values (see `io.tone.tone_mapped`).

        A cube is shown as a wide cross, a turned map as it is after the turn.
        """
        upright = self if self.rotation is None else self.converted(self.layout, self.shape[-2])
        shown = tone_mapped(upright.radiance, key, white)
        return cross_of_faces(shown) if self.layout == "cube" else shown

    def grey(self) -> EnvironmentMap:
        """Return the map as grey light."""
        return self if self.channels == 1 else replace(self, radiance=luminance(self.radiance))

    def rotated(self, rotation: Any) -> EnvironmentMap:
        matrix = rotation_matrix(rotation)
        return replace(self, rotation=matrix if self.rotation is None else matrix @ self.rotation)

    def __mul__(self, factor: ArrayLike) -> EnvironmentMap:
        return replace(self, radiance=scaled(self.radiance, factor, self.channels == 3))
