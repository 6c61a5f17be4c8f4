"""People of the ICT face model: real shapes without albedo, aligned like the synthetic ones."""

from __future__ import annotations

import json
import os
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.vertex_normals import vertex_normals
from harmonicface.people.crop import FRAME, Alignment
from harmonicface.surfaces.raster import rasterize
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.view import View, checked_shape

Array = NDArray[np.float64]

MILLIMETRES = 10.0  # the model's unit is the centimetre
SKIN = slice(0, 11248)  # vertices of face, head and neck
EYEBALLS = slice(21451, 24591)
SCLERAS = (slice(23021, 23791), slice(21451, 22221))  # the picture's left one first
LIPS = (62, 66)  # landmarks: where the lips meet in the middle
ALBEDO = 0.5


def ict_people(
    folder: str | os.PathLike[str], count: int, size: int | tuple[int, int] = 64, seed: int = 0
) -> list[Surface]:
    """Return random people of the ICT face model, all of the same albedo.

    A person is `neutral + sum_i z_i (identity_i - neutral)` with z_i standard normal: each identity file is the shape
    at one standard deviation of a principal component (ICT-FaceKit, USC ICT Vision and Graphics Lab, MIT licence).
    Only the components whose files are in the folder vary.

    Parameters
    ----------
    folder
        `FaceXModel` of ICT-FaceKit: generic_neutral_mesh.obj, identity000.obj and so on, vertex_indices.json.
    count
        How many, at least 0.
    size
        Height and width in pixels; one number means a square picture.
    seed
        Of the weights z.

    Raises
    ------
    HarmonicFaceError
        The files are missing or of another topology, or a size of another form.
    """
    shape = checked_shape(size)
    neutral, modes, faces, lips = _model(Path(folder))
    rng = np.random.default_rng(seed)
    return [
        _portrait(neutral + np.tensordot(rng.standard_normal(len(modes)), modes, 1), faces, lips, shape)
        for _ in range(count)
    ]


@cache
def _model(folder: Path) -> tuple[Array, Array, NDArray[np.int64], tuple[int, ...]]:
    """Return the neutral head in mm, the modes at one standard deviation, the faces seen, and vertices of the lips."""
    neutral_file = folder / "generic_neutral_mesh.obj"
    files = sorted(folder.glob("identity*.obj"))
    if not neutral_file.is_file() or not files:
        raise HarmonicFaceError(f"expected the ICT face model's neutral and identity files, got none in {folder}")
    neutral = _vertices(neutral_file)
    modes = np.stack([_vertices(file) for file in files]) - neutral
    quads = [
        [int(corner.split("/")[0]) - 1 for corner in line.split()[1:]]
        for line in neutral_file.read_text().splitlines()
        if line.startswith("f ")
    ]
    faces = np.array([(q[0], q[k], q[k + 1]) for q in quads for k in range(1, len(q) - 1)])
    lowest, highest = faces.min(axis=1), faces.max(axis=1)
    seen = (highest < SKIN.stop) | ((lowest >= EYEBALLS.start) & (highest < EYEBALLS.stop))
    landmarks = json.loads((folder / "vertex_indices.json").read_text())["idx_to_landmark_verts"]
    return neutral, modes, faces[seen], tuple(landmarks[number] for number in LIPS)


def _vertices(file: Path) -> Array:
    """Return the vertices of an OBJ file in its order, which the model's indices count on."""
    lines = [line.split()[1:4] for line in file.read_text().splitlines() if line.startswith("v ")]
    vertices = np.array(lines, dtype=np.float64).reshape(-1, 3)
    if len(vertices) < EYEBALLS.stop:
        raise HarmonicFaceError(f"{file}: expected at least {EYEBALLS.stop} vertices, got {len(vertices)}")
    return MILLIMETRES * vertices


def _sphere_centre(points: Array) -> Array:
    """Return the centre of the sphere through points, by least squares."""
    system = np.concatenate([2 * points, np.ones((len(points), 1))], axis=1)
    return np.asarray(np.linalg.lstsq(system, (points**2).sum(axis=1))[0][:3])


def _portrait(vertices: Array, faces: NDArray[np.int64], lips: tuple[int, ...], shape: tuple[int, int]) -> Surface:
    """Return what the camera sees of a head after its alignment."""
    eyes = np.stack([_sphere_centre(vertices[sclera]) for sclera in SCLERAS])
    points = Alignment.of(eyes, vertices[list(lips)].mean(axis=0)).points(vertices)
    view = View.fit(points, shape, frame=FRAME)
    raster = rasterize(view.project(points), faces, shape)
    normals = raster.interpolate(vertex_normals(points, faces), faces)
    length = np.linalg.norm(normals, axis=2, keepdims=True)
    normals = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0)
    mask = raster.mask & (length[..., 0] > 0)
    return Surface(normals.astype(np.float32), np.full(shape, ALBEDO, np.float32), mask, raster.depth, view.pixel_size)
