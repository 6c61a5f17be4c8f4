"""Registered: a photograph that shows people displaced, turned or grown is looked at once more from where they are."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.gallery.enrolled.people import People
from harmonicface.gallery.looks.second_look import FEWEST_BLOCKS, USUAL_BLOCKS, Verdict, judged, second_look
from harmonicface.gallery.looks.whereabouts import Whereabouts
from harmonicface.gallery.search.ranking import displaced_shortlist
from harmonicface.recognition.placed import placed
from harmonicface.recognition.placement import Placement
from harmonicface.recognition.render_compare import Photograph
from harmonicface.stereo.motion import STILL, Matrix, then

ROUNDS = 2  # the first finds turns and growths of up to 8 degrees and percent, the second what is left of larger ones
LEAST_GAIN = 0.01  # in votes, of a photograph with the usual number of blocks: a turn by one degree
# Deviations that a photograph that was moved must make up for: strangers then reach no threshold more often than
# without moving. Chosen on the first five people of Yale B, as they stood, displaced, turned and grown.
CHARGE = 3.0

Asked = tuple[Floats, NDArray[np.bool_]]  # the compared pixels of a photograph, (p,), and which are good


@dataclass(frozen=True, eq=False)
class Looked:
    """A second look at a photograph, as it is or as seen from where it shows somebody.

    Parameters
    ----------
    chosen
        (n,) the people who were looked at, by index.
    verdict
        On them; scores of a photograph that was moved are charged, its shifts are in pixels of it as moved.
    photo
        What was looked at.
    asked
        Its pixels and which are good, as looked at.
    motion
        From pixels of what was looked at to those of the photograph.
    """

    chosen: NDArray[np.intp]
    verdict: Verdict
    photo: Photograph
    asked: Asked
    motion: Matrix

    @property
    def nearest(self) -> float:
        """The smallest distance of anybody."""
        return float(self.verdict.distances.min())

    def shift(self, place: int, shape: tuple[int, int]) -> tuple[float, float]:
        """Return by how many pixels of a photograph of this shape it shows one of these people displaced."""
        right, down = (float(one) for one in self.verdict.shifts[place])
        found = Placement.of(then(Placement(right, down).motion(shape), self.motion), shape)
        return found.right, found.down

    def whereabouts(self, place: int, people: People, asked: Asked) -> Whereabouts:
        """Return where in a photograph one of these people was found."""
        right, down = (round(one) for one in self.verdict.shifts[place].tolist())
        whole = then(Placement(right, down).motion(people.frame.shape), self.motion)
        return Whereabouts(people.frame, *asked, people.portrait(int(self.chosen[place])).template, whole)


def looked_at(
    people: People, asked: Asked, chosen: NDArray[np.intp], motion: Matrix = STILL, charge: float = 0.0
) -> Looked:
    """Look at a photograph as seen through a motion, and judge it.

    Parameters
    ----------
    people
        With portraits.
    asked
        (p,) compared pixels of the photograph, and which are good.
    chosen
        Who is looked at, by index.
    motion
        From pixels of the gallery's frame to those of the photograph.
    charge
        Is taken off all scores.
    """
    seen = asked if motion is STILL else people.frame.seen_through(*asked, motion)
    photo = people.photograph(*seen)
    look = replace(second_look(photo, [people.portrait(place) for place in chosen.tolist()]), charge=charge)
    return Looked(chosen, judged(look, people.pixels_of_grid), photo, seen, motion)


def registered_look(people: People, asked: Asked, chosen: NDArray[np.intp], count: int, threshold: float) -> Looked:
    """Look at a photograph, and if nobody is named, once more as seen from where it shows somebody.

    Whom it may show displaced, turned or grown is found by the votes of blocks (`placed`), once more from there. Each
    time everybody is compared with the photograph as moved, so that strangers gain what she gains, and all scores are
    charged for the choice. It counts if somebody is then named who is more alike than anybody was at rest: between
    people who nearly coincide, moving one could make her the other. Otherwise the photograph is left as it is. With one
    person there are no strangers to say what chance finds elsewhere, so she is looked for where she is.

    Parameters
    ----------
    people, asked
        As for `looked_at`.
    chosen
        Who is looked at where they are.
    count
        At how many people it looks elsewhere.
    threshold
        The score from which the first is named.
    """
    rest = looked_at(people, asked, chosen)
    if rest.verdict.unknown(threshold) is None or len(people) == 1 or rest.verdict.blocks < FEWEST_BLOCKS:
        return rest
    pixels, good = asked
    others = displaced_shortlist(people, people.frame, pixels.astype(np.float64), good, count)
    start = rest if np.array_equal(others, chosen) else looked_at(people, asked, others)
    if start.verdict.unknown(threshold) is None:
        return start
    for look in _looks_elsewhere(start, people, asked):
        if look.verdict.unknown(threshold) is None and look.nearest < min(rest.nearest, start.nearest):
            return _exactly(look, people, asked)
    return rest


def _exactly(look: Looked, people: People, asked: Asked) -> Looked:
    """Return a look from exactly where whom it names is, if she is more alike from there."""
    place = int(look.verdict.order[0])
    motion = look.whereabouts(place, people, asked).placement().motion(people.frame.shape)
    again = looked_at(people, asked, look.chosen, motion, CHARGE)
    better = again.verdict.order[0] == place and again.verdict.scores[place] > look.verdict.scores[place]
    return again if better else look


def _looks_elsewhere(start: Looked, people: People, asked: Asked) -> Iterator[Looked]:
    """Yield looks from where the photograph shows somebody, as long as that is elsewhere."""
    seen, shape = start, people.frame.shape
    for _ in range(ROUNDS):
        found = placed(seen.photo.patterns, [people.portrait(place).template for place in seen.chosen.tolist()])
        if found.gain < LEAST_GAIN * np.sqrt(USUAL_BLOCKS / max(seen.verdict.blocks, 1)):
            return
        further = found.placement.scaled(people.pixels_of_grid).motion(shape)
        seen = looked_at(people, asked, seen.chosen, then(further, seen.motion), CHARGE)
        yield seen
