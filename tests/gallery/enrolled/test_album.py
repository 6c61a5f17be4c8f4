"""Portraits that were asked for last stay, within their memory."""

from __future__ import annotations

import numpy as np

import harmonicface as hf
from harmonicface.gallery.enrolled.album import Album
from harmonicface.gallery.enrolled.portrait import Portrait, rendered_template

MASK = np.ones((24, 24), np.bool_)
TEMPLATE = rendered_template(hf.synthetic_person(1, 24), MASK)
IMAGES = np.random.default_rng(0).uniform(0, 1, (2, 24, 24))
ONE = 2 * 2 * 24 * 24 * 4  # bytes of the pictures of one person


def test_the_last_ones_stay() -> None:
    made: list[int] = []

    def portrait(place: int) -> Portrait:
        made.append(place)
        return Portrait(TEMPLATE, lambda: IMAGES, MASK)

    album = Album(portrait, most_bytes=2 * ONE)
    for place in (0, 1, 0, 2):
        assert album[place].pictures is album[place].pictures
    assert (made, album.nbytes) == ([0, 1, 2], 3 * ONE)  # pictures come after their portrait
    assert album[3] is album[3]
    assert album.nbytes == 2 * ONE
    made.clear()
    assert album[0] is album[0]
    assert made == []
    assert album[1] is not None
    assert made == [1]
    album.forget()
    assert album.nbytes == 0


def test_one_that_is_too_large_stays_alone() -> None:
    album = Album(lambda _: Portrait(TEMPLATE, lambda: IMAGES, MASK), most_bytes=1)
    assert album[0].pictures is not None
    assert album[1].pictures is not None
    assert album.nbytes == ONE
