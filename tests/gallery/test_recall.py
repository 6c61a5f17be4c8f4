"""How often stage one's shortlist misses whom a second look at everybody finds first."""

from __future__ import annotations

import numpy as np
import pytest

import harmonicface as hf
from harmonicface.gallery import recall
from harmonicface.gallery.recall import listed, missed_by_stage_one

PEOPLE = [hf.synthetic_person(number, 24) for number in range(5)]
PHOTOS = [hf.render(person, hf.lights.natural(1)) for person in PEOPLE]


@pytest.fixture(scope="module")
def gallery() -> hf.Gallery:
    found = hf.Gallery(shortlist=2)
    for number, person in enumerate(PEOPLE):
        found.enroll(str(number), person)
    return found


def test_who_is_on_the_list(gallery: hf.Gallery) -> None:
    for photo in PHOTOS:
        nearest = [one.name for one in gallery.within(photo, 1.0)[:2]]
        assert listed(gallery, photo) == set(nearest)
    gallery.shortlist = 9
    assert listed(gallery, PHOTOS[0]) == set(gallery.names)
    gallery.shortlist = 2


def test_whom_the_list_lacks_is_counted(gallery: hf.Gallery, monkeypatch: pytest.MonkeyPatch) -> None:
    winners = [gallery.search_scores(photo).scores.argmax() for photo in PHOTOS]
    assert missed_by_stage_one(gallery, PHOTOS).events == sum(
        str(winner) not in listed(gallery, photo) for winner, photo in zip(winners, PHOTOS, strict=True)
    )
    monkeypatch.setattr(recall, "listed", lambda _, photo: {"0"} if photo is PHOTOS[0] else {"nobody"})
    found = missed_by_stage_one(gallery, PHOTOS)
    assert (found.events, found.trials) == (4 + (winners[0] != 0), 5)


def test_what_has_no_recall(gallery: hf.Gallery) -> None:
    with pytest.raises(hf.HarmonicFaceError, match="photos: expected at least one photograph, got none"):
        missed_by_stage_one(gallery, [])
    with pytest.raises(hf.HarmonicFaceError, match="recall: expected a gallery with a shortlist, got one of model har"):
        missed_by_stage_one(hf.Gallery("harmonic9"), [np.ones((24, 24))])
