"""The complexion of a person: the parameters of skin, hair, lips, eyes and marks, and how they are drawn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface.people.mottling import draw_knots

Array = NDArray[np.float64]

GRAIN = (30.0, 12.0, 5.0, 2.0)  # mm between the knots of the skin's mottling
GRAIN_STRENGTH = (0.085, 0.05, 0.03, 0.03)  # standard deviation of the logarithm of albedo at each
MARKS = 40  # room for that many freckles, moles and blemishes


@dataclass(frozen=True, eq=False)
class Complexion:
    """What colours one person's face, in the coordinates of the mean face so that it follows the features.

    Parameters
    ----------
    tone
        Reflectance of the cheeks, 0.2 to 0.75.
    hair
        Reflectance of hair, 0.02 (black) to 0.3 (blond).
    iris
        Reflectance of the irises, 0.03 to 0.25.
    brow_height, brow_thickness, brow_length, brow_arch, brow_gap
        Of the eyebrows in mm: the middle line's height above the eyes, the thickness, the length of each, how far the
        arch rises, half the gap between the two.
    brow_density, beard_density, moustache_density, chin_beard_density, stubble_density
        Share of the skin that hair covers, 0 to 1.
    fringe
        Lower border of hair on the forehead in mm above the eyes; 70 and more is out of sight.
    temple_hair
        Distance of the hair at the temples from the midline in mm; 84 and more is out of sight.
    lips
        Albedo of the lips over that of the skin, 0.55 to 1.05.
    cheeks, nose, forehead, mouth_region, eye_shadow
        Logarithm of albedo added there and around the eyes, about -0.6 to 0.4.
    lid_line
        Darkness of the lashes, 0 to 1.
    wrinkles
        Darkness of creases, 0 to 1.
    grain
        Random knots of the mottling, one grid for each of `GRAIN`, standard normal.
    strands
        Random knots of the pattern of hair, standard normal.
    marks
        (MARKS, 4): x, y and radius in mm, and the logarithm of albedo added at the centre of each mark.
    """

    tone: float
    hair: float
    iris: float
    brow_height: float
    brow_thickness: float
    brow_length: float
    brow_arch: float
    brow_gap: float
    brow_density: float
    beard_density: float
    moustache_density: float
    chin_beard_density: float
    stubble_density: float
    fringe: float
    temple_hair: float
    lips: float
    cheeks: float
    nose: float
    forehead: float
    mouth_region: float
    eye_shadow: float
    lid_line: float
    wrinkles: float
    grain: tuple[NDArray[np.float32], ...]
    strands: NDArray[np.float32]
    marks: Array


def draw_complexion(rng: np.random.Generator, masculine: float, age: float) -> Complexion:
    """Draw the complexion of a person of some masculinity and age (standard normal numbers)."""
    darkness = rng.normal()  # skin, hair and eyes darken together
    tone = float(np.clip(0.48 - 0.08 * darkness, 0.2, 0.75))
    hair = float(np.clip(0.065 * np.exp(0.6 * rng.normal() - 0.3 * darkness + 0.15 * age), 0.02, 0.3))
    shaven = rng.random() < 0.8
    beard = rng.choice(4) if masculine > 0.2 and not shaven else -1
    beard_density = rng.uniform(0.4, 0.8) if beard == 0 else 0.0
    moustache = rng.uniform(0.4, 0.9) if beard in (0, 1, 2) else 0.0
    chin_beard = rng.uniform(0.4, 0.9) if beard in (0, 2, 3) else 0.0
    stubble = float(np.clip(0.2 * masculine + 0.14 * rng.normal(), 0, 0.55)) if masculine > 0 else 0.0
    fringe = rng.uniform(24, 40) if rng.random() < 0.1 else rng.normal(78, 10)
    return Complexion(
        tone=tone,
        hair=hair,
        iris=float(np.clip(0.09 * np.exp(0.5 * rng.normal() - 0.3 * darkness), 0.03, 0.25)),
        brow_height=float(np.clip(20.5 - 1.0 * masculine + 2.8 * rng.normal(), 14, 28)),
        brow_thickness=float(np.clip(7.4 + 1.2 * masculine + 1.7 * rng.normal(), 3, 12)),
        brow_length=float(np.clip(41 + 3 * rng.normal(), 32, 48)),
        brow_arch=float(np.clip(3.0 - 0.7 * masculine + 1.3 * rng.normal(), 0, 7)),
        brow_gap=float(np.clip(11.5 - 0.8 * masculine + 2.2 * rng.normal(), 3, 17)),
        brow_density=float(np.clip(0.87 + 0.05 * masculine - 0.03 * age + 0.15 * rng.normal(), 0.3, 0.97)),
        beard_density=float(beard_density),
        moustache_density=float(moustache),
        chin_beard_density=float(chin_beard),
        stubble_density=stubble,
        fringe=float(fringe),
        temple_hair=float(np.clip(79 + 6 * rng.normal(), 66, 98)),
        lips=float(np.clip(0.78 - 0.03 * masculine + 0.09 * rng.normal() + 0.04 * darkness, 0.55, 1.05)),
        cheeks=0.12 * float(rng.normal()) + 0.12,
        nose=0.08 * float(rng.normal()) + 0.03,
        forehead=0.11 * float(rng.normal()) + 0.09,
        mouth_region=0.13 * float(rng.normal()) - 0.10,
        eye_shadow=0.14 * float(rng.normal()) - 0.26 - 0.03 * age,
        lid_line=float(np.clip(0.5 - 0.12 * masculine + 0.2 * rng.normal(), 0.1, 0.95)),
        wrinkles=float(np.clip(0.25 + 0.2 * age + 0.1 * rng.normal(), 0, 0.9)),
        grain=tuple(draw_knots(rng, spacing, spacing) for spacing in GRAIN),
        strands=draw_knots(rng, 1.0, 5.0),
        marks=_draw_marks(rng),
    )


def _draw_marks(rng: np.random.Generator) -> Array:
    """Draw freckles, moles and blemishes; unused rows have no darkness."""
    marks = np.zeros((MARKS, 4))
    place = rng.uniform((-62, -108), (62, 32), (MARKS, 2))
    moles = min(int(rng.poisson(1.6)), 8)
    blemishes = min(int(rng.poisson(3.0)), 10)
    freckles = int(rng.integers(8, MARKS - 18)) if rng.random() < 0.2 else 0
    kinds = np.repeat([0, 1, 2], [moles, blemishes, freckles])
    radius = rng.uniform((0.5, 1.0, 0.4), (1.3, 2.4, 0.9), (MARKS, 3))
    depth = rng.uniform((-1.1, -0.3, -0.5), (-0.4, 0.12, -0.2), (MARKS, 3))
    spread = rng.normal((0, -20), (20, 11), (MARKS, 2))  # freckles gather on nose and cheeks
    for row, kind in enumerate(kinds):
        marks[row] = *(spread[row] if kind == 2 else place[row]), radius[row, kind], depth[row, kind]
    return marks
