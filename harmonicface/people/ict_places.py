"""Where the ICT head's vertices lie on the mean face, whose skin the built-in generator knows how to paint."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator, RBFInterpolator

from harmonicface.io.vertex_normals import vertex_normals
from harmonicface.people.anatomy import EYE, INNER_CORNER, OUTER_CORNER, lid_margins
from harmonicface.people.crop import Alignment
from harmonicface.people.ict_model import EYEBALLS, LEFT_EYE, LIPS, RIGHT_EYE, HeadModel
from harmonicface.people.mottling import edge
from harmonicface.people.skin import MOUTH_HALF_WIDTH, lip_margins

Array = NDArray[np.float64]

# Landmarks of Multi-PIE; each eye is its outer and inner corner, two on the upper lid, two on the lower one.
JAW_BROWS_NOSE = slice(0, 36)
EYES = ((36, 39, 37, 38, 40, 41), (45, 42, 44, 43, 47, 46))
MOUTH_CORNERS, UPPER_LIP, LOWER_LIP = (48, 54), slice(49, 54), slice(55, 60)

AXIS = -70.0  # mm: z of the head's upright axis in the mean face's frame
# The hairline around that axis: degrees from the front, and height = share * (height of the fringe) + rest, in mm.
HAIRLINE_ANGLE = np.array([0.0, 40.0, 58.0, 72.0, 80.0, 90.0, 105.0, 118.0, 140.0, 180.0])
HAIRLINE_SHARE = np.array([1.0, 1.0, 0.55, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
HAIRLINE_REST = np.array([0.0, -3.0, 4.0, 12.0, -10.0, -12.0, 0.0, -45.0, -75.0, -85.0])


@dataclass(frozen=True, eq=False)
class HeadPlaces:
    """Places of the vertices that are seen, (n, ...), the same for all people.

    Parameters
    ----------
    points
        (n, 3) mm in the frame of the mean face; lids and lips lie where they lie in the mean face.
    normals
        (n, 3) of the neutral head.
    gaze
        (n, 2) mm across and up from the centre of the eyeball; 0 off the eyes.
    """

    points: Array
    normals: Array
    gaze: Array


def aligned(model: HeadModel, vertices: Array) -> Array:
    """Return a head's vertices, (26719, 3) mm, eyes and mouth where everybody's are and z = 0 near the eyes."""
    eyes = np.stack([_sphere_centre(vertices[eyeball]) for eyeball in EYEBALLS])
    mouth = vertices[model.landmarks[list(LIPS)]].mean(axis=0)
    alignment = Alignment.of(eyes, mouth)
    points = alignment.points(vertices)
    points[:, 2] += EYE[2] - alignment.scale * eyes[:, 2].mean()
    return points


@lru_cache(maxsize=2)
def head_places(model: HeadModel) -> HeadPlaces:
    """Return where the vertices seen lie on the mean face.

    The mean face was fitted to the neutral head, so the two differ by a millimetre or two: lids and lips, which are
    drawn finer than that, are moved by the thin-plate spline that brings their landmarks to the mean face's.
    """
    neutral = aligned(model, model.neutral)
    seen = neutral[model.source]
    landmarks = neutral[model.landmarks]
    shift = RBFInterpolator(landmarks[:60, :2], _wanted(landmarks) - landmarks[:60, :2])(seen[:, :2])
    points = seen.copy()
    points[:, :2] += face_share(seen)[:, None] * shift
    gaze = np.zeros((len(seen), 2))
    for part, eyeball in zip((LEFT_EYE, RIGHT_EYE), EYEBALLS, strict=True):
        own = np.unique(model.faces[model.parts == part])
        gaze[own] = seen[own, :2] - _sphere_centre(neutral[eyeball])[:2]
    return HeadPlaces(points, vertex_normals(seen, model.faces), gaze)


def face_share(points: Array) -> Array:
    """Return 1 on the face, 0 on ears, neck and the back of the head, at (p, 3) places, (p,)."""
    return edge(points[:, 2] + 62, 10) * edge(points[:, 1] + 132, 12)


def ear_share(points: Array) -> Array:
    """Return 1 on the ears, 0 elsewhere, at (p, 3) places, (p,)."""
    x, y, z = np.abs(points[:, 0]), points[:, 1], points[:, 2]
    return edge(x - 75, 3) * edge(4 - y, 4) * edge(y + 66, 5) * edge(-64 - z, 5)


def nostril_share(points: Array) -> Array:
    """Return 1 inside the nostrils, 0 elsewhere, at (p, 3) places, (p,)."""
    inside = (np.abs(points[:, 0]) - 8, points[:, 1] + 35, points[:, 2] - 27)
    return edge(9 - np.hypot.reduce([inside[0] * 9 / 7, inside[1] * 9 / 8.5, inside[2] * 9 / 10]), 1.5)


def above_hairline(points: Array, fringe: float) -> Array:
    """Return by how many mm (p, 3) places lie above the hairline, whose height in front is given, (p,)."""
    angle = np.degrees(np.arctan2(np.abs(points[:, 0]), points[:, 2] - AXIS))
    share, rest = (PchipInterpolator(HAIRLINE_ANGLE, values)(angle) for values in (HAIRLINE_SHARE, HAIRLINE_REST))
    return np.asarray(points[:, 1] - share * fringe - rest)


def _wanted(landmarks: Array) -> Array:
    """Return where the first 60 landmarks lie in the mean face, (60, 2); all but lids and lips stay where they are."""
    wanted = landmarks[:60, :2].copy()
    for outer, inner, *lids in EYES:
        side = np.sign(landmarks[outer, 0])
        wanted[outer], wanted[inner] = OUTER_CORNER * (side, 1), INNER_CORNER * (side, 1)
        span = landmarks[outer, 0] - landmarks[inner, 0]
        across = (landmarks[lids, 0] - landmarks[inner, 0]) / span
        x = wanted[inner, 0] + across * (wanted[outer, 0] - wanted[inner, 0])
        _, upper, lower = lid_margins(x)
        wanted[lids] = np.stack([x, np.where([True, True, False, False], upper, lower)], axis=1)
    corners = list(MOUTH_CORNERS)
    scale = 2 * MOUTH_HALF_WIDTH / np.ptp(landmarks[corners, 0])
    wanted[corners, 0] = MOUTH_HALF_WIDTH * np.array([-1, 1])
    wanted[corners, 1] = lip_margins(wanted[corners, 0])[0]
    for lip, border in ((UPPER_LIP, 1), (LOWER_LIP, 2)):
        x = scale * landmarks[lip, 0]
        wanted[lip] = np.stack([x, lip_margins(x)[border]], axis=1)
    return wanted


def _sphere_centre(points: Array) -> Array:
    """Return the centre of the sphere through points, by least squares."""
    system = np.concatenate([2 * points, np.ones((len(points), 1))], axis=1)
    return np.asarray(np.linalg.lstsq(system, (points**2).sum(axis=1))[0][:3])
