"""Synthetic people: from a seed to a Surface, aligned as a recognizer would crop a face."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.people.complexion import Complexion, draw_complexion
from harmonicface.people.crop import FRAME, Alignment
from harmonicface.people.lattice import mean_lattice
from harmonicface.people.shape import Head, head_shape
from harmonicface.people.skin import SkinPixels, albedo
from harmonicface.people.traits import draw_head
from harmonicface.surfaces.raster import rasterize
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.view import View, checked_shape

Array = NDArray[np.float64]

MISPLACED = 0.5  # mm, standard deviation across and up of the misalignment that is left
TILTED = 0.5  # degrees, the same in the picture's plane
SMALLEST = 8  # pixels a side: fewer may miss the face
BLUR = 0.45  # of a pixel: the albedo's finest detail, so that small pictures do not alias


def synthetic_person(seed: int | np.random.Generator, size: int | tuple[int, int] = 64) -> Surface:
    """Return one person who does not exist.

    The face is a mesh in millimetres seen from the front, moved and scaled so that eyes and mouth are where everybody's
    are, but for half a millimetre and half a degree. The same seed gives the same person in any size.

    Parameters
    ----------
    seed
        An integer of at least 0, or a generator that draws the person (and is left advanced).
    size
        Height and width in pixels, at least 8; one number means a square picture.

    Returns
    -------
    Surface
        float32 normals (h, w, 3), grey linear albedo (h, w) in 0 to 1, depth in mm and its pixel size; the mask is
        the head, without the background beside cheeks and chin.

    Raises
    ------
    HarmonicFaceError
        A seed or size of another form.

    Examples
    --------
    >>> from harmonicface.people.synthetic import synthetic_person
    >>> person = synthetic_person(7, size=32)
    >>> person.shape, person.albedo.dtype.name
    ((32, 32), 'float32')
    """
    shape = _picture_shape(size)
    rng = _generator(seed)
    traits = draw_head(rng)
    complexion = draw_complexion(rng, traits.masculine, traits.age)
    head = head_shape(traits, rng)
    tilt, *shift = rng.standard_normal(3)
    alignment = Alignment.of(head.eyes, head.mouth).disturbed(np.radians(TILTED) * tilt, MISPLACED * np.array(shift))
    return portrait(head, complexion, alignment, shape)


def synthetic_people(count: int, size: int | tuple[int, int] = 64, seed: int = 0) -> Iterator[Surface]:
    """Yield people who do not exist, one after the other.

    Parameters
    ----------
    count
        How many, at least 0.
    size
        Height and width in pixels, at least 8; one number means a square picture.
    seed
        An integer of at least 0. Person i of a seed is the same however many are made.

    Yields
    ------
    Surface
        As `synthetic_person` returns them.

    Raises
    ------
    HarmonicFaceError
        A count, size or seed of another form; raised at the call.

    Examples
    --------
    >>> from harmonicface.people.synthetic import synthetic_people
    >>> [person.shape for person in synthetic_people(2, size=(48, 40))]
    [(48, 40), (48, 40)]
    """
    number = _natural(count, "count")
    shape = _picture_shape(size)
    first = _natural(seed, "seed")
    seeds = (np.random.SeedSequence(first, spawn_key=(i,)) for i in range(number))
    return (synthetic_person(np.random.default_rng(seed), shape) for seed in seeds)


def portrait(head: Head, complexion: Complexion, alignment: Alignment, shape: tuple[int, int]) -> Surface:
    """Return what the camera sees of a head after its alignment, as a Surface of (height, width) pixels."""
    lattice = mean_lattice()
    points = alignment.points(head.points.reshape(-1, 3))
    view = View.fit(points, shape, frame=FRAME)
    raster = rasterize(view.project(points), lattice.faces, shape)
    mean_places = lattice.points.reshape(-1, 3)[:, :2]
    attributes = [alignment.normals(head.normals.reshape(-1, 3)), mean_places, _gaze(head).reshape(-1, 3)]
    mask = raster.mask
    seen = raster.interpolate(np.concatenate(attributes, axis=1), lattice.faces)[mask].astype(np.float64, copy=False)
    normals, (x, y, eye_x, eye_y, on_eye) = seen[:, :3], seen[:, 3:].T
    share = np.maximum(on_eye, 1e-6)
    pixels = SkinPixels(x, y, eye_x / share, eye_y / share, on_eye > 0.5, BLUR * view.pixel_size)
    normal_map = np.zeros((*shape, 3), dtype=np.float32)
    normal_map[mask] = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    albedo_map = np.zeros(shape, dtype=np.float32)
    albedo_map[mask] = albedo(complexion, pixels)
    return Surface(normal_map, albedo_map, mask, raster.depth.astype(np.float32), view.pixel_size)


def _gaze(head: Head) -> Array:
    """Return for each point its place beside the centre of its eyeball in mm, and 1 on an eyeball, 0 elsewhere."""
    gaze = np.zeros(head.points.shape)
    for eye, centre in zip(mean_lattice().eyes, head.eyes, strict=True):
        gaze[eye, :2] = head.points[eye, :2] - centre[:2]
        gaze[eye, 2] = 1
    return gaze


def _generator(seed: int | np.random.Generator) -> np.random.Generator:
    """Return a generator, which is made from a number."""
    return seed if isinstance(seed, np.random.Generator) else np.random.default_rng(_natural(seed, "seed"))


def _picture_shape(size: int | tuple[int, int]) -> tuple[int, int]:
    """Return (height, width) of a size that is one number or two, each at least SMALLEST."""
    shape = checked_shape(size)
    if min(shape) < SMALLEST:
        raise HarmonicFaceError(f"size: expected at least {SMALLEST} pixels a side, got {size!r}")
    return shape


def _natural(value: Any, name: str) -> int:
    """Return an integer of at least 0."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < 0:
        raise HarmonicFaceError(f"{name}: expected an integer of at least 0, got {_validate.describe(value)}")
    return int(value)
