"""People of the ICT face model: realistic heads with random skin, aligned like the synthetic ones."""

from __future__ import annotations

import os
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.meshes import Mesh
from harmonicface.io.vertex_normals import vertex_normals
from harmonicface.people.crop import FRAME
from harmonicface.people.ict_albedo import draw_head_skin, head_textures
from harmonicface.people.ict_atlas import texture_side
from harmonicface.people.ict_model import MODES, HeadModel, read_ict_model
from harmonicface.people.ict_places import aligned
from harmonicface.surfaces.mesh import surface_from_mesh
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.view import checked_shape

UNIFORM = 0.5
NO_TEXTURES: tuple[NDArray[np.float32], ...] = ()
ALBEDOS = ("colour", "grey", "uniform")


def ict_person(
    folder: str | os.PathLike[str],
    index: int,
    size: int | tuple[int, int] = 64,
    *,
    seed: int = 0,
    rotation: Sequence[float] = (0.0, 0.0, 0.0),
    albedo: str = "colour",
) -> Surface:
    """Return one person who does not exist, with a head of the ICT face model.

    Her shape is `neutral + sum_i z_i (identity_i - neutral)` with z_i standard normal, moved and scaled so that eyes
    and mouth are where everybody's are. Her complexion, brows, lips, eyes, hair and marks are drawn like those of
    `synthetic_person`, but do not depend on the shape: the model does not say whose head is a man's.

    Parameters
    ----------
    folder
        `FaceXModel` of ICT-FaceKit, with some or all of its 100 modes. More modes make the same person more exact.
    index
        Which person of the seed, at least 0.
    size
        Height and width in pixels; one number means a square picture.
    seed
        An integer of at least 0. Seed and index give the same person in any size, rotation and albedo.
    rotation
        (yaw, pitch, roll) in degrees about the middle between the eyes, see `rotation_matrix`.
    albedo
        "colour" is (h, w, 3), "grey" its luminance (h, w), "uniform" 0.5 everywhere, (h, w): shape alone.

    Returns
    -------
    Surface
        float32 normals, linear albedo and depth in mm; the `scene` is her whole head, in mm, with ears and neck.

    Raises
    ------
    HarmonicFaceError
        Files that are missing, unreadable or of another model; a number, size or albedo of another form.
    """
    number = _validate.at_least(index, 0, "index")
    mesh = _head(read_ict_model(folder), number, _validate.at_least(seed, 0, "seed"), checked_shape(size), albedo)
    return surface_from_mesh(mesh, size, rotation=rotation, frame=FRAME)


def ict_people(
    folder: str | os.PathLike[str],
    count: int,
    size: int | tuple[int, int] = 64,
    seed: int = 0,
    *,
    albedo: str = "colour",
) -> list[Surface]:
    """Return people who do not exist, with heads of the ICT face model, seen from the front.

    Parameters
    ----------
    folder, size, seed, albedo
        As of `ict_person`.
    count
        How many, at least 0: persons 0, 1, 2 ... of the seed, the same however many are made.

    Raises
    ------
    HarmonicFaceError
        Files that are missing, unreadable or of another model; a number, size or albedo of another form.
    """
    number = _validate.at_least(count, 0, "count")
    read_ict_model(folder)  # nobody is made of a model that cannot be read, not even no people
    return [ict_person(folder, index, size, seed=seed, albedo=albedo) for index in range(number)]


def _head(model: HeadModel, index: int, seed: int, shape: tuple[int, int], albedo: str) -> Mesh:
    """Return the head of a person in mm, her eyes and mouth where everybody's are."""
    if albedo not in ALBEDOS:
        raise HarmonicFaceError(f"albedo: expected one of {', '.join(ALBEDOS)}, got {_validate.describe(albedo)}")
    shape_seed, skin_seed = np.random.SeedSequence(seed, spawn_key=(index,)).spawn(2)
    weights = np.random.default_rng(shape_seed).standard_normal(MODES)
    points = aligned(model, model.shape(weights))[model.source]
    if albedo == "uniform":
        textures, tint, wears = NO_TEXTURES, UNIFORM, np.full(len(model.faces), -1)
    else:
        pixel_size = min((FRAME[2] - FRAME[0]) / shape[1], (FRAME[3] - FRAME[1]) / shape[0])
        skin = draw_head_skin(np.random.default_rng(skin_seed))
        textures = head_textures(model, skin, texture_side(pixel_size), colour=albedo == "colour")
        tint, wears = 1.0, model.parts
    normals = vertex_normals(points, model.faces)
    return Mesh(points, model.faces, normals, model.uv, textures, wears, np.broadcast_to(tint, points.shape))
