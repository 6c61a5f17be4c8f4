"""Hair on the face: the share of the skin that eyebrows, beard and the hair of the head cover, and their strands."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from harmonicface.people.complexion import Complexion
from harmonicface.people.mottling import edge, field_at

Array = NDArray[np.float64]

StrandField = Callable[[NDArray[np.float32], float, float], Array]

STRAND_WIDTH = 1.0  # mm between neighbouring tufts of hair
STRAND_LENGTH = 5.0
BRISTLE_LENGTH = 1.6


def hair_cover(
    complexion: Complexion, x: Array, y: Array, blur: float, field: StrandField | None = None
) -> tuple[Array, Array]:
    """Return the share of hair, 0 to 1, and its lightness by strands, about 0.6 to 1.4, at places in mm, (p,) each.

    The field of strands is that of the frontal plane unless another is given.
    """
    strands_at = field or (lambda knots, across, up: field_at(knots, x, y, across, up))
    fade = float(np.exp(-0.5 * (blur / STRAND_WIDTH) ** 2))
    upright = fade * strands_at(complexion.strands, STRAND_WIDTH, STRAND_LENGTH)
    bristles = fade * strands_at(complexion.strands, STRAND_WIDTH, BRISTLE_LENGTH)
    cover = np.maximum(_beard(complexion, x, y, bristles), _scalp(complexion, x, y, upright, blur))
    cover = np.maximum(cover, _brows(complexion, x, y, blur, fade))
    return cover, np.clip(1 + 0.2 * np.where(y > 0, upright, bristles), 0.5, 1.6)


def _brows(c: Complexion, x: Array, y: Array, blur: float, fade: float) -> Array:
    """Return the cover of the eyebrows: strands that lie down more and more toward the temple."""
    cover = np.zeros_like(x)
    near = np.flatnonzero((np.abs(y - c.brow_height) < 16) & (np.abs(x) < 66))
    x, y = x[near], y[near]
    side = np.abs(x)
    along = (side - c.brow_gap) / c.brow_length
    inside = np.clip(along, 0, 1)
    middle = c.brow_height - 2 + c.brow_arch * np.sin(np.pi * inside**1.25) - 4.5 * inside**3 + 3.0 * inside
    thickness = c.brow_thickness * (1 - inside**2.2) * (0.75 + 0.25 * edge(inside - 0.2, 0.2)) + 0.5
    angle = np.radians(50 - 42 * inside**0.5)
    across_strand = (y - middle) * np.cos(angle) - side * np.sin(angle)
    along_strand = (y - middle) * np.sin(angle) + side * np.cos(angle) + 50 * np.sign(x)
    strands = fade * field_at(c.strands, across_strand, along_strand, STRAND_WIDTH, STRAND_LENGTH)
    height = np.abs(y - middle) / np.where(y > middle, 1.1, 0.9)
    body = edge(thickness / 2 - height + 0.35 * strands, 1.5 + blur) * (0.9 + 0.13 * strands)
    ends = edge((along - 0.04) * c.brow_length + 0.8 * strands, 3.0 + blur) * edge(
        (1 - along) * c.brow_length, 4 + blur
    )
    cover[near] = np.clip(c.brow_density * body * ends, 0, 1)
    return cover


def _beard(c: Complexion, x: Array, y: Array, strands: Array) -> Array:
    """Return the cover of stubble, full beard, moustache and chin beard."""
    cover = np.zeros_like(x)
    low = np.flatnonzero(y < -28)
    x, y, strands = x[low], y[low], strands[low]
    side = np.abs(x)
    ragged = 0.6 * strands
    moustache = (
        edge(-50.5 - y - 0.006 * side**2 + ragged, 4) * edge(y + 63 + 0.01 * side**2, 3) * edge(30 - side + ragged, 8)
    )
    cheek = edge(-44 - 0.9 * (60 - side) - y + ragged, 12) * edge(side - 25, 9)
    below = edge(-82 - y + 0.1 * side + ragged, 5)
    full = np.maximum(np.maximum(cheek, below), moustache * 0.95)
    beside = edge(side - 23, 5) * edge(33 - side + ragged, 7) * edge(-60 - y, 8)
    chin = np.maximum(edge(-84 - y + 0.004 * x**2 + ragged, 6) * edge(30 - side + ragged, 9), 0.85 * beside)
    kinds = (
        c.beard_density * full,
        c.moustache_density * moustache,
        c.chin_beard_density * chin,
        c.stubble_density * full,
    )
    cover[low] = np.clip(np.maximum.reduce(kinds) * (0.9 + 0.15 * strands), 0, 1)
    return cover


def _scalp(c: Complexion, x: Array, y: Array, strands: Array, blur: float) -> Array:
    """Return the cover of a fringe and of the hair at the temples."""
    side = np.abs(x)
    fringe = edge(y - c.fringe + 0.003 * x**2 + 0.8 * strands, 4 + blur)
    temple = edge(side - c.temple_hair + 0.15 * (y - 10) + 1.0 * strands, 3 + blur) * edge(y + 12, 14)
    return np.asarray(0.93 * np.maximum(fringe, temple))
