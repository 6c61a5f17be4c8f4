"""Random environments that light a face the way rooms and streets do."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface import _validate
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.harmonics.indexing import degrees
from harmonicface.lighting.environment import EnvironmentMap
from harmonicface.lighting.layouts import layout_named

TEXTURE_ORDER = 10


def natural(seed: int | np.random.Generator, size: int = 32) -> EnvironmentMap:
    """Make a random natural-like environment: sky and ground, clutter, and a few bright sources.

    Measured environments have a spectrum that falls about as 1 / l in amplitude, a bright upper half, and most of
    their energy in small sources such as windows, lamps and the sun (Dror, Willsky & Adelson, Statistical
    characterization of real-world illumination, 2004). So the logarithm of the radiance is a gradient from ground to
    sky plus random harmonics with that spectrum, and one to four sources of 5 to 25 degrees are added, together as
    strong as the rest or up to four times stronger.

    Parameters
    ----------
    seed
        A seed, or a generator to draw from.
    size
        Rows of the map, at least 1; it has twice as many columns. 32 give 2,048 directions.

    Returns
    -------
    EnvironmentMap
        Grey light, scaled so that the irradiance averaged over all normals is 1.

    Raises
    ------
    HarmonicFaceError
        A size below 1 or beyond the memory, a seed that is neither an integer of at least 0 nor a generator.

    Examples
    --------
    >>> natural(seed=3).radiance.shape
    (32, 64)
    """
    rng = _validate.generator(seed, "seed")
    rows = _validate.at_least(size, 1, "size")
    directions = layout_named("latlong").directions((rows, 2 * rows))
    surroundings = _surroundings(rng, directions)
    solid_angles = EnvironmentMap(surroundings).solid_angles
    sources = _sources(rng, directions)
    share = rng.uniform(1.0, 4.0) * (surroundings * solid_angles).sum() / max((sources * solid_angles).sum(), 1e-12)
    radiance = surroundings + share * sources
    return EnvironmentMap(radiance * 4 / (radiance * solid_angles).sum())  # the mean irradiance is a quarter of that


def _surroundings(rng: np.random.Generator, directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Radiance of sky, ground and clutter."""
    harmonics = real_harmonics(directions, TEXTURE_ORDER)
    spread = 0.8 / np.maximum(degrees(TEXTURE_ORDER), 1)
    spread[0] = 0.0
    clutter = np.tensordot(rng.normal(size=len(spread)) * spread, harmonics, 1)
    sky = rng.uniform(0.0, 1.5) * np.tanh(2 * directions[..., 1])
    return np.asarray(np.exp(sky + clutter))


def _sources(rng: np.random.Generator, directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Radiance of one to four soft-edged sources, most of them above the horizon."""
    total = np.zeros(directions.shape[:2])
    for _ in range(rng.integers(1, 5)):
        towards = rng.normal((0.0, 0.7, 0.0))
        towards /= np.linalg.norm(towards)
        radius = np.radians(rng.uniform(5.0, 25.0))
        angle = np.arccos(np.clip(directions @ towards, -1.0, 1.0))
        total += rng.uniform(0.3, 1.0) * np.exp(-((angle / radius) ** 2)) / radius**2
    return total
