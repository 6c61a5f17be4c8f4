"""Rows of the stability table: transport of heights in other units and places, without shadows and with them."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from harmonicface._validate import Floats
from harmonicface.bench.stability.hard_surfaces import ball, nine_images
from harmonicface.bench.stability.row import Answers, Measured, Rows, named, rounded
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.transfer import transport

SIDE = 24
SHADED = 0.2  # of the sky: what a dent that lies in its own shadow loses at least
HIGH = 1e6  # pixels

Transported = Callable[..., Floats]


def of_transports() -> Answers:
    """Return a function for each row."""
    normals, inside = ball(SIDE)
    unshaded = partial(_shaded, normals, np.where(inside, SIDE / 2 * normals[..., 2], np.nan))
    note = "no shadow falls on a ball: expected is the closed form without"
    return {
        **named("transport of a ball", _moved(unshaded, nine_images(normals[inside]), note)),
        **named("transport of a dent", _of_dent()),
    }


def _shaded(normals: Floats, heights: Floats, factor: float = 1.0, ground: float = 0.0) -> Floats:
    """Return the transport of heights in other units, or upon a ground."""
    inside = np.isfinite(heights)
    surface = Surface(normals, np.ones(heights.shape), inside, factor * heights + ground, factor)
    return transport(surface, 2).values


def _moved(shaded: Transported, expected: Floats, note: str) -> Rows:
    rows: Rows = {}
    for factor in (1e-12, 1e12, 1e-100, 1e100):
        rows[f"times {factor:.0e}"] = lambda factor=factor: rounded(shaded(factor), expected, note=note)  # type: ignore[misc]
    whole = f"{note}; condition: the height in pixels"
    rows["upon a height of 1e+06"] = lambda: rounded(shaded(ground=HIGH), expected, HIGH, note=whole)
    return rows


def _of_dent() -> Rows:
    """Return rows of a dent with a bump in it; there is no closed form: in pixels, it has to lie in its own shadow."""
    down, across = np.indices((SIDE, SIDE)) - (SIDE - 1) / 2
    heights = 4 * np.exp(-((down - 3) ** 2 + across**2) / 6) - 9 * np.exp(-(down**2 + across**2) / 50)
    shaded = partial(_shaded, np.tile([0.0, 0.0, 1.0], (SIDE, SIDE, 1)), heights)
    usual = shaded()
    lost = 1 - float(usual[0].min()) * 2 / np.sqrt(np.pi)  # nothing of the whole sky is sqrt(pi) / 2
    if lost < SHADED:
        bright = Measured(np.inf, 0.0, 1.0, f"{lost:.0%} of the sky lost at most: without its shadows")
        return dict.fromkeys(_moved(shaded, usual, ""), lambda: bright)
    return _moved(shaded, usual, f"expected: in pixels, where shadows take {lost:.0%} of the sky at most")
