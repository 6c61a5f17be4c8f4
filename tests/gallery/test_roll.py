"""Roll: several people are taken out at once, or none of them."""

from __future__ import annotations

import pytest

import harmonicface as hf
from harmonicface.errors import HarmonicFaceError

NAMES = ("ada", "emmy", "sofia", "maria")
PEOPLE = tuple(hf.synthetic_people(len(NAMES), 24, seed=1))


@pytest.fixture(params=["in memory", "in a folder"])
def gallery(request, tmp_path) -> hf.Gallery:
    gallery = hf.Gallery.create(tmp_path / "people") if request.param == "in a folder" else hf.Gallery()
    for name, person in zip(NAMES, PEOPLE, strict=True):
        gallery.enroll(name, person)
    return gallery


def test_several_are_removed_at_once(gallery) -> None:
    gallery.remove(name for name in ("maria", "ada"))
    assert gallery.names == ("emmy", "sofia")
    gallery.remove([])
    gallery.remove("emmy")
    assert gallery.names == ("sofia",)
    photo = hf.render(PEOPLE[2], hf.lights.directional([1, 1, 2]))
    assert [one.name for one in gallery.match(photo).candidates] == ["sofia"]


@pytest.mark.parametrize(
    ("names", "reason"),
    [
        (["ada", "eve"], "expected somebody in the gallery, got 'eve'"),
        (["ada", "ada"], "expected each name once, got 2 of 1 people"),
        (["ada", 3], "remove: expected names, got list"),
        (None, "remove: expected names, got NoneType"),
    ],
)
def test_nobody_is_removed_if_one_cannot_be(gallery, names, reason) -> None:
    with pytest.raises(HarmonicFaceError, match=reason):
        gallery.remove(names)
    assert gallery.names == NAMES


@pytest.mark.parametrize(
    ("people", "got"),
    [
        (lambda: 3, "int 3"),
        (lambda: [("eve", PEOPLE[0]), PEOPLE[1]], "Surface "),
        (lambda: [("eve", PEOPLE[0]), ("mary", PEOPLE[1], PEOPLE[2])], "tuple "),
        (lambda: {"ab": PEOPLE[0]}, "str 'ab'"),
    ],
)
def test_what_is_no_pair_is_not_enrolled(gallery, people, got) -> None:
    with pytest.raises(HarmonicFaceError, match=f"people: expected pairs of a name and a source, got {got}"):
        gallery.enroll_many(people())
    before = ("eve",) if isinstance(people(), list) else ()
    assert gallery.names == NAMES + before
