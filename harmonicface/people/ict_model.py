"""The ICT face model: a neutral head, its principal modes and its texture coordinates, read from a folder."""

from __future__ import annotations

import json
import os
import re
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

MILLIMETRES = 10.0  # the model's unit is the centimetre
VERTICES, POLYGONS, LANDMARKS, MODES = 26719, 26384, 68, 100
MODE_FILE = re.compile(r"identity(\d{3})\.obj")

# Polygons of the file, by the README of ICT-FaceKit. What is left out lies inside the head (gums, teeth, irises behind
# the shells of the eyes) or is a film before the eyes that would hide them (fluid, blend, occlusion, lashes).
FACE, BACK, LEFT_EYE, RIGHT_EYE = range(4)  # left and right of the picture
POLYGONS_OF = {FACE: (0, 9230), BACK: (9230, 14034), LEFT_EYE: (23094, 23894), RIGHT_EYE: (21496, 22296)}
EYEBALLS = (slice(23021, 23791), slice(21451, 22221))  # vertices; the picture's left one first
LIPS = (62, 66)  # landmarks: where the lips meet in the middle


@dataclass(frozen=True, eq=False)
class HeadModel:
    """The part of the model that can be seen: face, head with ears and neck, the shells of the eyes.

    Vertices are split where the texture is cut, so one vertex of the file may be several here.

    Parameters
    ----------
    neutral
        (26719, 3) mm, in the order of the file: x to the viewer's right, y up, z to the camera.
    modes
        (m, 26719, 3) float32 mm, the displacement at one standard deviation of each mode.
    numbers
        (m,) which of the model's 100 modes these are.
    source
        (n,) the vertex of the file that each vertex seen comes from.
    uv
        (n, 2) texture coordinates in 0 to 1, each part of the head on a texture of its own.
    faces
        (f, 3) indices of the n vertices seen.
    parts
        (f,) FACE, BACK, LEFT_EYE or RIGHT_EYE.
    landmarks
        (68,) vertices of the file in the order of Multi-PIE.
    """

    neutral: Array
    modes: NDArray[np.float32]
    numbers: tuple[int, ...]
    source: Integers
    uv: Array
    faces: Integers
    parts: Integers
    landmarks: Integers

    def shape(self, weights: Array) -> Array:
        """Return the vertices of a head, (26719, 3) in mm, by the weights of all 100 modes; missing modes are left out.

        `neutral + sum_i z_i (identity_i - neutral)`: each identity file is the shape at one standard deviation of a
        principal component (ICT-FaceKit, USC ICT Vision and Graphics Lab, MIT licence).
        """
        return self.neutral + np.tensordot(weights[list(self.numbers)].astype(np.float32), self.modes, 1)


def read_ict_model(folder: str | os.PathLike[str]) -> HeadModel:
    """Return the ICT face model in a folder; it is parsed once and kept until its files change.

    Parameters
    ----------
    folder
        `FaceXModel` of ICT-FaceKit, or ICT-FaceKit itself: generic_neutral_mesh.obj, vertex_indices.json and some or
        all of identity000.obj to identity099.obj.

    Raises
    ------
    HarmonicFaceError
        Files that are missing, unreadable or of another model.
    """
    try:
        place = Path(folder).resolve()
        place = place / "FaceXModel" if (place / "FaceXModel").is_dir() else place
        files = sorted(place.iterdir()) if place.is_dir() else []
        stamps = tuple((file.name, *_stamp(file)) for file in files if file.suffix in (".obj", ".json"))
    except (OSError, ValueError, TypeError) as error:  # ValueError: a null character
        raise HarmonicFaceError(
            f"expected the folder FaceXModel of ICT-FaceKit, got {folder!r:.200}: {error}"
        ) from None
    return _parsed(place, stamps)


def _stamp(file: Path) -> tuple[int, int]:
    status = file.stat()
    return status.st_mtime_ns, status.st_size


@lru_cache(maxsize=2)
def _parsed(folder: Path, stamps: tuple[tuple[str, int, int], ...]) -> HeadModel:
    """Parse the files of a folder; another stamp is another model."""
    names = {name for name, *_ in stamps}
    modes = {int(match[1]): folder / match[0] for name in sorted(names) if (match := MODE_FILE.fullmatch(name))}
    wanted = ("generic_neutral_mesh.obj", "vertex_indices.json", "identity000.obj")
    missing = [name for name in wanted[:2] if name not in names] + ([] if modes else [wanted[2]])
    if missing:
        expected = "generic_neutral_mesh.obj, vertex_indices.json and identity000.obj to identity099.obj"
        raise HarmonicFaceError(f"{folder}: expected the ICT face model ({expected}), got no {', no '.join(missing)}")
    landmarks = _landmarks(folder / wanted[1])
    lines = _lines(folder / wanted[0])
    neutral = _vertices(folder / wanted[0], lines)
    shapes = np.stack([_vertices(file, _lines(file)) for file in modes.values()])
    source, uv, faces, parts = _topology(folder / wanted[0], lines)
    return HeadModel(neutral, (shapes - neutral).astype(np.float32), tuple(modes), source, uv, faces, parts, landmarks)


