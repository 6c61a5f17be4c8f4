"""Placement: by which shift, turn and growth a photograph shows somebody."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from harmonicface.stereo.motion import Matrix


@dataclass(frozen=True)
class Placement:
    """How a photograph shows a person displaced, turned and grown about the middle of the picture.

    Parameters
    ----------
    right, down
        Pixels.
    turn
        Degrees clockwise.
    growth
        0.05 for five percent larger.
    """

    right: float = 0.0
    down: float = 0.0
    turn: float = 0.0
    growth: float = 0.0

    def motion(self, shape: tuple[int, ...]) -> Matrix:
        """Return the (2, 3) motion from pixels of the person's frame, of this shape, to those of the photograph.

        Examples
        --------
        >>> Placement(right=3).motion((96, 84)).tolist()
        [[1.0, 0.0, 3.0], [0.0, 1.0, 0.0]]
        """
        angle = np.radians(self.turn)
        linear = (1 + self.growth) * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        centre = (np.array(shape[:-3:-1]) - 1) / 2
        return np.column_stack([linear, centre - linear @ centre + [self.right, self.down]]) + 0.0

    @classmethod
    def of(cls, motion: Matrix, shape: tuple[int, ...]) -> Placement:
        """Return the placement whose `motion` this is.

        Examples
        --------
        >>> Placement.of(Placement(1, 2, 3, 0.25).motion((96, 84)), (96, 84))
        Placement(right=1.0, down=2.0, turn=3.0, growth=0.25)
        """
        centre = (np.array(shape[:-3:-1]) - 1) / 2
        right, down = (motion @ [*centre, 1.0] - centre).round(9)
        turn, size = np.degrees(np.arctan2(motion[1, 0], motion[0, 0])), np.hypot(motion[0, 0], motion[1, 0])
        return cls(float(right), float(down), float(turn.round(9)), float(size.round(9) - 1))

    @property
    def said(self) -> str:
        """The placement in words.

        Examples
        --------
        >>> Placement(2.5, -1, 3, 0.05).said
        'shifted by 2.5 right and -1.0 down, turned by 3.0 degrees, 5.0 % larger'
        >>> Placement(-0.04, 0, -0.01, -0.0003).said
        'shifted by 0.0 right and 0.0 down, turned by 0.0 degrees, 0.0 % larger'
        """
        # adding 0 makes -0 a 0
        right, down, turn, growth = (
            round(one, 1) + 0.0 for one in (self.right, self.down, self.turn, 100 * self.growth)
        )
        return f"shifted by {right:.1f} right and {down:.1f} down, turned by {turn:.1f} degrees, {growth:.1f} % larger"

    def scaled(self, factor: float) -> Placement:
        """Return the same placement in pixels that are smaller by a factor."""
        return Placement(factor * self.right, factor * self.down, self.turn, self.growth)
