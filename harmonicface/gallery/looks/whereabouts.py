"""Whereabouts: where in a photograph somebody was found."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.gallery.frame import Frame
from harmonicface.recognition.patterns import Pattern, Template, patterns
from harmonicface.recognition.placed import placed, placed_nearby
from harmonicface.recognition.placement import Placement
from harmonicface.stereo.motion import Matrix, then


@dataclass(frozen=True, eq=False)
class Whereabouts:
    """Where in a photograph somebody was found.

    Parameters
    ----------
    frame
        The gallery's.
    pixels, good
        (p,) of the photograph, and which of them are good.
    template
        Hers.
    motion
        From pixels of the frame to those of the photograph, as far as it took to name her: with a shift by whole
        pixels of the grid.
    """

    frame: Frame
    pixels: Floats
    good: NDArray[np.bool_]
    template: Template
    motion: Matrix

    def placement(self) -> Placement:
        """Return how the photograph shows her, in its pixels, to fractions of a pixel.

        Her blocks vote for it (`placed`), and once more on the photograph as seen from there.
        """
        shape = self.frame.shape
        on_grid = shape[0] / self.template.shape[0]
        about = placed(self._patterns(self.motion), [self.template]).placement.scaled(on_grid)
        motion = then(about.motion(shape), self.motion)
        rest = placed_nearby(self._patterns(motion), self.template).scaled(on_grid)
        return Placement.of(then(rest.motion(shape), motion), shape)

    def _patterns(self, motion: Matrix) -> Pattern:
        """Return the patterns of the photograph as seen through a motion."""
        pixels, good = self.frame.seen_through(self.pixels, self.good, motion)
        seen = self.frame.mask.copy()
        seen[self.frame.mask] = good
        return patterns(self.frame.picture(pixels), seen if seen.any() else None)
