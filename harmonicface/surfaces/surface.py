"""Surface: the geometry and albedo that a camera sees, one normal a pixel."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.colour import luminance
from harmonicface.io.files import replacing
from harmonicface.surfaces._archive import read_archive
from harmonicface.surfaces.transport import Transport

if TYPE_CHECKING:
    from harmonicface.surfaces.scene import Scene

ARRAYS = {"normals", "albedo", "mask", "depth", "pixel_size"}  # of a saved Surface; depth may be missing
TRANSPORT = re.compile(r"transport_(\d+)")  # of so many bounces


@dataclass(frozen=True, eq=False, init=False)
class Surface:
    """Normals and albedo of what a camera sees, on a pixel grid.

    Parameters
    ----------
    normals
        (h, w, 3) unit vectors inside the mask: x right, y up, z toward the camera. Outside they become 0.
    albedo
        (h, w) or (h, w, 3) linear reflectances of at least 0 inside the mask. Outside they become 0.
    mask
        (h, w) booleans, true where there is a surface. By default every pixel whose normal is not the zero vector.
    depth
        (h, w) heights in world units, larger nearer the camera; outside the mask they become NaN. Optional.
    pixel_size
        World units a pixel.
    scene
        The mesh that it was seen from, which casts shadows from beyond the picture too; it is not saved. Without one,
        what casts shadows is the depth.
    transports
        What is known of the way of light to the pixels, by bounces. Functions that compute a `Transport` add the
        highest order so far here, and `save` keeps it.

    Raises
    ------
    HarmonicFaceError
        A shape that does not fit, NaN inside the mask, normals that are not unit vectors, negative albedo, an
        empty mask.

    Examples
    --------
    >>> wall = Surface(normals=np.tile([0.0, 0.0, 1.0], (4, 5, 1)), albedo=np.full((4, 5), 0.7))
    >>> wall.shape, int(wall.mask.sum())
    ((4, 5), 20)
    """

    normals: Floats
    albedo: Floats
    mask: NDArray[np.bool_]
    depth: Floats | None
    pixel_size: float
    scene: Scene | None
    transports: dict[int, Transport]

    def __init__(
        self,
        normals: ArrayLike,
        albedo: ArrayLike,
        mask: ArrayLike | None = None,
        depth: ArrayLike | None = None,
        pixel_size: float = 1.0,
        *,
        scene: Scene | None = None,
        transports: Iterable[Transport] = (),
    ) -> None:
        normals = _validate.floats(normals, "normals")
        if normals.ndim != 3 or normals.shape[2] != 3 or normals.size == 0:
            got = _validate.describe(normals)
            raise HarmonicFaceError(f"normals: expected an array of shape (h, w, 3), got {got}")
        shape = normals.shape[:2]
        inside = _validate.mask(normals.any(axis=2) if mask is None else mask, "mask", shape)
        albedo = _validate.floats(albedo, "albedo")
        if albedo.shape not in (shape, (*shape, 3)):
            raise HarmonicFaceError(f"albedo: expected shape {shape} or {(*shape, 3)}, got {albedo.shape}")
        _validate.unit_normals(normals[inside], "normals")
        if _validate.finite(albedo[inside], "albedo").min() < 0:
            raise HarmonicFaceError(f"albedo: expected at least 0 in the mask, got {albedo[inside].min():.4g}")
        object.__setattr__(self, "normals", _outside(normals, inside, 0.0))
        object.__setattr__(self, "albedo", _outside(albedo, inside, 0.0))
        object.__setattr__(self, "mask", inside.copy())
        object.__setattr__(self, "depth", None if depth is None else _checked_depth(depth, inside))
        object.__setattr__(self, "pixel_size", _validate.positive(pixel_size, "pixel_size"))
        object.__setattr__(self, "scene", scene)
        object.__setattr__(self, "transports", {known.bounces: known for known in transports})
        for known in self.transports.values():
            if known.values.shape[1] != inside.sum():
                raise HarmonicFaceError(
                    f"transport: expected {inside.sum()} pixels as in the mask, got {known.values.shape[1]}"
                )

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width in pixels."""
        return self.mask.shape[0], self.mask.shape[1]

    @property
    def pixel_normals(self) -> Floats:
        """Normals of the masked pixels in row-major order, (p, 3)."""
        return self.normals[self.mask]

    @property
    def pixel_albedo(self) -> Floats:
        """Albedo of the masked pixels in row-major order, (p,) or (p, 3)."""
        return self.albedo[self.mask]

    @property
    def grey_albedo(self) -> Floats:
        """Albedo of the masked pixels as luminance, (p,): what a grey photograph records of a colour surface."""
        albedo = self.pixel_albedo
        return albedo if albedo.ndim == 1 else luminance(albedo)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the Surface and its transports to an .npz file, bit for bit; the file is replaced whole or not at all.

        The scene stays behind: what is to be kept of its shadows has to be in the transports, so compute them before
        (`transport`). All other shadows of what is loaded come from its depth, which knows nothing of what the picture
        does not show.

        Raises
        ------
        HarmonicFaceError
            The name does not end in .npz, or the file cannot be written.
        """
        if Path(path).suffix != ".npz":
            raise HarmonicFaceError(f"expected a file name that ends in .npz, got {Path(path).name}")
        arrays = {"normals": self.normals, "albedo": self.albedo, "mask": self.mask}
        if self.depth is not None:
            arrays["depth"] = self.depth
        arrays |= {f"transport_{bounces}": known.values for bounces, known in self.transports.items()}
        with replacing(path) as temporary:
            np.savez(temporary, **arrays, pixel_size=np.float64(self.pixel_size))  # type: ignore[arg-type]

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Surface:
        """Read what `save` wrote.

        Raises
        ------
        HarmonicFaceError
            The file is missing, cut short, or not a saved Surface.
        """
        found = read_archive(Path(path))
        bounces = {name: int(match[1]) for name in found if (match := TRANSPORT.fullmatch(name))}
        missing, unknown = ARRAYS - {"depth"} - set(found), set(found) - ARRAYS - set(bounces)
        if missing or unknown:
            got = f"without {sorted(missing)}" if missing else f"with {sorted(unknown)}"
            raise HarmonicFaceError(f"{path}: expected a saved Surface, got a file {got}")
        pixel_size = found["pixel_size"]
        if pixel_size.shape != ():
            raise HarmonicFaceError(f"{path}: expected one pixel_size, got {_validate.describe(pixel_size)}")
        try:
            transports = [Transport(found[name], number) for name, number in bounces.items()]
            arrays = (found["normals"], found["albedo"], found["mask"], found.get("depth"))
            return cls(*arrays, pixel_size.item(), transports=transports)
        except HarmonicFaceError as error:
            raise HarmonicFaceError(f"{path}: {error}") from None


def _outside(array: Floats, inside: NDArray[np.bool_], fill: float) -> Floats:
    """Return a contiguous copy of the array with `fill` outside the mask."""
    result = np.array(array, order="C")
    result[~inside] = fill
    return result


def _checked_depth(depth: ArrayLike, inside: NDArray[np.bool_]) -> Floats:
    array = _validate.floats(depth, "depth")
    if array.shape != inside.shape:
        raise HarmonicFaceError(f"depth: expected shape {inside.shape}, got {_validate.describe(array)}")
    _validate.finite(array[inside], "depth")
    return _outside(array, inside, np.nan)
