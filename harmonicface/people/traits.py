"""The traits of a head, each a length by which a person differs from the mean, and how they are drawn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface.people.fields import Field, both, bump, forward, grown, outward, slanted, spread, upward

Array = NDArray[np.float64]

LARGEST = 2.6  # standard deviations that a trait approaches but never passes
ASYMMETRY = 0.22  # of a trait's spread: how much the two halves of a face differ from each other
SCALE = 1.0  # of all spreads together; set by the measurement of scripts/people_spread.py


@dataclass(frozen=True)
class Trait:
    """One way in which heads differ.

    Parameters
    ----------
    name
        What a positive value makes larger.
    spread
        Standard deviation between people in mm; a person's value lies within `LARGEST` of them.
    field
        The displacement of the mean face for +1 mm of it.
    masculine
        Correlation with the person's masculinity, -1 to 1.
    age
        Correlation with the person's age, -1 to 1.
    """

    name: str
    spread: float
    field: Field
    masculine: float = 0.0
    age: float = 0.0


TRAITS = (
    # skull
    Trait("face width", 3.2, outward(lambda p: p.lateral(34, 80))),
    Trait("face flatness", 4.0, forward(lambda p: (p.x / 70) ** 2)),
    Trait("forehead slope", 1.7, forward(lambda p: -(np.clip((p.y - 16) / 34, 0, 2) ** 1.3)), 0.4),
    Trait("forehead breadth", 2.0, outward(lambda p: p.lateral(20, 70) * p.vertical(8, 40))),
    Trait("frontal eminence", 0.5, bump(24, 46, 18, 14), -0.3),
    Trait("temple fullness", 1.2, bump(66, 26, 12, 18)),
    Trait("midface length", 2.8, upward(lambda p: -p.vertical(-14, -60)), 0.2),
    Trait("lower face length", 3.2, upward(lambda p: -p.vertical(-72, -112)), 0.3),
    Trait("midface projection", 1.8, forward(lambda p: p.near(0, -36, 34, 26))),
    # brow and eyes
    Trait("brow ridge", 1.1, bump(22, 21, 17, 7), 0.6, 0.1),
    Trait("brow ridge tail", 1.0, bump(47, 14, 10, 8, -0.5), 0.4),
    Trait("glabella", 0.9, bump(0, 20, 10, 8), 0.5),
    Trait("brow height", 1.4, upward(lambda p: p.near(28, 20, 24, 9)), -0.5, -0.2),
    Trait("eye distance", 1.5, spread(31, -1, 16, 12)),
    Trait("eye size", 1.1, grown(31.3, -1, 14), -0.2),
    Trait("eye depth", 1.6, bump(31, 2, 15, 10), -0.3, -0.2),
    Trait("eye slant", 1.5, slanted(31, -2, 14, 9)),
    Trait("upper lid opening", 1.1, upward(lambda p: p.upper_lid), 0.0, -0.3),
    Trait("lower lid opening", 0.6, upward(lambda p: -p.lower_lid)),
    Trait("upper lid fold", 1.7, bump(29, 8, 13, 4), 0.0, 0.3),
    Trait("outer lid hood", 1.2, bump(43, 6, 7, 5, -0.5), 0.0, 0.4),
    Trait("lower lid bag", 0.8, bump(28, -11, 11, 4, 0.1), 0.1, 0.5),
    Trait("tear trough", 0.8, bump(21, -16, 10, 5, -0.5), 0.0, -0.5),
    # nose
    Trait("nose root height", 1.2, bump(0, 1, 7, 9), 0.3),
    Trait("nose bridge height", 1.5, bump(0, -14, 7, 12), 0.3),
    Trait("nose hump", 0.8, bump(0, -17, 5, 6), 0.3),
    Trait("nose bridge width", 0.9, spread(8, -12, 6, 14)),
    Trait("nose length", 2.5, upward(lambda p: -p.near(0, -40, 17, 11)), 0.2, 0.3),
    Trait("nose tip height", 2.2, bump(0, -34, 10, 9), 0.2),
    Trait("nose tip upturn", 1.6, upward(lambda p: p.near(0, -35, 8, 7)), -0.4),
    Trait("nose tip breadth", 0.9, spread(7, -34, 5, 7), 0.2),
    Trait("nose wing width", 2.0, spread(16, -40, 7, 9), 0.3),
    Trait("nose wing fullness", 1.0, bump(13, -38, 5, 6)),
    Trait("nose base drop", 1.0, upward(lambda p: -p.near(0, -44, 5, 5))),
    Trait("nose wing arch", 1.1, upward(lambda p: p.near(15, -42, 6, 6))),
    # cheeks
    Trait("cheekbone", 1.5, bump(50, -22, 15, 11, 0.4)),
    Trait("malar fullness", 1.1, bump(36, -27, 13, 10, 0.3), -0.2),
    Trait("cheek fullness", 1.8, bump(46, -58, 15, 17)),
    Trait("nasolabial fold", 0.7, bump(28, -55, 4.5, 12, 0.45), 0.0, -0.6),
    Trait("nasolabial mound", 0.9, bump(34, -50, 8, 11, 0.3), 0.0, 0.4),
    Trait("masseter", 1.8, bump(60, -60, 12, 18), 0.4),
    # mouth
    Trait("mouth width", 2.4, spread(24, -70, 11, 8), 0.2),
    Trait("mouth projection", 1.9, bump(0, -66, 22, 15)),
    Trait("upper lip fullness", 1.2, bump(0, -65, 17, 3.5), -0.3, -0.3),
    Trait("upper lip height", 1.1, upward(lambda p: p.near(0, -62, 18, 4)), -0.2, -0.3),
    Trait("lower lip fullness", 1.3, bump(0, -76, 14, 4), -0.2, -0.3),
    Trait("lower lip height", 1.1, upward(lambda p: -p.near(0, -79, 17, 4)), -0.2, -0.2),
    Trait("cupid's bow", 0.5, both((1.0, upward(lambda p: p.near(5, -61, 4, 4))), (0.6, bump(5, -60, 3, 4)))),
    Trait("mouth corner lift", 1.3, upward(lambda p: p.near(25, -71, 8, 7)), 0.0, -0.3),
    Trait("mouth line arch", 0.6, upward(lambda p: p.near(10, -70, 6, 6) - p.near(0, -70, 5, 6))),
    Trait("mouth corner depth", 0.9, bump(27, -72, 6, 6)),
    Trait("philtrum depth", 0.5, both((-1.0, bump(0, -55, 2.6, 5)), (0.7, bump(6, -56, 2.6, 6)))),
    Trait("upper lip length", 1.6, upward(lambda p: -p.near(0, -58, 22, 7)), 0.2, 0.3),
    # chin and jaw
    Trait("mentolabial furrow", 1.2, bump(0, -87, 16, 5), 0.0, -0.2),
    Trait("chin projection", 2.2, bump(0, -101, 16, 11), 0.3),
    Trait("chin breadth", 1.6, spread(16, -102, 10, 12), 0.5),
    Trait("chin pad", 0.7, bump(9, -100, 6, 8), 0.3),
    Trait("chin cleft", 0.25, bump(0, -101, 3.2, 6), -0.4),
    Trait("jaw width", 3.2, outward(lambda p: p.lateral(20, 64) * p.vertical(-36, -80)), 0.5),
    Trait("jaw corner", 1.8, bump(54, -78, 11, 12), 0.4),
    Trait("jowl", 1.2, bump(34, -88, 10, 10), 0.0, 0.5),
    Trait("prejowl hollow", 0.9, bump(30, -97, 9, 8), 0.0, -0.3),
)


@dataclass(frozen=True, eq=False)
class HeadTraits:
    """What makes one person's head: numbers only, so it can be drawn once and looked at in any size.

    Parameters
    ----------
    values
        One value in mm for each of `TRAITS`.
    asymmetry
        One value in mm for each of `TRAITS`: half the difference between the right and the left side of the picture.
    masculine, age
        Standard normal numbers that bias the traits and the complexion; age 0 is middle age.
    """

    values: Array
    asymmetry: Array
    masculine: float
    age: float


def draw_head(rng: np.random.Generator) -> HeadTraits:
    """Draw the traits of a head.

    Each value is spread * (m M + a A + sqrt(1 - m^2 - a^2) N) with the correlations m and a of the trait, the person's
    masculinity M and age A, and N standard normal, softly limited.

    Examples
    --------
    >>> import numpy as np
    >>> head = draw_head(np.random.default_rng(7))
    >>> len(head.values) == len(TRAITS)
    True
    """
    masculine = float(rng.choice((-1.0, 1.0)) * 0.8 + 0.6 * rng.standard_normal())
    age = float(rng.standard_normal())
    m, a, spreads = (np.array([getattr(trait, name) for trait in TRAITS]) for name in ("masculine", "age", "spread"))
    own = rng.standard_normal(len(TRAITS))
    standard = m * masculine + a * age + np.sqrt(1 - m**2 - a**2) * own
    asymmetry = ASYMMETRY * rng.standard_normal(len(TRAITS))
    return HeadTraits(SCALE * spreads * _limited(standard), SCALE * spreads * _limited(asymmetry), masculine, age)


def _limited(standard: Array) -> Array:
    """Return standard deviations that approach `LARGEST` but never pass it."""
    return np.asarray(LARGEST * np.tanh(standard / LARGEST))
