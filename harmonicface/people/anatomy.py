"""The mean head: its outline and the relief of brow, eyes, nose, cheeks, mouth and chin, in millimetres."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline, PchipInterpolator

Array = NDArray[np.float64]

# Millimetres in a frame with its origin midway between the eyeballs: x to the viewer's right, y up, z to the camera.
# The numbers below are a least-squares fit of this description to the neutral head of ICT-FaceKit (USC ICT Vision and
# Graphics Lab, MIT licence); the fit's normals are 2 degrees off on average.
EYE = np.array([31.3, -0.9, 1.1])  # centre of the eyeball on the viewer's right
EYEBALL_RADIUS = 13.2
LID_RADIUS = 14.1
MOUTH = np.array([0.0, -69.6])  # middle of the line between the lips
INNER_CORNER = np.array([17.6, -3.9])  # of the eye
OUTER_CORNER = np.array([45.0, -1.6])

HEIGHTS = np.array([-122.0, -105.0, -85.0, -60.0, -30.0, 0.0, 30.0, 56.0])  # of the horizontal sections below
HALF_WIDTH = np.array([25.6, 46.5, 60.6, 69.3, 79.3, 80.8, 80.9, 78.3])
HALF_DEPTH = np.array([66.7, 92.2, 87.1, 103.5, 106.9, 107.8, 97.1, 111.4])
PROFILE = np.array([-2.4, 33.5, 27.5, 26.2, 24.7, 26.6, 24.2, 17.8])  # z of the midline without relief

OUTLINE_HEIGHTS = np.array([-117.5, -116.5, -113.0, -106.0, -98.0, -90.0, -80.0, -60.0, -30.0, 0.0, 30.0, 64.0])
OUTLINE = np.array([0.0, 10.0, 21.0, 35.5, 45.0, 51.5, 57.5, 67.0, 78.0, 80.3, 80.3, 77.0])  # from chin to temple


@dataclass(frozen=True)
class Relief:
    """A smooth rise or hollow of the face; one that is not on the midline stands for a pair."""

    name: str
    x: float  # centre, mm
    y: float
    wide: float  # standard deviation along its long axis, mm
    tall: float
    tilt: float  # radians, counter-clockwise
    height: float  # mm toward the camera
    bow: float = 0.0  # curvature of the axis, 1 / mm

    def __call__(self, x: Array, y: Array) -> Array:
        """Return the height at points of the frontal plane."""
        result = self._side(x, y)
        return result + self._side(-x, y) if self.x else result

    def _side(self, x: Array, y: Array) -> Array:
        across = x - self.x
        up = y - self.y - self.bow * across**2
        c, s = np.cos(self.tilt), np.sin(self.tilt)
        a, b = (c * across + s * up) / self.wide, (c * up - s * across) / self.tall
        return np.asarray(self.height * np.exp(-0.5 * (a * a + b * b)))


RELIEFS = (
    Relief("glabella", 0.0, 22.5, 15.1, 8.2, 0.00, -1.1, -0.006),
    Relief("frontal eminence", 31.8, 49.7, 16.7, 14.3, 0.05, 2.2),
    Relief("brow ridge", 26.0, 23.2, 18.9, 9.6, -0.05, 4.3),
    Relief("brow ridge tail", 50.1, 13.8, 9.6, 6.9, -0.61, 7.2),
    Relief("nose root", 0.0, 2.3, 9.1, 5.5, 0.00, 2.2, -0.003),
    Relief("nose root side", 10.6, -10.0, 7.1, 7.8, -0.01, -1.8),
    Relief("temple", 69.3, 29.4, 6.5, 19.8, 0.05, -5.9),
    Relief("orbit", 30.0, 3.4, 17.0, 8.4, 0.01, 0.2),
    Relief("inner orbit", 17.3, -2.3, 9.9, 7.8, -0.19, -10.8),
    Relief("outer orbit", 48.9, 1.5, 5.2, 10.2, 0.27, -3.5),
    Relief("orbital rim", 49.2, 3.5, 8.4, 5.5, -0.03, 3.3),
    Relief("upper lid fold", 24.0, 8.9, 9.0, 3.9, 0.25, -3.2),
    Relief("lower lid", 27.9, -7.2, 11.4, 2.1, -0.09, 1.5),
    Relief("lower lid furrow", 27.9, -15.0, 15.1, 4.8, 0.06, -1.2),
    Relief("tear trough", 22.4, -19.6, 10.3, 5.4, -0.31, -1.8),
    Relief("nose bridge", 0.0, -8.2, 9.5, 6.9, 0.00, 9.2, -0.046),
    Relief("nose dorsum", 0.0, -24.0, 7.5, 8.5, 0.00, 17.8),
    Relief("supratip", 0.0, -32.7, 4.0, 3.7, 0.00, -11.2, -0.015),
    Relief("nose tip", 0.0, -34.1, 7.7, 5.2, 0.00, 25.7, -0.017),
    Relief("nose wall", 12.0, -33.1, 2.8, 9.3, 0.42, 8.4),
    Relief("columella", 0.0, -42.0, 6.4, 2.2, 0.00, 6.6, 0.036),
    Relief("nose wing", 16.7, -37.5, 1.3, 4.2, 0.29, 5.4),
    Relief("wing groove", 18.6, -41.1, 1.3, 3.0, -0.06, -4.9),
    Relief("nostril", 8.1, -40.5, 2.4, 1.3, 0.43, -10.0),
    Relief("nostril sill", 9.1, -46.4, 7.2, 1.6, -0.01, 0.4),
    Relief("wing base", 16.9, -46.0, 3.4, 2.3, 0.27, -3.0),
    Relief("nose base", 0.0, -48.2, 7.4, 3.8, 0.00, 3.1, -0.013),
    Relief("cheekbone", 54.4, -26.7, 18.9, 12.2, 0.51, 8.8),
    Relief("malar pad", 39.5, -28.3, 13.1, 10.7, 0.45, -2.5),
    Relief("cheek", 46.2, -58.5, 11.1, 17.9, -0.18, 7.9),
    Relief("masseter", 63.3, -59.1, 7.7, 22.4, -0.04, 11.3),
    Relief("nasolabial fold", 26.7, -48.6, 6.2, 13.4, 0.60, -3.6),
    Relief("nasolabial mound", 29.2, -49.5, 5.6, 13.0, 0.16, 2.5),
    Relief("muzzle", 0.0, -64.2, 24.5, 16.1, 0.00, 8.4, -0.005),
    Relief("philtrum", 0.0, -54.5, 2.8, 4.5, 0.00, -1.2),
    Relief("philtral ridge", 5.3, -55.2, 5.3, 6.0, -0.02, 1.7),
    Relief("upper lip border", 11.0, -61.0, 9.3, 4.2, 0.03, 2.4),
    Relief("upper lip", 6.9, -64.8, 6.1, 1.4, -0.29, 0.2),
    Relief("upper lip wing", 17.2, -66.1, 5.2, 2.7, -0.48, 1.4),
    Relief("upper lip tubercle", 0.0, -66.0, 5.2, 4.0, 0.00, 1.5, -0.002),
    Relief("mouth line", 0.0, -69.6, 14.0, 1.3, 0.00, -2.2, -0.001),
    Relief("mouth line end", 21.1, -71.2, 3.3, 1.3, -0.11, -2.3),
    Relief("mouth corner", 23.3, -73.0, 6.4, 3.0, -0.32, -2.5),
    Relief("modiolus", 33.1, -74.2, 4.6, 7.8, 0.06, 0.3),
    Relief("lower lip", 0.0, -76.2, 15.0, 3.2, 0.00, 3.0, 0.002),
    Relief("lower lip pad", 10.1, -77.5, 6.6, 5.6, -0.02, 1.9),
    Relief("lower lip border", 0.0, -80.0, 11.9, 2.4, 0.00, 1.8, -0.005),
    Relief("mentolabial furrow", 0.0, -88.7, 15.2, 3.7, 0.00, -1.1, -0.008),
    Relief("lateral chin", 21.0, -89.0, 6.6, 6.9, 0.01, 1.7),
    Relief("chin pad", 10.4, -100.5, 7.0, 8.9, -0.01, 0.9),
    Relief("chin underside", 0.0, -103.5, 16.8, 9.8, 0.00, -4.5, 0.022),
    Relief("prejowl hollow", 30.6, -96.6, 13.8, 9.3, 0.10, -5.2),
    Relief("jaw body", 43.5, -87.0, 12.1, 10.9, 0.00, 0.9),
)


@cache
def _sections() -> tuple[Any, Any, Any, Any]:
    """Return the curves of half width, half depth, midline profile and outline over height."""
    return (
        CubicSpline(HEIGHTS, HALF_WIDTH),
        CubicSpline(HEIGHTS, HALF_DEPTH),
        CubicSpline(HEIGHTS, PROFILE),
        PchipInterpolator(OUTLINE_HEIGHTS, OUTLINE),
    )


def outline(y: ArrayLike) -> Array:
    """Return half the width of the visible face at heights in mm, from the chin (-117.5) up."""
    return np.asarray(_sections()[3](y))


def face_depth(x: Array, y: Array) -> Array:
    """Return the z of the mean face's skin, the eyes closed, over points of the frontal plane in mm.

    Each horizontal section is half an ellipse; the reliefs add to it, and the lids lie on a sphere around the eyeball.
    """
    width, depth, profile, _ = _sections()
    section = np.sqrt(np.clip(1 - (x / width(y)) ** 2, 0.03, 1))
    skin = profile(y) - depth(y) * (1 - section) + sum(relief(x, y) for relief in RELIEFS)
    return _smooth_maximum(skin, _lid_sphere(x, y), 0.55)


def _lid_sphere(x: Array, y: Array) -> Array:
    """Return the z of the spheres on which the eyelids lie; far below the skin elsewhere."""
    squared = LID_RADIUS**2 - (np.abs(x) - EYE[0]) ** 2 - (y - EYE[1]) ** 2
    return np.where(squared > 4, EYE[2] + np.sqrt(np.maximum(squared, 0)), -60.0)


def _smooth_maximum(a: Array, b: Array, radius: float) -> Array:
    """Return the larger of two heights, the crease between them rounded off."""
    return np.asarray(np.maximum(a, b) + radius * np.log1p(np.exp(-np.abs(a - b) / radius)))


def lid_margins(x: Array) -> tuple[Array, Array, Array]:
    """Return the heights of the line between the eye's corners, of the upper and of the lower lid's margin at x."""
    across = (np.abs(x) - INNER_CORNER[0]) / (OUTER_CORNER[0] - INNER_CORNER[0])
    inside = np.clip(across, 0, 1)
    line = INNER_CORNER[1] + np.clip(across, -0.4, 1.4) * (OUTER_CORNER[1] - INNER_CORNER[1])
    upper = 5.9 * np.sin(np.pi * inside**0.9) ** 0.85
    lower = 3.3 * np.sin(np.pi * inside**1.2) ** 0.9
    return line, line + upper, line - lower
