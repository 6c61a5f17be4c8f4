"""Colours of skin, lips, hair and eyes: what red, green and blue reflect over the luminance that is painted in grey."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface.io.colour import LUMINANCE
from harmonicface.people.complexion import Complexion
from harmonicface.people.skin import SMALLEST_ALBEDO, Paint

Array = NDArray[np.float64]

# Logarithms of red, green and blue reflectance over luminance. Skin goes from light (luminance 0.5) to dark (0.07) by
# its melanin; the two ends are faces' mean colours in photographs of known white balance.
LIGHT_SKIN, DARK_SKIN = np.array([0.38, -0.11, -0.43]), np.array([0.58, -0.20, -0.73])
LIGHT, DARK = np.log(0.50), np.log(0.07)
BLOOD = np.array([0.20, -0.12, -0.08])  # haemoglobin absorbs green most
CAROTENE = np.array([0.01, 0.005, -0.06])
LIPS = np.array([0.17, -0.13, -0.06])  # besides the skin's own colour
BLACK_HAIR, BLOND_HAIR, RED_HAIR = (
    np.array([0.25, -0.06, -0.4]),
    np.array([0.4, -0.1, -0.8]),
    np.array([0.7, -0.4, -1.1]),
)
BROWN_IRIS, GREEN_IRIS, BLUE_IRIS = (
    np.array([0.5, -0.1, -0.8]),
    np.array([-0.05, 0.05, -0.3]),
    np.array([-0.4, 0.03, 0.5]),
)
WHITE = np.array([0.06, -0.01, -0.08])  # of the eye: a little warm
DARKEST_HAIR, LIGHTEST_HAIR = np.log(0.03), np.log(0.25)
BROWN_BELOW = 0.085  # reflectance of the iris
LARGEST = 0.9


@dataclass(frozen=True)
class Pigments:
    """What colours a person besides her lightness.

    Parameters
    ----------
    blood
        Redness of cheeks, nose, ears and lips, about 0.3 to 1.7.
    carotene
        Yellowness of the skin, about -2 to 2.
    red_hair
        0 for black, brown and blond hair, up to 1 for red.
    green_iris
        Of irises that are not brown: 0 is blue, 1 green.
    """

    blood: float
    carotene: float
    red_hair: float
    green_iris: float


def draw_pigments(rng: np.random.Generator) -> Pigments:
    """Draw the pigments of a person."""
    blood, carotene = rng.standard_normal(2)
    red, green = rng.random(2)
    return Pigments(
        float(np.clip(1 + 0.35 * blood, 0.2, 1.9)),
        float(np.clip(carotene, -2.5, 2.5)),
        0.7 * (red < 0.05),
        float(green),
    )


def colours(complexion: Complexion, pigments: Pigments, paint: Paint, redness: Array) -> Array:
    """Return linear reflectances whose luminance is the painted grey, (p, 3), 0.005 to 0.9.

    Parameters
    ----------
    complexion, pigments
        The person.
    paint
        Of p pixels.
    redness
        (p,) blood below the skin, 0 where it is average, up to 1.
    """
    melanin = np.clip((LIGHT - np.log(complexion.tone)) / (LIGHT - DARK), 0, 1)
    skin = LIGHT_SKIN + melanin * (DARK_SKIN - LIGHT_SKIN) + pigments.carotene * CAROTENE
    blood = pigments.blood * redness
    own = skin + blood[:, None] * BLOOD + (pigments.blood * paint.lips)[:, None] * LIPS
    rest = 1 - paint.hair - paint.white - paint.iris
    chroma = rest[:, None] * _even(own)
    others = (
        (paint.hair, _hair(complexion, pigments)),
        (paint.white, WHITE),
        (paint.iris, _iris(complexion, pigments)),
    )
    for share, colour in others:
        chroma += share[:, None] * _even(colour)
    return np.clip(paint.albedo[:, None] * chroma, SMALLEST_ALBEDO / 2, LARGEST)


def _even(logarithms: Array) -> Array:
    """Return the colours of logarithms, scaled to luminance 1."""
    ratios = np.exp(logarithms)
    return np.asarray(ratios / (ratios @ LUMINANCE)[..., None])


def _hair(c: Complexion, pigments: Pigments) -> Array:
    lightness = np.clip((np.log(c.hair) - DARKEST_HAIR) / (LIGHTEST_HAIR - DARKEST_HAIR), 0, 1)
    usual = BLACK_HAIR + np.sqrt(lightness) * (BLOND_HAIR - BLACK_HAIR)
    return np.asarray(usual + pigments.red_hair * (RED_HAIR - usual))


def _iris(c: Complexion, pigments: Pigments) -> Array:
    light = BLUE_IRIS + pigments.green_iris * (GREEN_IRIS - BLUE_IRIS)
    share = np.clip(4 * np.log(c.iris / BROWN_BELOW) + 0.5, 0, 1)
    return np.asarray(BROWN_IRIS + share * (light - BROWN_IRIS))
