"""The files that a person is enrolled from: a mesh, points, a saved Surface, or photographs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.colour import luminance
from harmonicface.io.images import read_image
from harmonicface.io.lights_file import read_lights_file
from harmonicface.io.meshes import ENDINGS
from harmonicface.io.point_clouds import is_point_cloud
from harmonicface.recognition.detection import FaceBox, crop_face, detect_faces
from harmonicface.surfaces.load import load_surface
from harmonicface.surfaces.surface import Surface

POINT_COLUMNS = (6, 9)  # of a table of points: positions and normals, and colours


@dataclass(frozen=True)
class MeshView:
    """How a mesh is looked at; None where the user says nothing (see `load_surface`)."""

    size: int | tuple[int, int] | None = None
    texture: Path | None = None
    flip_texture: bool = False
    rotation: Sequence[float] | None = None
    frame: Sequence[float] | None = None
    intrinsics: Sequence[float] | None = None
    distance: float | None = None


def read_surface(path: Path, view: MeshView, usual_size: int) -> Surface:
    """Load a Surface: a mesh or points in a view, of the usual size if no other is given; or a saved one, viewed."""
    return load_surface(
        path,
        usual_size if view.size is None and path.suffix.lower() != ".npz" else view.size,
        texture=view.texture,
        flip_texture=view.flip_texture,
        rotation=view.rotation,
        frame=view.frame,
        intrinsics=view.intrinsics,
        distance=view.distance,
    )


def read_source(
    paths: Sequence[Path],
    view: MeshView,
    transfer: str | None,
    usual_size: int,
    cropped: tuple[int, int] | None = None,
) -> Surface | NDArray[np.float32]:
    """Read what a person is enrolled from.

    Parameters
    ----------
    paths
        A mesh, points, a saved Surface, or photographs.
    view
        How a mesh or points are looked at.
    transfer
        What the numbers of photographs mean, see `read_image`.
    usual_size
        Height and width of what is seen of a mesh, if the view says nothing.
    cropped
        Height and width in pixels of faces that are first found in the photographs; None for photographs as they are.

    Raises
    ------
    HarmonicFaceError
        A file that cannot be read, photographs of unlike sizes, a view of photographs, a transfer of a mesh, a face to
        be found in a mesh or where there is none.
    """
    if len(paths) == 1 and _is_surface(paths[0]):
        if transfer is not None:
            raise HarmonicFaceError("transfer: expected it with photographs only, got a mesh, points or Surface")
        if cropped is not None:
            raise HarmonicFaceError("detect: expected it with photographs only, got a mesh, points or Surface")
        return read_surface(paths[0], view, usual_size)
    if view != MeshView():
        raise HarmonicFaceError("enroll: expected the options of a view with one mesh only, got photographs")
    if cropped is not None:
        return np.stack([_grey(read_face(path, transfer, cropped)[0]) for path in paths])
    photos = [read_image(path, transfer) for path in paths]
    for path, photo in zip(paths, photos, strict=True):
        if photo.shape != photos[0].shape:
            expected = f"the size of {paths[0]}, {photos[0].shape[:2]}"
            raise HarmonicFaceError(f"{path}: expected {expected}, got {photo.shape[:2]}")
    return np.stack(photos)


def read_lamps(path: Path, photographs: Sequence[Path]) -> NDArray[np.float64]:
    """Return the directions to the lamps of photographs times their intensities, (n, 3), from a lights file.

    Raises
    ------
    HarmonicFaceError
        What `read_lights_file` refuses, lines for other photographs, coefficients or colours instead of lamps.
    """
    read = read_lights_file(path).of([photo.name for photo in photographs], str(path))
    if read.directions is None or (read.intensities is not None and read.intensities.ndim > 1):
        got = "harmonic coefficients" if read.directions is None else "an intensity for each colour"
        raise HarmonicFaceError(f"{path}: expected a direction and at most one intensity a photograph, got {got}")
    return read.directions if read.intensities is None else read.directions * read.intensities[:, None]


def read_face(path: Path, transfer: str | None, size: tuple[int, int]) -> tuple[NDArray[np.float32], FaceBox]:
    """Return the clearest face of a photograph, cropped to a size, and where it is.

    Raises
    ------
    HarmonicFaceError
        A file that cannot be read, or no face in it.
    """
    photo = read_image(path, transfer)
    try:
        boxes = detect_faces(photo)
    except HarmonicFaceError as error:
        raise HarmonicFaceError(f"{path}: {error}") from None
    if not boxes:
        raise HarmonicFaceError(f"{path}: expected a face that looks at the camera, found none")
    return crop_face(photo, boxes[0], size), boxes[0]


def _is_surface(path: Path) -> bool:
    """Tell whether a file holds a shape; arrays may be photographs too, but none is as narrow as a table of points."""
    if path.suffix.lower() != ".npy":
        return path.suffix.lower() in (".npz", *ENDINGS) or is_point_cloud(path)
    try:
        table = np.lib.format.open_memmap(path, mode="r")
    except (OSError, ValueError):  # whoever reads it says what is wrong
        return False
    return table.ndim == 2 and table.shape[1] in POINT_COLUMNS


def read_mask(path: Path) -> NDArray[np.bool_]:
    """Read a mask: true where the picture is lighter than half of white."""
    return np.asarray(_grey(read_image(path, "linear")) > 0.5)


def _grey(picture: NDArray[np.float32]) -> NDArray[np.float32]:
    return picture if picture.ndim == 2 else np.asarray(luminance(picture), np.float32)
