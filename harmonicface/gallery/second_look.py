"""A second look at the shortlist: local patterns, and each person lit as the photograph is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface.gallery.portrait import Portrait
from harmonicface.recognition.fusion import fused, standardized
from harmonicface.recognition.patterns import similarity
from harmonicface.recognition.render_compare import Photograph

# By how much strangers' likenesses differ with so many blocks; their surprises differ by 1, by construction. Measured
# on the first five people of Yale B; it counts where a gallery has few people of its own to measure it by.
USUAL_BLOCKS = 56
USUAL_PATTERNS = 0.013
USUAL_RENDERED = 0.021


@dataclass(frozen=True, eq=False)
class SecondLook:
    """How much a photograph resembles each of n people.

    Parameters
    ----------
    scores
        (n,) deviations above strangers, larger is more alike.
    likenesses
        (n,) mean correlation of blocks of local patterns, of the photograph and of the person lit as it is.
    shifts
        (n, 2) pixels of the grid to the right and down by which the photograph shows her displaced.
    blocks
        Of how many blocks the photograph has a pattern.
    """

    scores: NDArray[np.float64]
    likenesses: NDArray[np.float64]
    shifts: NDArray[np.int64]
    blocks: int


def second_look(photo: Photograph, people: Sequence[Portrait]) -> SecondLook:
    """Compare a photograph with people in three ways and fuse them.

    1. Its local patterns with each person's template, at all small shifts.
    2. Her pictures are combined to explain its detail, where they are and where (1) found her. The logarithm of the F
       statistic of this regression says how much better than a stranger's they do.
    3. The combination is a picture of her in the photograph's light: its local patterns with the photograph's.

    Each measure is standardized by the others in the list, and the three are added (Stouffer). A gallery in which
    everybody is one photograph has no light to change: there (1) is all.

    Parameters
    ----------
    photo
        What is asked.
    people
        At least one, all on the photograph's grid.
    """
    seen = similarity(photo.patterns, [person.template for person in people])
    scale = np.sqrt(USUAL_BLOCKS / max(seen.blocks, 1))
    by_patterns = standardized(seen.scores, USUAL_PATTERNS * scale)
    if all(len(person.pictures.light) == 1 for person in people):
        return SecondLook(by_patterns, seen.scores.astype(np.float64), seen.shifts, seen.blocks)
    places = [(0, 0), *((int(right), int(down)) for right, down in seen.shifts)]
    fits = [
        photo.explained(person.pictures, (places[0], place)) for person, place in zip(people, places[1:], strict=True)
    ]
    likenesses = photo.likeness([fit.picture for fit in fits]).astype(np.float64)
    by_fit = standardized(np.array([fit.surprise for fit in fits]), 1.0)
    scores = fused([by_patterns, by_fit, standardized(likenesses, USUAL_RENDERED * scale)])
    return SecondLook(scores, likenesses, np.array([fit.shift for fit in fits]), seen.blocks)
