"""Where a recognizer crops a face: eyes and mouth of everybody at the same place of the picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface.people.anatomy import EYE, MOUTH

Array = NDArray[np.float64]

FRAME = (-63.0, -110.0, 63.0, 34.0)  # mm: left, bottom, right, top; eyes at (+-31.3, -0.9), mouth at (0, -69.6)


@dataclass(frozen=True, eq=False)
class Alignment:
    """A motion of the picture's plane: turn, scale, shift.

    Parameters
    ----------
    scale
        Above 0; depth is scaled too, so that normals keep their slopes.
    rotation
        (2, 2) rotation matrix.
    shift
        (2,) mm, added after the rotation.
    """

    scale: float
    rotation: Array
    shift: Array

    @classmethod
    def of(cls, eyes: Array, mouth: Array) -> Alignment:
        """Return the motion that brings eyes and mouth to their places best, by least squares (Umeyama 1991).

        Parameters
        ----------
        eyes
            (2, 2) or (2, 3) centres of the eyeballs, the picture's left one first.
        mouth
            (2,) or (3,), the middle of the line between the lips.
        """
        found = np.array([eyes[0, :2], eyes[1, :2], mouth[:2]])
        wanted = np.array([EYE[:2] * (-1, 1), EYE[:2], MOUTH])
        middle, target = found.mean(axis=0), wanted.mean(axis=0)
        a, b = (found - middle) @ (1, 1j), (wanted - target) @ (1, 1j)  # a motion of the plane is one complex factor
        motion = np.vdot(a, b) / np.vdot(a, a).real
        scale, rotation = float(np.abs(motion)), plane_rotation(float(np.angle(motion)))
        return cls(scale, rotation, target - scale * rotation @ middle)

    def disturbed(self, angle: float, shift: Array) -> Alignment:
        """Return the motion followed by a rotation (radians) about the middle of the face and a shift in mm."""
        turn = plane_rotation(angle)
        middle = (2 * EYE[:2] * (0, 1) + MOUTH) / 3
        return Alignment(self.scale, turn @ self.rotation, turn @ (self.shift - middle) + middle + shift)

    def points(self, points: Array) -> Array:
        """Return (n, 3) points after the motion."""
        moved = self.scale * points @ self._turn.T
        moved[:, :2] += self.shift
        return moved

    def normals(self, normals: Array) -> Array:
        """Return (n, 3) normals after the motion."""
        return normals @ self._turn.T

    @property
    def _turn(self) -> Array:
        turn = np.eye(3)
        turn[:2, :2] = self.rotation
        return turn


def plane_rotation(angle: float) -> Array:
    """Return the matrix of a counterclockwise rotation in the plane, angle in radians."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
