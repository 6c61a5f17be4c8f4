"""The shape of a person's head: the mean face, moved by traits and by individual unevenness, the eyeballs set in."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from harmonicface.people.anatomy import EYE, EYEBALL_RADIUS, MOUTH, lid_margins, outline
from harmonicface.people.fields import Places
from harmonicface.people.lattice import LID_THICKNESS, Lattice, lattice_normals, mean_lattice
from harmonicface.people.traits import TRAITS, HeadTraits

Array = NDArray[np.float64]

# (distance between bumps in mm, standard deviation of each in mm): unevenness that no trait names
UNEVENNESS = ((24.0, 0.5), (11.0, 0.2), (5.0, 0.05))
RIM = 0.03  # smallest z of a normal
SYMMETRIC_SHARE = 0.8  # of the variance of the unevenness, the same on both sides


@dataclass(frozen=True, eq=False)
class Head:
    """A person's head in three dimensions.

    Parameters
    ----------
    points
        (rows, columns, 3) mm, a grid like the mean's.
    normals
        (rows, columns, 3) unit vectors.
    eyes
        (2, 3) mm, the centres of the eyeballs, the picture's left one first.
    mouth
        (3,) mm, the middle of the mouth line.
    """

    points: Array
    normals: Array
    eyes: Array
    mouth: Array


def head_shape(traits: HeadTraits, rng: np.random.Generator) -> Head:
    """Return the head of a person; the generator draws the unevenness that traits do not describe."""
    lattice = mean_lattice()
    both = np.concatenate([traits.values, traits.asymmetry]).astype(np.float32)
    points = lattice.points + (both @ _trait_fields()).reshape(lattice.points.shape)
    points += _unevenness(rng)[..., None] * _mean_normals()
    return _with_eyeballs(points, lattice)


def mean_head() -> Head:
    """Return the head of which all others are variations."""
    lattice = mean_lattice()
    return _with_eyeballs(lattice.points.copy(), lattice)


@cache
def _trait_fields() -> NDArray[np.float32]:
    """Return the displacement of all points for 1 mm of each trait, then for 1 mm of its asymmetry, flattened."""
    places = Places.of(mean_lattice())
    fields = np.stack([trait.field(places) for trait in TRAITS])
    both = np.concatenate([fields, fields * places.side(8.0)[..., None]])
    return both.reshape(len(both), -1).astype(np.float32)


@cache
def _mean_normals() -> Array:
    return lattice_normals(mean_lattice().points)


@cache
def _bumps() -> tuple[tuple[float, Array, Array], ...]:
    """Return for each scale of unevenness its strength and the bumps' profiles over rows and over columns."""
    points = mean_lattice().points
    heights = points[:, points.shape[1] // 2, 1]
    lateral = points[np.abs(heights).argmin(), :, 0]
    scales = []
    for distance, strength in UNEVENNESS:
        centres_y = np.arange(-120, 66, distance)
        half = np.arange(0.5, 82 / distance) * distance
        centres_x = np.concatenate([-half[::-1], half])
        rows, columns = (
            np.exp(-0.5 * ((place[:, None] - centres) / (0.7 * distance)) ** 2)
            for place, centres in ((heights, centres_y), (lateral, centres_x))
        )
        rows *= np.clip(outline(heights) / 55, 0, 1)[:, None] ** 2  # columns gather at the chin: no creases there
        scales.append((strength, rows, np.ascontiguousarray(columns.T)))
    return tuple(scales)


def _unevenness(rng: np.random.Generator) -> Array:
    """Draw a smooth random height for every point, mostly the same on both sides of the face."""
    total = np.zeros(mean_lattice().shape)
    for strength, rows, columns in _bumps():
        symmetric, free = rng.standard_normal((2, rows.shape[1], columns.shape[0]))
        mirrored = (symmetric + symmetric[:, ::-1]) * np.sqrt(SYMMETRIC_SHARE / 2)
        total += strength * (rows @ (mirrored + np.sqrt(1 - SYMMETRIC_SHARE) * free) @ columns)
    return total


def _with_eyeballs(points: Array, lattice: Lattice) -> Head:
    """Return the head after the skin of the closed eyes gave way to eyeballs that sit where the lids are."""
    centres = []
    placed = []
    for side, eye, margin in zip((-1.0, 1.0), lattice.eyes, lattice.margins, strict=True):
        mean_centre = EYE * (side, 1, 1)
        centre = mean_centre + (points[margin] - lattice.points[margin]).mean(axis=0)
        seen = points[eye]
        beside = ((seen[:, :2] - centre[:2]) ** 2).sum(axis=1)
        ball = centre[2] + np.sqrt(np.maximum(EYEBALL_RADIUS**2 - beside, 0))
        _, upper, lower = lid_margins(lattice.points[eye][:, 0])
        recess = LID_THICKNESS * np.clip((upper - lower) / 4, 0, 1)  # none in the corners, where the lids meet
        seen[:, 2] = np.clip(ball, seen[:, 2] - 3 * recess, seen[:, 2] - recess / 3)
        centres.append(centre)
        placed.append(seen)
    for eye, seen in zip(lattice.eyes, placed, strict=True):
        points[eye] = seen
    normals = lattice_normals(points)
    # a nose wing may fold over its groove: what is seen there turns away from the camera no further than its rim
    folded = normals[..., 2] < RIM
    turned = np.maximum(normals[folded], (-1, -1, RIM))
    normals[folded] = turned / np.linalg.norm(turned, axis=-1, keepdims=True)
    for eye, seen, centre in zip(lattice.eyes, placed, centres, strict=True):
        radial = seen - centre
        normals[eye] = radial / np.linalg.norm(radial, axis=1, keepdims=True)
    row = int(np.abs(lattice.points[:, lattice.shape[1] // 2, 1] - MOUTH[1]).argmin())
    return Head(points, normals, np.array(centres), points[row, lattice.shape[1] // 2].copy())
