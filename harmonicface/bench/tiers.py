"""The lights under which people are asked for, from easy to hard."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface.lighting.light import Light
from harmonicface.lighting.lights import ambient, directional
from harmonicface.lighting.natural import natural
from harmonicface.lighting.sources import DirectionalLights

LAMP_DIRECTIONS = 100


@dataclass(frozen=True)
class Tier:
    """A kind of light, and how noisy the camera is.

    Parameters
    ----------
    name
        One or two words.
    about
        What the light is, in a line.
    light
        Draws a light.
    noise
        Standard deviation of the camera's noise as a fraction of full scale.
    """

    name: str
    about: str
    light: Callable[[np.random.Generator], Light]
    noise: float = 0.01


def gallery_lights() -> list[Light]:
    """Return the seven frontal lamps of the gallery's photographs, within 12 degrees of the camera."""
    around = [directional(_tilted(np.radians(12.0), angle)) for angle in np.linspace(0, 2 * np.pi, 6, endpoint=False)]
    return [directional([0.0, 0.0, 1.0]), *around]


def _lamp(least: float, most: float) -> Callable[[np.random.Generator], Light]:
    """Return what draws one lamp between two angles (degrees) to the camera, in any direction around it."""

    def draw(rng: np.random.Generator) -> Light:
        return directional(_tilted(np.radians(rng.uniform(least, most)), rng.uniform(0, 2 * np.pi)))

    return draw


def _several(rng: np.random.Generator) -> Light:
    """Return two to four broad lamps, hundreds of directions in all, and some ambient light."""
    lamps = [_broad_lamp(rng) for _ in range(rng.integers(2, 5))]
    directions = np.concatenate([lamp.directions for lamp in lamps])
    strengths = np.concatenate([lamp.strengths for lamp in lamps])
    return DirectionalLights(directions, strengths) + ambient(rng.uniform(0.05, 0.2))


def _broad_lamp(rng: np.random.Generator) -> DirectionalLights:
    """Return a disc of directions, 10 to 20 degrees in radius, up to 80 degrees from the camera."""
    centre = _tilted(np.radians(rng.uniform(0, 80)), rng.uniform(0, 2 * np.pi))
    radius = np.tan(np.radians(rng.uniform(10, 20)))
    across = np.linalg.qr(np.column_stack([centre, rng.normal(size=(3, 2))]))[0][:, 1:]
    turn = np.arange(LAMP_DIRECTIONS) * np.pi * (3 - np.sqrt(5))  # the sunflower's angle fills a disc evenly
    reach = radius * np.sqrt((np.arange(LAMP_DIRECTIONS) + 0.5) / LAMP_DIRECTIONS)
    disc = centre + (reach * np.array([np.cos(turn), np.sin(turn)])).T @ across.T
    return DirectionalLights(disc, np.full(LAMP_DIRECTIONS, rng.uniform(0.3, 1.0) / LAMP_DIRECTIONS))


def _tilted(angle: float, around: float) -> NDArray[np.float64]:
    """Return the direction at an angle to the camera's axis, turned around it."""
    return np.array([np.sin(angle) * np.cos(around), np.sin(angle) * np.sin(around), np.cos(angle)])


# The bounds of frontal, side and extreme are those between the subsets of the Yale Face Database B.
TIERS = (
    Tier("frontal", "one lamp within 25° of the camera", _lamp(0, 25)),
    Tier("side", "one lamp 25° to 77° from the camera", _lamp(25, 77)),
    Tier("several", "two to four broad lamps up to 80° and ambient light", _several),
    Tier("natural", "a random environment: sky, ground, clutter, windows", natural),
    Tier("noise", "one lamp 25° to 77°, noise of 5 % of full scale", _lamp(25, 77), noise=0.05),
    Tier("extreme", "one lamp 77° to 110° from the camera: beside the face or behind it", _lamp(77, 110)),
)
