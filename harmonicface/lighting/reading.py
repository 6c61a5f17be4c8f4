"""Reading environment maps: one picture, or the six faces of a cube."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.images import read_image
from harmonicface.io.pixels import ENDINGS
from harmonicface.lighting.cube import FACES, faces_of_cross

Path_ = str | os.PathLike[str]


def read_environment(path: Path_ | Sequence[Path_], layout: str, transfer: str | None = None) -> Floats:
    """Return the radiances of a map, linear float32: (h, w[, 3]), or (6, n, n[, 3]) for a cube.

    Parameters
    ----------
    path
        A picture; for a cube its cross, a folder of px nx py ny pz nz, or six paths in that order.
    layout
        "latlong", "angular", "cube" or "mirrorball".
    transfer
        "srgb" or "linear"; by default what such files usually are.

    Raises
    ------
    HarmonicFaceError
        A file or face that is missing, damaged or of another size, a picture without the layout's proportions.
    """
    if isinstance(path, (str, os.PathLike)):
        one = Path(path)
        if layout == "cube" and one.is_dir():
            return _faces(_face_files(one), transfer)
    elif layout == "cube" and isinstance(path, Sequence):
        return _faces([Path(face) for face in path], transfer)
    else:
        raise HarmonicFaceError(f"path: expected a file of the layout {layout!r}, got {type(path).__name__}")
    picture = read_image(one, transfer)
    try:
        return faces_of_cross(picture) if layout == "cube" else _of_proportions(picture, layout)
    except HarmonicFaceError as error:
        raise HarmonicFaceError(f"{one}: {error}") from None


def _of_proportions(picture: Floats, layout: str) -> Floats:
    height, width = picture.shape[:2]
    if layout == "latlong" and width != 2 * height:
        raise HarmonicFaceError(f"expected a map twice as wide as high, got {width} x {height}")
    if layout != "latlong" and width != height:
        raise HarmonicFaceError(f"expected a square map ({layout}), got {width} x {height}")
    return picture


def _face_files(folder: Path) -> list[Path]:
    """Return the six pictures of a folder that are named after faces."""
    found: dict[str, list[Path]] = {face: [] for face in FACES}
    for file in sorted(folder.iterdir()):
        if file.stem.lower() in found and file.suffix.lower() in ENDINGS:
            found[file.stem.lower()].append(file)
    missing = [face for face in FACES if not found[face]]
    if missing:
        raise HarmonicFaceError(f"{folder}: expected the faces {' '.join(FACES)}, got none named {' '.join(missing)}")
    twice = [face for face in FACES if len(found[face]) > 1]
    if twice:
        raise HarmonicFaceError(f"{folder}: expected one file a face, got several for {' '.join(twice)}")
    return [found[face][0] for face in FACES]


def _faces(files: Sequence[Path], transfer: str | None) -> Floats:
    """Read six squares of one size."""
    if len(files) != 6:
        raise HarmonicFaceError(f"path: expected six faces, {' '.join(FACES)}, got {len(files)}")
    faces = [read_image(file, transfer) for file in files]
    for file, face in zip(files, faces, strict=True):
        height, width = face.shape[:2]
        if width != height:
            raise HarmonicFaceError(f"{file}: expected a square face, got {width} x {height}")
        if face.shape != faces[0].shape:
            raise HarmonicFaceError(f"{file}: expected the shape of {files[0]}, {faces[0].shape}, got {face.shape}")
    return np.stack(faces)
