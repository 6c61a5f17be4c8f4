"""Procedural skin of ICT people: their complexion, drawn at random, painted into the model's textures."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface.people.complexion import GRAIN, Complexion, draw_complexion
from harmonicface.people.hair import STRAND_WIDTH
from harmonicface.people.ict_atlas import HeadTexels, texture_maps
from harmonicface.people.ict_model import HeadModel
from harmonicface.people.ict_places import above_hairline, ear_share, face_share, nostril_share
from harmonicface.people.mottling import edge
from harmonicface.people.skin import paint
from harmonicface.people.skin_colour import Pigments, colours, draw_pigments

Array = NDArray[np.float64]

MEAN_TONE, TONE_STEP = 0.48, 0.08  # of the built-in people: tone falls by one step as darkness grows by one
TONE, TONE_SPREAD = 0.34, 0.22  # of the skins here: median luminance, standard deviation of its logarithm
DARKEST_TONE, LIGHTEST_TONE = 0.12, 0.50
SCALP_COVER = 0.93
REDNESS = (  # height, then centre and standard deviations across and up in mm: cheeks, nose, chin, lids
    (0.7, 40.0, -32.0, 16.0, 13.0),
    (0.7, 0.0, -34.0, 11.0, 11.0),
    (0.3, 0.0, -98.0, 14.0, 9.0),
    (0.35, 28.0, -6.0, 15.0, 8.0),
)
TUFT = 4.0  # mm between the tufts that make the hairline ragged
NOSTRIL = 0.6  # of the light that skin outside reflects is lost inside


@dataclass(frozen=True, eq=False)
class HeadSkin:
    """What a person's head is painted with.

    Parameters
    ----------
    complexion
        As of the built-in people, but with a tone in the range of real skin.
    pigments
        What gives it colour.
    """

    complexion: Complexion
    pigments: Pigments


def draw_head_skin(rng: np.random.Generator) -> HeadSkin:
    """Draw a person's skin, hair and eyes; they do not depend on the shape of her head.

    The luminance of the skin is log-normal about 0.34, from 0.12 to 0.5: of the measured skins of Cooksey, Allen &
    Tsai 2017 (Reference data set of human skin reflectance) that is most.
    """
    masculine = float(rng.choice((-1.0, 1.0)) * 0.8 + 0.6 * rng.standard_normal())
    age = float(rng.standard_normal())
    complexion = draw_complexion(rng, masculine, age)
    darkness = (MEAN_TONE - complexion.tone) / TONE_STEP
    tone = float(np.clip(TONE * np.exp(-TONE_SPREAD * darkness), DARKEST_TONE, LIGHTEST_TONE))
    return HeadSkin(dataclasses.replace(complexion, tone=tone), draw_pigments(rng))


def head_textures(model: HeadModel, skin: HeadSkin, side: int, *, colour: bool) -> tuple[NDArray[np.float32], ...]:
    """Return the textures of a person's head in the order of the model's parts.

    Parameters
    ----------
    model
        Read by `read_ict_model`.
    skin
        The person.
    side
        Texels a side.
    colour
        (side, side, 3) linear reflectances if true, else (side, side): their luminance.
    """
    textures = []
    for texture in texture_maps(model, side):
        texels = _dressed(texture.texels, skin.complexion)
        painted = paint(skin.complexion, texels)
        painted = dataclasses.replace(painted, albedo=painted.albedo * (1 - NOSTRIL * nostril_share(texels.points)))
        values = colours(skin.complexion, skin.pigments, painted, _redness(skin, texels)) if colour else painted.albedo
        textures.append(texture.picture(values))
    return tuple(textures)


def _dressed(texels: HeadTexels, complexion: Complexion) -> HeadTexels:
    """Return the texels with the share of the face and with the hair of the head."""
    places = texels.points
    strands = np.exp(-0.5 * (texels.blur / STRAND_WIDTH) ** 2) * texels.field(complexion.strands, TUFT, TUFT)
    height = above_hairline(places, complexion.fringe) + 1.5 * strands
    scalp = SCALP_COVER * edge(height, 5 + texels.blur) * (1 - ear_share(places))
    return dataclasses.replace(texels, front=face_share(places), scalp=scalp)


def _redness(skin: HeadSkin, texels: HeadTexels) -> Array:
    """Return the blood below the skin: cheeks, nose, ears, chin and lids, in blotches."""
    x, y = np.abs(texels.x), texels.y
    face = sum(
        height * np.exp(-0.5 * (((x - across) / wide) ** 2 + ((y - up) / tall) ** 2))
        for height, across, up, wide, tall in REDNESS
    )
    blotches = 0.12 * texels.field(skin.complexion.grain[1], GRAIN[1], GRAIN[1])
    return np.asarray(np.clip(texels.front * face + 0.8 * ear_share(texels.points) + blotches, -0.5, 1.2))
