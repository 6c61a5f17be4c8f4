"""Registered: a photograph that shows people displaced or turned is moved to where they are, and looked at again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.gallery.frame import Frame
from harmonicface.gallery.portrait import Portrait
from harmonicface.gallery.second_look import FEWEST_BLOCKS, SecondLook, second_look
from harmonicface.recognition.placement import Placement, placed, placed_nearby
from harmonicface.recognition.render_compare import Photograph
from harmonicface.stereo.motion import seen_through, then

SURE = 9.0  # a score that strangers do not reach: the photograph needs no other place
LEAST_GAIN, USUAL_BLOCKS = 0.02, 56  # in votes, of a photograph with so many blocks: a turn by two degrees
# Deviations that a photograph that was moved must make up for: strangers are then as much alike as without moving. On
# the first five people of Yale B, however turned or grown, 99 of 100 are below 5.5 to 6.
CHARGE = 2.5
WHOLE = 0.99  # of a pixel must be good for it to be good where it is moved to


@dataclass(frozen=True, eq=False)
class Registered:
    """A second look at a photograph as it is, or as seen from where its person is.

    Parameters
    ----------
    look
        The second look, with shifts in pixels of the grid as it was moved.
    photo
        What was looked at.
    pixels, good
        The gallery's pixels of it, and which are good.
    placement
        In pixels of the photograph: how it showed whom it was moved to. At rest if it was not.
    """

    look: SecondLook
    photo: Photograph
    pixels: Floats
    good: NDArray[np.bool_]
    placement: Placement

    @property
    def score(self) -> float:
        """The best person's."""
        return float(self.look.scores.max())

    @property
    def sure(self) -> bool:
        """Whether there is no need to look elsewhere: somebody is found, or there is nothing to find."""
        return len(self.look.patterns) == 1 or self.look.blocks < FEWEST_BLOCKS or self.score >= SURE

    def shift(self, index: int, shape: tuple[int, int]) -> tuple[float, float]:
        """Return by how many pixels of a photograph of this shape a person is displaced to the right and down."""
        found = self._placed(Placement(*(float(one) for one in self.look.shifts[index])), shape)
        return found.right, found.down

    def shift_seen(self, index: int, shape: tuple[int, int]) -> tuple[float, float]:
        """Return the same of the photograph as it was looked at."""
        right, down = shape[0] / self.photo.patterns.shape[1] * self.look.shifts[index]
        return float(right), float(down)

    def motion(self, index: int, person: Portrait, shape: tuple[int, int]) -> Placement:
        """Return how a photograph of this shape shows a person, to fractions of a pixel."""
        right, down = (int(one) for one in self.look.shifts[index])
        return self._placed(placed_nearby(self.photo.patterns, person.template, (right, down)), shape)

    def _placed(self, on_grid: Placement, shape: tuple[int, int]) -> Placement:
        """Return a placement in what was looked at as one in the photograph as it was."""
        found = on_grid.scaled(shape[0] / self.photo.patterns.shape[1]).motion(shape)
        return Placement.of(then(found, self.placement.motion(shape)), shape)


def registered_look(frame: Frame, pixels: Floats, good: NDArray[np.bool_], people: Sequence[Portrait]) -> Registered:
    """Look at a photograph, and if it resembles nobody for sure, once more as seen from where it shows somebody.

    Whom it may show displaced, turned or grown is found by votes (`placed`), and it is moved by the motion with the
    most of them, if that is none of the small shifts that a second look tries anyway. Everybody is then compared with
    it as moved, so that strangers gain what she gains, and all scores are charged for the choice; the look with the
    higher score counts. With one person there are no strangers to say what chance finds elsewhere, so she is looked for
    as she is.

    Parameters
    ----------
    frame
        The gallery's.
    pixels
        (p,) the photograph's, inside the frame.
    good
        (p,) booleans: which of them are good.
    people
        The shortlist.
    """
    photo = _photograph(frame, pixels, good)
    first = Registered(second_look(photo, people), photo, pixels, good, Placement())
    if first.sure:
        return first
    best = placed(photo.patterns, [person.template for person in people])
    if best.gain < LEAST_GAIN * np.sqrt(USUAL_BLOCKS / first.look.blocks):
        return first
    placement = best.placement.scaled(frame.shape[0] / photo.patterns.shape[1])
    moved, seen = _moved(frame, pixels, good, placement)
    photo = _photograph(frame, moved, seen)
    again = Registered(replace(second_look(photo, people), charge=CHARGE), photo, moved, seen, placement)
    return again if again.score > first.score else first


def _photograph(frame: Frame, pixels: Floats, good: NDArray[np.bool_]) -> Photograph:
    """Return a photograph to be compared; what is outside the frame is not seen."""
    seen = frame.mask.copy()
    seen[frame.mask] = good
    return Photograph(frame.picture(pixels), seen)


def _moved(
    frame: Frame, pixels: Floats, good: NDArray[np.bool_], placement: Placement
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return pixels as seen from a placement, and which are good; beyond the photograph its border is repeated."""
    motion = placement.motion(frame.shape)
    picture = seen_through(np.asarray(frame.picture(pixels), np.float32), motion)
    seen = seen_through(np.asarray(frame.picture(good.astype(np.float32)), np.float32), motion) > WHOLE
    return picture[frame.mask], seen[frame.mask]
