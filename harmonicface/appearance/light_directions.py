"""Light directions: any Light as lamps to be tested one by one, or as a few hundred directions that stand for it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting._clamped_cosine import sum_clamped_cosine
from harmonicface.lighting.discs import DiscLight
from harmonicface.lighting.environment import EnvironmentMap
from harmonicface.lighting.gathering import put_together, unfolded
from harmonicface.lighting.light import HarmonicLight, Light, SumOfLights
from harmonicface.lighting.sources import AmbientLight, DirectionalLights
from harmonicface.surfaces.visible_sums import sphere_directions

Doubles = NDArray[np.float64]

RAYS = 1024  # directions for a light that is not a few lamps
SETS = 64  # different choices of them, dealt out to the pixels
MOST_LAMPS = 16  # lamps that are tested one by one from every sample
GROUPS = 2048  # lamps that stand for those of a large map where no shadow is in question
CURVE_BITS = 12


@dataclass(frozen=True, eq=False)
class Spread:
    """Light from all over the place.

    Parameters
    ----------
    directions
        (sets, r, 3) unit vectors, several choices of directions that stand for the light.
    weights
        (sets, r, c) strength that each brings, in units of its own that are the same for all; c is 1 or 3.
    irradiance
        Gives the exact irradiance without shadows of (n, 3) normals.
    """

    directions: Doubles
    weights: Doubles
    irradiance: Callable[[Floats], Floats]


def parts_of(light: Light, rays: int = RAYS) -> Iterator[DirectionalLights | Spread | HarmonicLight]:
    """Yield what a light is made of: a few lamps, light from all over the place, harmonics.

    Raises
    ------
    HarmonicFaceError
        A Light of another kind than those of the package.
    """
    if isinstance(light, SumOfLights):
        for part in light.parts:
            yield from parts_of(part, rays)
    elif isinstance(light, HarmonicLight) or (
        isinstance(light, DirectionalLights) and len(light.directions) <= MOST_LAMPS
    ):
        yield light
    elif isinstance(light, AmbientLight):
        yield _even(sphere_directions(SETS, rays), light)
    elif isinstance(light, DiscLight):
        yield _even(_disc_directions(light, rays), light)
    elif isinstance(light, DirectionalLights):
        yield _many_lamps(light.directions, light.strengths, np.ones(len(light.directions)), rays)
    elif isinstance(light, EnvironmentMap):
        colours = (-1,) if light.channels == 1 else (-1, 3)
        yield _many_lamps(
            light.directions.reshape(-1, 3), light.strengths.reshape(colours), light.solid_angles.reshape(-1), rays
        )
    else:
        raise HarmonicFaceError(f"light: expected one of the package's lights, got {type(light).__name__}")


def _even(directions: Doubles, light: Light) -> Spread:
    """Return light of the same radiance from all directions; its strength is in the exact irradiance."""
    return Spread(directions, np.ones((*directions.shape[:2], 1)), light.irradiance)


def _disc_directions(light: DiscLight, rays: int) -> Doubles:
    """Return directions evenly spread over a disc, (sets, rays, 3): turned about its centre."""
    index = np.arange(rays) + 0.5
    # 1 - cos of the angle from the centre, which keeps its digits for a disc as small as a star
    rise = 2 * np.sin(np.radians(light.radius) / 2) ** 2 * index / rays
    radius = np.sqrt(rise * (2 - rise))
    turn = 2 * np.pi * (np.arange(SETS)[:, None] / SETS + index * (np.sqrt(5) - 1) / 2)
    right, up = _beside(light.direction)
    across = np.cos(turn)[..., None] * right + np.sin(turn)[..., None] * up
    return np.asarray(radius[:, None] * across + (1 - rise)[:, None] * light.direction)


def _beside(direction: Floats) -> tuple[Doubles, Doubles]:
    """Return two unit vectors at right angles to one another and to a direction."""
    axis = np.eye(3)[np.abs(direction).argmin()]
    right = np.cross(axis, direction)
    right /= np.linalg.norm(right)
    return right, np.cross(direction, right)


def _many_lamps(directions: Floats, strengths: Floats, solid_angles: Floats, rays: int) -> Spread:
    r"""Return directions drawn from lamps along a curve through all of them, (sets, rays, 3).

    Under four measured environments (a scanned face at 128 x 128; RMS relative to 8,192 directions) 256 directions err
    by 0.6 to 1.8 %, 512 by 0.4 to 1.1 %, 1,024 by 0.2 to 0.7 %.

    The density is half by strength s and half by the root of s times the solid angle: what is bright is drawn often,
    and a sun that takes all of the energy leaves enough directions to the sky for where the sun is hidden. Drawn at
    even steps along a space-filling curve, the directions are spread evenly over the sphere as well.
    """
    total = strengths.reshape(len(strengths), -1).sum(axis=1).astype(np.float64)
    if total.max() == 0:
        return Spread(
            np.zeros((1, 1, 3)), np.zeros((1, 1, 1)), DirectionalLights(directions[:1], strengths[:1]).irradiance
        )
    lit = np.flatnonzero(total)
    lit = lit[np.argsort(_along_curve(directions[lit]))]
    share = total[lit] / total.sum()
    root = np.sqrt(share * solid_angles[lit])
    density = share / 2 + root / root.sum() / 2
    density /= density.sum()
    first = np.random.default_rng(0).permutation(SETS)[:, None] + 0.5
    steps = (np.arange(rays) + first / SETS) / rays
    cumulative = np.cumsum(density)
    drawn = np.minimum(np.searchsorted(cumulative, steps), len(lit) - 1)
    chosen = lit[drawn]
    weights = strengths.reshape(len(strengths), -1)[chosen] / total.max() / density[drawn][..., None]
    towards, merged = _merged(directions[lit], strengths[lit], cumulative)
    return Spread(directions[chosen].astype(np.float64), weights, lambda n: sum_clamped_cosine(n, towards, merged))


def _merged(directions: Floats, strengths: Floats, cumulative: Doubles) -> tuple[Floats, Floats]:
    """Return at most GROUPS lamps in place of more: one in the middle of each run of lamps along the curve.

    The irradiance from wholly above a horizon stays what it is; where the horizon cuts a run, a part of it errs.
    """
    if len(directions) <= GROUPS:
        return directions, strengths
    group = np.minimum((cumulative * GROUPS).astype(np.int64), GROUPS - 1)
    towards, merged, spread = put_together(directions, strengths, group)
    return towards, merged * (spread if merged.ndim == 1 else spread[:, None])


def _along_curve(directions: Floats) -> NDArray[np.int64]:
    """Return the places of directions along Hilbert's curve through that square."""
    side = 1 << CURVE_BITS
    x, y = (np.minimum((part * side).astype(np.int64), side - 1) for part in unfolded(directions))
    place = np.zeros(len(x), dtype=np.int64)
    step = side >> 1
    while step:
        right, up = (x & step) > 0, (y & step) > 0
        place += step * step * ((3 * right) ^ up)
        turned = ~up & right
        x, y = np.where(turned, side - 1 - x, x), np.where(turned, side - 1 - y, y)
        x, y = np.where(up, x, y), np.where(up, y, x)
        step >>= 1
    return place
