"""The files that a person is enrolled from: a mesh, a saved Surface, or photographs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.colour import luminance
from harmonicface.io.images import read_image
from harmonicface.io.meshes import ENDINGS
from harmonicface.surfaces.load import load_surface
from harmonicface.surfaces.surface import Surface


@dataclass(frozen=True)
class MeshView:
    """How a mesh is looked at; None where the user says nothing (see `load_surface`)."""

    size: int | tuple[int, int] | None = None
    texture: Path | None = None
    flip_texture: bool = False
    rotation: Sequence[float] | None = None
    frame: Sequence[float] | None = None


def read_surface(path: Path, view: MeshView, usual_size: int) -> Surface:
    """Load a Surface: a mesh in a view, of the usual size if no other is given; or a saved one, viewed already."""
    return load_surface(
        path,
        usual_size if view.size is None and path.suffix.lower() != ".npz" else view.size,
        texture=view.texture,
        flip_texture=view.flip_texture,
        rotation=view.rotation,
        frame=view.frame,
    )


def read_source(
    paths: Sequence[Path], view: MeshView, transfer: str | None, usual_size: int
) -> Surface | NDArray[np.float32]:
    """Read what a person is enrolled from.

    Raises
    ------
    HarmonicFaceError
        A file that cannot be read, photographs of unlike sizes, a view of photographs, a transfer of a mesh.
    """
    if len(paths) == 1 and paths[0].suffix.lower() in (".npz", *ENDINGS):
        if transfer is not None:
            raise HarmonicFaceError("transfer: expected it with photographs only, got a mesh or Surface")
        return read_surface(paths[0], view, usual_size)
    if view != MeshView():
        raise HarmonicFaceError("enroll: expected the options of a view with one mesh only, got photographs")
    photos = [read_image(path, transfer) for path in paths]
    for path, photo in zip(paths, photos, strict=True):
        if photo.shape != photos[0].shape:
            expected = f"the size of {paths[0]}, {photos[0].shape[:2]}"
            raise HarmonicFaceError(f"{path}: expected {expected}, got {photo.shape[:2]}")
    return np.stack(photos)


def read_mask(path: Path) -> NDArray[np.bool_]:
    """Read a mask: true where the picture is lighter than half of white."""
    picture = read_image(path, "linear")
    return np.asarray((picture if picture.ndim == 2 else luminance(picture)) > 0.5)
