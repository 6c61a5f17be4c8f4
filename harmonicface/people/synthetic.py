"""Synthetic people: from a seed to a Surface, aligned as a recognizer would crop a face."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.people.anatomy import EYE, MOUTH
from harmonicface.people.complexion import Complexion, draw_complexion
from harmonicface.people.lattice import mean_lattice
from harmonicface.people.shape import Head, head_shape
from harmonicface.people.skin import SkinPixels, albedo
from harmonicface.people.traits import draw_head
from harmonicface.surfaces.raster import rasterize
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.view import View, checked_shape

Array = NDArray[np.float64]

FRAME = (-63.0, -110.0, 63.0, 34.0)  # mm: left, bottom, right, top; eyes at y = -0.9, mouth at y = -69.6
MISPLACED = 0.5  # mm, standard deviation of the misalignment that is left
TILTED = 0.5  # degrees, the same


def synthetic_person(seed: int | np.random.Generator, size: int | tuple[int, int] = 64) -> Surface:
    """Return one person who does not exist.

    The face is a mesh of millimetres seen from the front, moved and scaled so that eyes and mouth are where everybody's
    are, but for half a millimetre and half a degree. The same seed gives the same person in any size.

    Parameters
    ----------
    seed
        An integer of at least 0, or a generator that draws the person (and is left advanced).
    size
        Height and width in pixels; one number means a square picture.

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
    shape = checked_shape(size)
    rng = _generator(seed)
    traits = draw_head(rng)
    complexion = draw_complexion(rng, traits.masculine, traits.age)
    head = head_shape(traits, rng)
    scale, rotation, shift = _alignment(head)
    rotation = rotation @ _turn(np.radians(TILTED) * rng.standard_normal())
    shift = shift + MISPLACED * rng.standard_normal(2)
    return _photograph(head, complexion, scale, rotation, shift, shape)


def synthetic_people(count: int, size: int | tuple[int, int] = 64, seed: int = 0) -> Iterator[Surface]:
    """Yield people who do not exist, one after the other.

    Parameters
    ----------
    count
        How many, at least 0.
    size
        Height and width in pixels; one number means a square picture.
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
    shape = checked_shape(size)
    first = _natural(seed, "seed")
    return (synthetic_person(np.random.default_rng([first, i]), shape) for i in range(number))


def _generator(seed: int | np.random.Generator) -> np.random.Generator:
    """Return a generator; a number is the first of its people's seeds."""
    return seed if isinstance(seed, np.random.Generator) else np.random.default_rng(_natural(seed, "seed"))


def _natural(value: Any, name: str) -> int:
    """Return an integer of at least 0."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < 0:
        raise HarmonicFaceError(f"{name}: expected an integer of at least 0, got {_validate.describe(value)}")
    return int(value)


def _turn(angle: float) -> Array:
    """Return the matrix of a rotation in the picture's plane."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def _alignment(head: Head) -> tuple[float, Array, Array]:
    """Return scale, rotation and shift that bring eyes and mouth to the mean's, by least squares (Umeyama 1991)."""
    found = np.array([head.eyes[0, :2], head.eyes[1, :2], head.mouth[:2]])
    wanted = np.array([EYE[:2] * (-1, 1), EYE[:2], MOUTH[:2]])
    middle, target = found.mean(axis=0), wanted.mean(axis=0)
    a, b = (found - middle) @ (1, 1j), (wanted - target) @ (1, 1j)
    motion = np.vdot(a, b) / np.vdot(a, a).real
    rotation = _turn(float(np.angle(motion)))
    return float(np.abs(motion)), rotation, target - np.abs(motion) * rotation @ middle


def _photograph(
    head: Head, complexion: Complexion, scale: float, rotation: Array, shift: Array, shape: tuple[int, int]
) -> Surface:
    """Return what the camera sees of a head after its alignment."""
    lattice = mean_lattice()
    turn = np.eye(3)
    turn[:2, :2] = rotation
    points = scale * head.points.reshape(-1, 3) @ turn.T
    points[:, :2] += shift
    view = View.fit(points, shape, frame=FRAME)
    raster = rasterize(view.project(points), lattice.faces, shape)
    beside = np.zeros((*lattice.shape, 3))
    for eye, centre in zip(lattice.eyes, head.eyes, strict=True):
        beside[eye, :2] = head.points[eye, :2] - centre[:2]
        beside[eye, 2] = 1
    normals = (head.normals.reshape(-1, 3) @ turn.T).astype(np.float64)
    attributes = np.concatenate([normals, lattice.points.reshape(-1, 3)[:, :2], beside.reshape(-1, 3)], axis=1)
    mask = raster.mask
    seen: Array = raster.interpolate(attributes, lattice.faces)[mask].astype(np.float64, copy=False)
    weight = np.maximum(seen[:, 7], 1e-6)
    pixels = SkinPixels(
        seen[:, 3], seen[:, 4], seen[:, 5] / weight, seen[:, 6] / weight, seen[:, 7] > 0.5, 0.45 * view.pixel_size
    )
    normal_map = np.zeros((*shape, 3), dtype=np.float32)
    normal_map[mask] = seen[:, :3] / np.linalg.norm(seen[:, :3], axis=1, keepdims=True)
    albedo_map = np.zeros(shape, dtype=np.float32)
    albedo_map[mask] = albedo(complexion, pixels)
    return Surface(normal_map, albedo_map, mask, raster.depth.astype(np.float32), view.pixel_size)
