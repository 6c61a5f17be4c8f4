"""Albedo: the reflectance of a person's face at places of the mean face, evaluated at every pixel."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from harmonicface.people.anatomy import INNER_CORNER, OUTER_CORNER, lid_margins
from harmonicface.people.complexion import FIELD, GRAIN, GRAIN_STRENGTH, HAIR_GRAIN, Complexion

Array = NDArray[np.float64]

IRIS_RADIUS = 5.9  # mm
PUPIL_RADIUS = 2.0
SCLERA = 0.62  # reflectance of the white of the eye
LARGEST_ALBEDO = 0.95
REMAPPED = 1024  # pixels a line: OpenCV takes lines of less than 32,768


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
    """

    x: Array
    y: Array
    eye_x: Array
    eye_y: Array
    on_eye: NDArray[np.bool_]
    blur: float


def albedo(complexion: Complexion, pixels: SkinPixels) -> NDArray[np.float32]:
    """Return the linear reflectance at each pixel, (p,), 0 to 1."""
    x, y, blur = pixels.x, pixels.y, pixels.blur
    hairs = _knots_at(complexion.hairs, x, y, HAIR_GRAIN, 2 * HAIR_GRAIN) * np.exp(-0.5 * (blur / HAIR_GRAIN) ** 2)
    skin = complexion.tone * np.exp(_tint(complexion, x, y, blur))
    lips = _lips(x, y, blur)
    skin *= 1 + lips * (complexion.lips - 1)
    cover = _hair_cover(complexion, x, y, blur, hairs) * (1 - 0.9 * lips)
    skin += cover * (complexion.hair * (1 + 0.15 * hairs) - skin)
    skin *= _creases(complexion, x, y, blur)
    if pixels.on_eye.any():
        eye = pixels.on_eye
        skin[eye] = _eyeball(complexion, pixels.eye_x[eye], pixels.eye_y[eye], x[eye], y[eye], blur)
    return np.clip(skin, 0.01, LARGEST_ALBEDO).astype(np.float32)


def _step(value: Array, softness: float) -> Array:
    """Return 0 well below 0, 1 well above it, over about +-softness."""
    t = np.clip(0.5 + 0.5 * value / softness, 0, 1)
    return np.asarray(t * t * (3 - 2 * t))


def _spot(x: Array, y: Array, centre: tuple[float, float], wide: float, tall: float) -> Array:
    """Return a Gaussian spot of height 1 on each side of the face."""
    return np.asarray(np.exp(-0.5 * (((np.abs(x) - centre[0]) / wide) ** 2 + ((y - centre[1]) / tall) ** 2)))


