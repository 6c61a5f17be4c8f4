"""Albedo: the reflectance of a person's face at places of the mean face, evaluated at every pixel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface.people.anatomy import INNER_CORNER, OUTER_CORNER, lid_margins
from harmonicface.people.complexion import GRAIN, GRAIN_STRENGTH, Complexion
from harmonicface.people.hair import hair_cover
from harmonicface.people.mottling import edge, field_at

Array = NDArray[np.float64]

IRIS_RADIUS = 5.9  # mm
PUPIL_RADIUS = 2.0
SCLERA = 0.62  # reflectance of the white of the eye
SMALLEST_ALBEDO = 0.01
LARGEST_ALBEDO = 0.95
MOUTH_HALF_WIDTH = 25.5  # mm from the midline to the corner of the lips


@dataclass(frozen=True, eq=False)
class SkinPixels:
    """Where pixels lie on the face.

    Parameters
    ----------
    x, y
        (p,) mm in the mean face.
    eye_x, eye_y
        (p,) mm from the centre of the eyeball, for pixels that see one.
    on_eye
        (p,) true where a pixel sees an eyeball.
    blur
        mm, about half a pixel: nothing finer is resolved.
    front
        (p,) 1 on the face, down to 0 on ears, neck and the back of the head, which lack a face's features.
    scalp
        (p,) share of the skin that hair of the head covers besides fringe and temples.
    """

    x: Array
    y: Array
    eye_x: Array
    eye_y: Array
    on_eye: NDArray[np.bool_]
    blur: float
    front: Array | float = 1.0
    scalp: Array | float = 0.0

    def field(self, knots: NDArray[np.float32], across: float, up: float) -> Array:
        """Return the random field through knots, some mm apart, at the pixels, (p,)."""
        return field_at(knots, self.x, self.y, across, up)


@dataclass(frozen=True, eq=False)
class Paint:
    """Reflectance at pixels and what it is of, for those who give the parts their colours.

    Parameters
    ----------
    albedo
        (p,) linear reflectance, 0.01 to 0.95.
    lips, hair, white, iris
        (p,) shares of the lips' skin, of hair, of the white of the eye, and of the iris, 0 to 1; the rest is skin.
    """

    albedo: Array
    lips: Array
    hair: Array
    white: Array
    iris: Array


def albedo(complexion: Complexion, pixels: SkinPixels) -> NDArray[np.float32]:
    """Return the linear reflectance at each pixel, (p,), 0 to 1."""
    return paint(complexion, pixels).albedo.astype(np.float32)


def paint(complexion: Complexion, pixels: SkinPixels) -> Paint:
    """Return the linear reflectance at each pixel, and the shares of what it is of."""
    x, y, blur = pixels.x, pixels.y, pixels.blur
    skin = complexion.tone * np.exp(_tint(complexion, pixels))
    lips = pixels.front * _lips(x, y, blur)
    skin *= 1 + lips * (complexion.lips - 1)
    cover, strands = hair_cover(complexion, x, y, blur, pixels.field)
    cover = np.maximum(pixels.front * cover * (1 - 0.9 * lips), pixels.scalp)
    skin += cover * (complexion.hair * strands - skin)
    skin *= _creases(complexion, x, y, blur) ** pixels.front
    white, iris = np.zeros((2, len(x)))
    if pixels.on_eye.any():
        eye = pixels.on_eye
        gaze_x, gaze_y = pixels.eye_x[eye], pixels.eye_y[eye]
        skin[eye], white[eye], iris[eye] = _eyeball(complexion, gaze_x, gaze_y, x[eye], y[eye], blur)
        lips[eye] = cover[eye] = 0
    return Paint(np.clip(skin, SMALLEST_ALBEDO, LARGEST_ALBEDO), lips, cover, white, iris)


def lip_margins(x: Array) -> tuple[Array, Array, Array]:
    """Return the heights of the line between the lips, of the upper and of the lower lip's border at x."""
    across = np.clip(np.abs(x) / MOUTH_HALF_WIDTH, 0, 1)
    line = -69.8 - 1.6 * across**2
    bow = 1.6 * np.exp(-0.5 * (x / 2.6) ** 2)
    return line, line + 9.2 * (1 - across**2.0) * (1 - 0.25 * across) - bow, line - 10.0 * (1 - across**2.4) ** 0.9


def _spot(x: Array, y: Array, centre: tuple[float, float], wide: float, tall: float) -> Array:
    """Return a Gaussian spot of height 1 on each side of the face."""
    return np.asarray(np.exp(-0.5 * (((np.abs(x) - centre[0]) / wide) ** 2 + ((y - centre[1]) / tall) ** 2)))


