"""How each trait moves the points of the mean face: smooth displacement fields for one millimetre of the trait."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface.people.anatomy import Relief
from harmonicface.people.lattice import Lattice

Array = NDArray[np.float64]
Field = Callable[["Places"], Array]


@dataclass(frozen=True, eq=False)
class Places:
    """Where the points of the mean face are, in millimetres, and how the lids carry them."""

    x: Array
    y: Array
    upper_lid: Array
    lower_lid: Array

    @classmethod
    def of(cls, lattice: Lattice) -> Places:
        """Return the places of a lattice's points."""
        return cls(lattice.points[..., 0], lattice.points[..., 1], lattice.upper_lid, lattice.lower_lid)

    def near(self, x: float, y: float, wide: float, tall: float, tilt: float = 0.0) -> Array:
        """Return a bump of height 1 around a place, or around a pair of places where x is not 0."""
        return Relief("", x, y, wide, tall, tilt, 1.0)(self.x, self.y)

    def side(self, softness: float = 4.0) -> Array:
        """Return -1 on the left of the picture, 1 on the right, smooth across the midline (softness in mm)."""
        return np.tanh(self.x / softness)

    def lateral(self, start: float, end: float) -> Array:
        """Return 0 at the midline rising smoothly to 1 between two distances from it."""
        return rise(np.abs(self.x), start, end)

    def vertical(self, start: float, end: float) -> Array:
        """Return 0 rising smoothly to 1 between two heights."""
        return rise(self.y, start, end)


def rise(value: Array, start: float, end: float) -> Array:
    """Return the smooth step from 0 at `start` to 1 at `end`, 3 t^2 - 2 t^3; `end` may be the smaller one."""
    t = np.clip((value - start) / (end - start), 0, 1)
    return np.asarray(t * t * (3 - 2 * t))


def outward(weight: Callable[[Places], Array]) -> Field:
    """Return a field that moves points away from the midline."""
    return lambda places: _vector(x=places.side() * weight(places))


def upward(weight: Callable[[Places], Array]) -> Field:
    """Return a field that moves points up."""
    return lambda places: _vector(y=weight(places))


def forward(weight: Callable[[Places], Array]) -> Field:
    """Return a field that moves points toward the camera."""
    return lambda places: _vector(z=weight(places))


def bump(x: float, y: float, wide: float, tall: float, tilt: float = 0.0) -> Field:
    """Return a field that raises the face around a place, or a pair of places."""
    return forward(lambda places: places.near(x, y, wide, tall, tilt))


def spread(x: float, y: float, wide: float, tall: float) -> Field:
    """Return a field that widens the middle of the face around the place at (0, y), most strongly near +-x."""
    return outward(lambda places: places.near(x, y, wide, tall))


def both(*fields: tuple[float, Field]) -> Field:
    """Return the sum of fields, each times a factor."""

    def total(places: Places) -> Array:
        return np.asarray(sum(factor * field(places) for factor, field in fields))

    return total


def grown(x: float, y: float, reach: float) -> Field:
    """Return a field that enlarges what lies around a pair of places, 1 mm at `reach` mm from its centre."""

    def field(places: Places) -> Array:
        weight = places.near(x, y, reach, reach) / reach
        across = np.abs(places.x) - x
        return _vector(x=np.sign(places.x) * across * weight, y=(places.y - y) * weight)

    return field


def slanted(x: float, y: float, wide: float, tall: float) -> Field:
    """Return a field that lifts the outer half of a pair of places and lowers the inner half, 1 mm at `wide`."""

    def field(places: Places) -> Array:
        return _vector(y=places.near(x, y, wide, tall) * np.clip((np.abs(places.x) - x) / wide, -1.5, 1.5))

    return field


def _vector(x: Array | None = None, y: Array | None = None, z: Array | None = None) -> Array:
    """Return displacements (..., 3) from those of their components that are not 0."""
    shape = next(part.shape for part in (x, y, z) if part is not None)
    result = np.zeros((*shape, 3))
    for axis, part in enumerate((x, y, z)):
        if part is not None:
            result[..., axis] = part
    return result