def _knots_at(knots: Array, x: Array, y: Array, across: float, up: float) -> Array:
    """Return the smooth field through random knots."""
    lines = -(-len(x) // REMAPPED)
    columns, rows = (
        np.resize(((place - start) / spacing).astype(np.float32), (lines, REMAPPED))
        for place, start, spacing in ((x, FIELD[0], across), (y, FIELD[1], up))
    )
    values = cv2.remap(knots.astype(np.float32), columns, rows, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT)
    return np.asarray(values.ravel()[: len(x)], dtype=np.float64)


def _tint(c: Complexion, x: Array, y: Array, blur: float) -> Array:
    """Return the logarithm of the skin's albedo over its tone: regions, mottling and marks."""
    tint = c.blush * _spot(x, y, (40.0, -32.0), 15.0, 12.0) + c.nose_red * _spot(x, y, (0.0, -34.0), 13.0, 10.0)
    tint += c.eye_shadow * (_spot(x, y, (29.0, -9.0), 15.0, 5.0) + 0.8 * _spot(x, y, (27.0, 8.0), 15.0, 6.0))
    tint += c.eye_shadow * 0.8 * _spot(x, y, (13.0, 0.0), 4.0, 8.0)
    tint += c.forehead * _step(y - 24, 10)
    for knots, spacing, strength in zip(c.grain, GRAIN, GRAIN_STRENGTH, strict=True):
        tint += strength * np.exp(-0.5 * (blur / spacing) ** 2) * _knots_at(knots, x, y, spacing, spacing)
    for left, height, radius, depth in c.marks[c.marks[:, 3] != 0]:
        seen = radius**2 + blur**2
        squared = (x - left) ** 2 + (y - height) ** 2
        tint += depth * (radius**2 / seen) * np.exp(-0.5 * squared / seen)
    return tint


def _lips(x: Array, y: Array, blur: float) -> Array:
    """Return 1 on the lips, 0 beside them."""
    across = np.clip(np.abs(x) / 25.5, 0, 1)
    line = -69.8 - 1.6 * across**2
    bow = 1.6 * np.exp(-0.5 * (x / 2.6) ** 2)
    upper = line + 9.2 * (1 - across**2.0) * (1 - 0.25 * across) - bow
    lower = line - 10.0 * (1 - across**2.4) ** 0.9
    softness = 0.9 + blur
    return _step(upper - y, softness) * _step(y - lower, softness) * _step(25.5 - np.abs(x), 2 * softness)


def _hair_cover(c: Complexion, x: Array, y: Array, blur: float, hairs: Array) -> Array:
    """Return the share of hair at each place: eyebrows, beard, and the hair of the head."""
    side = np.abs(x)
    along = (side - c.brow_gap) / c.brow_length
    inside = np.clip(along, 0, 1)
    middle = c.brow_height - 1.5 + c.brow_arch * np.sin(np.pi * inside**1.3) - 3.5 * inside**3 + 1.5 * inside
    thickness = c.brow_thickness * (1 - inside**2.5) * (0.55 + 0.45 * _step(inside - 0.15, 0.15)) + 0.6
    brow = _step(thickness / 2 - np.abs(y - middle) + 0.5 * hairs, 1.0 + blur)
    brow *= _step(along * c.brow_length, 2.0 + blur) * _step((1 - along) * c.brow_length, 3.0 + blur) * c.brow_density
    cheek_line = -40 - 0.5 * (62 - side)
    jaw = _step(cheek_line - y, 12.0) * _step(side - 14, 8.0) + _step(-84 - y, 6.0)
    moustache = _step(26 - side, 6.0) * _step(-50 - y - 0.12 * side, 2.5) * _step(y + 66 + 0.28 * side, 3.0)
    beside = _step(side - 21, 3.0) * _step(34 - side, 4.0) * _step(-58 - y, 4.0)
    chin = np.maximum(_step(-84 - y, 3.0) * _step(26 - side, 6.0), 0.8 * beside * _step(-62 - y, 3.0))
    grain = np.clip(0.85 + 0.3 * hairs, 0, 1.3)
    stubble = c.stubble_density * np.maximum(np.clip(jaw, 0, 1), moustache)
    beard = np.maximum.reduce(
        [c.beard_density * np.clip(jaw, 0, 1), c.moustache_density * moustache, c.chin_beard_density * chin, stubble]
    )
    border = c.fringe - 0.004 * x**2 + 1.2 * hairs
    head = np.maximum(_step(y - border, 2.5), _step(side + 0.8 * hairs - c.temple_hair + 0.12 * (y - 10), 2.0))
    head *= np.where(y > -30, 0.92, 0.0)
    return np.asarray(np.clip(np.maximum.reduce([brow * grain, beard * grain, head]), 0, 1))


def _creases(c: Complexion, x: Array, y: Array, blur: float) -> Array:
    """Return factors that darken nostrils, the mouth line, the lashes and the lids' crease."""
    side = np.abs(x)
    line, upper, lower = lid_margins(x)
    open_eye = _step(side - INNER_CORNER[0], 2.0) * _step(OUTER_CORNER[0] + 1.5 - side, 2.0)
    thin = 0.9**2 + blur**2
    share = 0.9 / np.sqrt(thin)
    lashes = c.lid_line * 1.2 * share * np.exp(-0.5 * (y - upper - 0.4) ** 2 / thin) * open_eye
    lashes += c.lid_line * 0.35 * share * np.exp(-0.5 * (y - lower + 0.3) ** 2 / thin) * open_eye
    crease = 0.2 * np.exp(-0.5 * (y - upper - 3.6) ** 2 / (1.0 + blur**2)) * open_eye
    nostril = 1.4 * _spot(x, y, (7.6, -41.2), 3.0 + 0.3 * blur, 1.5 + 0.3 * blur)
    wing = 0.25 * _spot(x, y, (18.5, -41.0), 1.8 + blur, 4.0)
    mouth = 0.9 * share * np.exp(-0.5 * (y + 69.8 + 1.6 * (x / 25) ** 2) ** 2 / (0.8 * thin)) * _step(25 - side, 4.0)
    fold = 0.25 * c.wrinkles * np.exp(-0.5 * (side - 22 + 0.42 * (y + 48)) ** 2 / (1.6 + blur**2))
    fold *= _step(-40 - y, 4.0) * _step(y + 70, 8.0)
    return np.asarray(np.exp(-(lashes + crease + nostril + wing + mouth + fold)))


def _eyeball(c: Complexion, eye_x: Array, eye_y: Array, x: Array, y: Array, blur: float) -> Array:
    """Return the albedo of sclera, iris and pupil, in the shadow of the lashes."""
    radius = np.hypot(eye_x, eye_y)
    softness = 0.45 + 0.7 * blur
    sclera = SCLERA * (0.55 + 0.45 * c.tone / 0.5)
    iris = c.iris * (1 - 0.5 * _step(radius - 4.9, 0.6 + blur))
    value = sclera + (iris - sclera) * _step(IRIS_RADIUS - radius, softness)
    value += (0.015 - value) * _step(PUPIL_RADIUS - radius, softness)
    line, upper, lower = lid_margins(x)
    shade = 0.5 * np.exp(-np.maximum(upper - y, 0) / 1.2) + 0.15 * np.exp(-np.maximum(y - lower, 0) / 0.8)
    inner = _step(INNER_CORNER[0] + 3.0 - np.abs(x), 1.5 + blur)
    value += inner * (0.75 * c.tone - value)
    return np.asarray(value * (1 - shade))