def _tint(c: Complexion, pixels: SkinPixels) -> Array:
    """Return the logarithm of the skin's albedo over its tone: regions, mottling and marks."""
    x, y, blur = pixels.x, pixels.y, pixels.blur
    tint = c.cheeks * _spot(x, y, (40.0, -28.0), 17.0, 13.0) + c.nose * _spot(x, y, (0.0, -30.0), 13.0, 14.0)
    tint += c.eye_shadow * (_spot(x, y, (28.0, -9.0), 16.0, 6.0) + 0.8 * _spot(x, y, (26.0, 8.0), 17.0, 6.0))
    tint += c.eye_shadow * 0.8 * _spot(x, y, (14.0, 0.0), 5.0, 9.0)
    tint += c.forehead * edge(y - 20, 14) + c.mouth_region * _spot(x, y, (0.0, -74.0), 30.0, 22.0)
    tint *= pixels.front
    for knots, spacing, strength in zip(c.grain, GRAIN, GRAIN_STRENGTH, strict=True):
        tint += strength * np.exp(-0.5 * (blur / spacing) ** 2) * pixels.field(knots, spacing, spacing)
    for left, height, radius, depth in c.marks[c.marks[:, 3] != 0]:
        seen = radius**2 + blur**2
        squared = (x - left) ** 2 + (y - height) ** 2
        tint += pixels.front * (depth * (radius**2 / seen) * np.exp(-0.5 * squared / seen))
    return tint


def _lips(x: Array, y: Array, blur: float) -> Array:
    """Return 1 on the lips, 0 beside them."""
    _, upper, lower = lip_margins(x)
    softness = 0.9 + blur
    return edge(upper - y, softness) * edge(y - lower, softness) * edge(MOUTH_HALF_WIDTH - np.abs(x), 2 * softness)


def _creases(c: Complexion, x: Array, y: Array, blur: float) -> Array:
    """Return factors that darken nostrils, the mouth line, the lashes and the lids' crease."""
    side = np.abs(x)
    _, upper, lower = lid_margins(x)
    open_eye = edge(side - INNER_CORNER[0], 2.0) * edge(OUTER_CORNER[0] + 1.5 - side, 2.0)
    thin = 0.9**2 + blur**2
    share = 0.9 / np.sqrt(thin)
    lashes = c.lid_line * 1.2 * share * np.exp(-0.5 * (y - upper - 0.4) ** 2 / thin) * open_eye
    lashes += c.lid_line * 0.35 * share * np.exp(-0.5 * (y - lower + 0.3) ** 2 / thin) * open_eye
    crease = 0.2 * np.exp(-0.5 * (y - upper - 3.6) ** 2 / (1.0 + blur**2)) * open_eye
    nostril = 1.4 * _spot(x, y, (7.6, -41.2), 3.0 + 0.3 * blur, 1.5 + 0.3 * blur)
    wing = 0.25 * _spot(x, y, (18.5, -41.0), 1.8 + blur, 4.0)
    mouth = 0.9 * share * np.exp(-0.5 * (y + 69.8 + 1.6 * (x / 25) ** 2) ** 2 / (0.8 * thin)) * edge(25 - side, 4.0)
    fold = 0.2 * c.wrinkles * np.exp(-0.5 * (side - 22 + 0.42 * (y + 48)) ** 2 / (2.5 + blur**2))
    fold *= edge(-40 - y, 4.0) * edge(y + 70, 8.0)
    return np.asarray(np.exp(-(lashes + crease + nostril + wing + mouth + fold)))


def _eyeball(c: Complexion, eye_x: Array, eye_y: Array, x: Array, y: Array, blur: float) -> tuple[Array, Array, Array]:
    """Return the albedo of sclera, iris and pupil in the shadow of the lashes, and the shares of white and iris."""
    radius = np.hypot(eye_x, eye_y)
    softness = 0.45 + 0.7 * blur
    sclera = SCLERA * (0.55 + 0.45 * c.tone / 0.5)
    iris = c.iris * (1 - 0.5 * edge(radius - 4.9, 0.6 + blur))
    inside = edge(IRIS_RADIUS - radius, softness)
    value = sclera + (iris - sclera) * inside
    value += (0.015 - value) * edge(PUPIL_RADIUS - radius, softness)
    _, upper, lower = lid_margins(x)
    shade = 0.5 * np.exp(-np.maximum(upper - y, 0) / 1.2) + 0.15 * np.exp(-np.maximum(y - lower, 0) / 0.8)
    inner = edge(INNER_CORNER[0] + 3.0 - np.abs(x), 1.5 + blur)
    value += inner * (0.75 * c.tone - value)
    return value * (1 - shade), (1 - inside) * (1 - inner), inside * (1 - inner)