def _lines(file: Path) -> list[bytes]:
    try:
        return file.read_bytes().splitlines()
    except OSError as error:
        raise HarmonicFaceError(f"cannot read {file}: {error.strerror}") from None


def _rows(file: Path, lines: list[bytes], key: bytes, columns: int) -> Array:
    """Return the numbers of the lines that begin with a key in the file's order, which the indices count on."""
    rows = [line[len(key) :] for line in lines if line.startswith(key)]
    try:
        numbers = np.loadtxt(rows, ndmin=2, encoding="latin-1") if rows else np.zeros((0, columns))
    except ValueError as error:
        raise HarmonicFaceError(f"{file}: expected numbers after {key.decode()!r}, got {error}") from None
    if numbers.shape[1] != columns or not np.isfinite(numbers).all():
        raise HarmonicFaceError(
            f"{file}: expected {columns} finite numbers after {key.decode()!r}, got {_validate.describe(numbers)}"
        )
    return numbers


def _vertices(file: Path, lines: list[bytes]) -> Array:
    vertices = _rows(file, lines, b"v ", 3)
    if len(vertices) != VERTICES:
        raise HarmonicFaceError(f"{file}: expected the {VERTICES} vertices of the ICT face model, got {len(vertices)}")
    return MILLIMETRES * vertices


def _topology(file: Path, lines: list[bytes]) -> tuple[Integers, Array, Integers, Integers]:
    """Return where the vertices seen come from, their texture coordinates, the triangles and their parts."""
    uv = _rows(file, lines, b"vt ", 2)
    polygons = [line.split()[1:] for line in lines if line.startswith(b"f ")]
    if len(polygons) != POLYGONS:
        raise HarmonicFaceError(f"{file}: expected the {POLYGONS} polygons of the ICT face model, got {len(polygons)}")
    triangles, parts = [], []
    for part, (start, stop) in POLYGONS_OF.items():
        for polygon in polygons[start:stop]:
            triangles += [(polygon[0], polygon[k], polygon[k + 1]) for k in range(1, len(polygon) - 1)]
            parts += [part] * (len(polygon) - 2)
    corners, faces = np.unique(np.array(triangles, dtype=bytes), return_inverse=True)
    try:
        pairs = np.array([corner.split(b"/")[:2] for corner in corners.tolist()], dtype=np.int64).reshape(-1, 2) - 1
        if not triangles:
            raise ValueError
    except ValueError:
        raise HarmonicFaceError(f"{file}: expected faces of vertex/texture numbers, got another form") from None
    if pairs.min() < 0 or (pairs.max(axis=0) >= (VERTICES, len(uv))).any():
        raise HarmonicFaceError(
            f"{file}: expected faces of {VERTICES} vertices and {len(uv)} texture coordinates, got numbers "
            f"{pairs.min() + 1} to {tuple(pairs.max(axis=0).tolist())}"
        )
    # the back of the head continues the face's texture to the right: each part gets a square of its own
    return pairs[:, 0], np.mod(uv[pairs[:, 1]], 1.0), faces.reshape(-1, 3), np.array(parts)


def _landmarks(file: Path) -> Integers:
    """Return the vertices at the 68 landmarks."""
    try:
        found = json.loads(file.read_text(encoding="utf-8"))["idx_to_landmark_verts"]
        landmarks = np.asarray(found)
    except OSError as error:
        raise HarmonicFaceError(f"cannot read {file}: {error.strerror}") from None
    except (ValueError, KeyError, TypeError):
        raise HarmonicFaceError(f"{file}: expected JSON with idx_to_landmark_verts, got another form") from None
    if (
        landmarks.shape != (LANDMARKS,)
        or landmarks.dtype.kind != "i"
        or not (0 <= landmarks.min() <= landmarks.max() < VERTICES)
    ):
        raise HarmonicFaceError(
            f"{file}: expected {LANDMARKS} landmarks, vertices 0 to {VERTICES - 1}, got {_validate.describe(landmarks)}"
        )
    return landmarks.astype(np.int64)
