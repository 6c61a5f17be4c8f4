"""A second look at the shortlist: local patterns, and each person lit as the photograph is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from harmonicface.gallery.enrolled.portrait import Portrait
from harmonicface.recognition.fusion import fused, standardized
from harmonicface.recognition.patterns import similarity
from harmonicface.recognition.render_compare import Photograph

# By how much strangers' likenesses differ with so many blocks; their surprises differ by 1, by construction. It counts
# where a gallery has few people of its own to measure it by. Patterns of the first five people of Yale B differ by
# 0.006, those of synthetic people, who are smoother, by 0.018: with what is between, galleries of two to ten of either
# name about 1 % of strangers or fewer at the default threshold.
USUAL_BLOCKS = 56
USUAL_PATTERNS = 0.009
USUAL_RENDERED = 0.02
USUAL_CLOSENESS = 0.12
NEAREST = 1e-3  # of distances, which rounding does not let be 0
AT_REST = (0, 0)
FEWEST_BLOCKS = 4  # with detail in them: fewer tell nothing
# To the template, of who is named in a gallery of one: the best of 3,200 synthetic strangers reaches 0.29 with 64
# blocks, 0.43 with 25, 0.50 with 16, on real photographs 0.21 with 56.
LEAST_LIKENESS, OF_ONE_BLOCK = 0.14, 1.5  # the second is divided by the root of the number of blocks


@dataclass(frozen=True, eq=False)
class SecondLook:
    """How much a photograph resembles each of n people, in up to four measures, larger for more alike.

    Parameters
    ----------
    patterns
        (n,) mean correlation of blocks of local patterns with each person's template.
    surprises
        (n,) log F of the regression of the photograph's detail on each person's pictures, in its own deviations.
    rendered
        (n,) mean correlation of blocks of local patterns with each person lit as the photograph is.
    closeness
        (n,) minus the logarithm of the distance between the photograph and the span of each person's pictures.
        These three are None where everybody is one photograph, which has no light to change.
    shifts
        (n, 2) pixels of the grid to the right and down by which the photograph shows her displaced.
    blocks
        Of how many blocks the photograph has a pattern.
    charge
        Deviations that are taken off all scores, for the freedom with which the photograph was chosen.
    """

    patterns: NDArray[np.float64]
    surprises: NDArray[np.float64] | None
    rendered: NDArray[np.float64] | None
    closeness: NDArray[np.float64] | None
    shifts: NDArray[np.int64]
    blocks: int
    charge: float = 0.0

    @property
    def likenesses(self) -> NDArray[np.float64]:
        """The likeness that a distance is made of, (n,): of the person lit as the photograph is, if there is one."""
        return self.patterns if self.rendered is None else self.rendered

    @property
    def scores(self) -> NDArray[np.float64]:
        """How many deviations more alike than strangers each person is, (n,): the measures, standardized and fused."""
        scale = np.sqrt(USUAL_BLOCKS / max(self.blocks, 1))
        measures = [standardized(self.patterns, USUAL_PATTERNS * scale)]
        if self.surprises is not None and self.rendered is not None and self.closeness is not None:
            measures.append(standardized(self.surprises, 1.0))
            measures.append(standardized(self.rendered, USUAL_RENDERED * scale))
            measures.append(standardized(self.closeness, USUAL_CLOSENESS))
        return fused(measures) - self.charge

    def without(self, place: int) -> SecondLook:
        """Return the same look as if one of these people were not enrolled."""

        def rest(values: NDArray[np.float64] | None) -> NDArray[np.float64] | None:
            return None if values is None else np.delete(values, place)

        return replace(
            self,
            patterns=np.delete(self.patterns, place),
            surprises=rest(self.surprises),
            rendered=rest(self.rendered),
            closeness=rest(self.closeness),
            shifts=np.delete(self.shifts, place, axis=0),
        )


def second_look(photo: Photograph, people: Sequence[Portrait]) -> SecondLook:
    """Compare a photograph with people in four ways.

    1. Its local patterns with each person's template, at all small shifts.
    2. Her pictures are combined to explain its detail, at rest and where (1) found her. The logarithm of the F
       statistic of this regression says how much better than by chance they do.
    3. The combination is a picture of her in the photograph's light: its local patterns with the photograph's.
    4. The plain projection of the photograph onto her pictures, which sees the coarse shape that detail leaves out.

    In a gallery in which everybody is one photograph, there is no light to change: there (1) is all.

    Parameters
    ----------
    photo
        What is asked.
    people
        At least one, all on the photograph's grid.
    """
    seen = similarity(photo.patterns, [person.template for person in people])
    likenesses = seen.scores.astype(np.float64)
    if all(len(person.pictures.light) == 1 for person in people):
        return SecondLook(likenesses, None, None, None, seen.shifts, seen.blocks)
    places = [(int(right), int(down)) for right, down in seen.shifts]
    fits = [photo.explained(person.pictures, (AT_REST, place)) for person, place in zip(people, places, strict=True)]
    surprises = np.array([fit.surprise for fit in fits])
    rendered = photo.likeness([fit.picture for fit in fits]).astype(np.float64)
    closeness = -np.log(np.maximum([fit.distance for fit in fits], NEAREST))
    return SecondLook(likenesses, surprises, rendered, closeness, np.array([fit.shift for fit in fits]), seen.blocks)


@dataclass(frozen=True, eq=False)
class Verdict:
    """A second look in the photograph's own pixels, and what may be decided on it; made by `judged`.

    Parameters
    ----------
    scores, patterns, distances
        (n,) deviations above strangers; likeness to the template; 1 minus the likeness, 0 to 1.
    shifts
        (n, 2) pixels of the photograph to the right and down.
    order
        (n,) the places of the people, best first; ties keep their order.
    blocks
        Of how many blocks the photograph has a pattern.
    without_second
        The score that the first would have if the second were not enrolled.
    """

    scores: NDArray[np.float64]
    patterns: NDArray[np.float64]
    distances: NDArray[np.float64]
    shifts: NDArray[np.float64]
    order: NDArray[np.intp]
    blocks: int
    without_second: float

    def unknown(self, threshold: float) -> str | None:
        """Return why the first is not named, or None if she is."""
        if self.blocks < FEWEST_BLOCKS:
            return "the photograph has no detail to compare"
        first = self.order[0]
        if len(self.scores) == 1 and self.patterns[first] < LEAST_LIKENESS + OF_ONE_BLOCK / np.sqrt(self.blocks):
            return "she is not alike, and there are no others to know what strangers are like"
        if len(self.scores) > 1 and self.scores[first] < threshold:
            if self.without_second >= threshold:
                return "the first two are too much alike to tell which of them it is"
            return "nobody is more alike than strangers are"
        return None


def judged(look: SecondLook, pixels_of_grid: float) -> Verdict:
    """Put people in order, and shifts into pixels of the photograph."""
    scores = look.scores
    order = np.argsort(-scores, kind="stable")
    return Verdict(
        scores,
        look.patterns,
        np.clip(1 - look.likenesses, 0.0, 1.0),
        (look.shifts * pixels_of_grid).astype(np.float64),
        order,
        look.blocks,
        float(look.without(int(order[1])).scores.max()) if len(order) > 2 else -np.inf,
    )
