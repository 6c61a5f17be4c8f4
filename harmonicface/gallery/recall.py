"""Recall of stage one: how often the shortlist misses whom stage two would name among everybody."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.answers import stage_one
from harmonicface.recognition.intervals import Rate, rate

if TYPE_CHECKING:
    from harmonicface.gallery.gallery import Gallery


def missed_by_stage_one(gallery: Gallery, photos: Iterable[ArrayLike]) -> Rate:
    """Return at how many photographs the first of a second look at everybody was outside stage one's shortlist.

    Stage one promises the nearest people by plain projection, exactly; stage two looks at these only. This is what it
    loses by that, apart from what `match` finds elsewhere in the photograph.

    Parameters
    ----------
    gallery
        Of the default model; everybody in it is looked at for every photograph.
    photos
        Each (h, w) or (h, w, 3), as for `Gallery.match`.

    Raises
    ------
    HarmonicFaceError
        A gallery of a model without a shortlist, no photographs, photographs that `match` refuses.

    Examples
    --------
    >>> import harmonicface as hf
    >>> people = [hf.synthetic_person(number, 24) for number in range(6)]
    >>> gallery = hf.Gallery(shortlist=3)
    >>> for number, person in enumerate(people):
    ...     gallery.enroll(str(number), person)
    >>> str(missed_by_stage_one(gallery, [hf.render(person, hf.lights.natural(1)) for person in people]))
    '0 % (0 to 45.9)'
    """
    if not gallery.by_score:
        raise HarmonicFaceError(f"recall: expected a gallery with a shortlist, got one of model {gallery.model}")
    missed = asked = 0
    for photo in photos:
        scores = gallery.search_scores(photo)
        winner = scores.names[int(np.argmax(scores.scores))]
        missed += winner not in listed(gallery, photo)
        asked += 1
    if not asked:
        raise HarmonicFaceError("photos: expected at least one photograph, got none")
    return rate(missed, asked)


def listed(gallery: Gallery, photo: ArrayLike) -> set[str]:
    """Return the names on stage one's shortlist for a photograph; everybody's if they are no more than that."""
    people = gallery._people
    found = stage_one(people, people.asked(photo, None), 1, gallery).found.people
    return {people.name(place) for place in found or range(min(gallery.shortlist, len(people)))}
