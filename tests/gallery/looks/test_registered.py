"""Photographs that show people displaced, turned or grown, and what a gallery makes of them."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.gallery.looks import registered
from harmonicface.gallery.looks.registered import CHARGE, looked_at
from harmonicface.recognition.placement import Placement
from harmonicface.stereo.motion import STILL

SHAPE = (96, 84)
PEOPLE = {str(seed): hf.synthetic_person(seed, SHAPE) for seed in range(6)}
PHOTO = hf.render(PEOPLE["3"], hf.lights.directional([0.7, -0.2, 0.6])).astype(np.float32)
STRANGER = hf.render(hf.synthetic_person(50, SHAPE), hf.lights.directional([0.3, 0.3, 1])).astype(np.float32)


def seen_at(photo: np.ndarray, placement: Placement) -> np.ndarray:
    """Return a photograph that shows its person there; its border is repeated."""
    moved = cv2.warpAffine(
        photo, placement.motion(photo.shape), photo.shape[::-1], flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE
    )
    return np.maximum(moved, 0)


@pytest.fixture(scope="module")
def gallery() -> hf.Gallery:
    found = hf.Gallery()
    for name, person in PEOPLE.items():
        found.enroll(name, person)
    return found


@pytest.fixture
def never_moved(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forbid to look elsewhere."""

    def fail(*_: object) -> None:
        raise AssertionError("somebody was looked for elsewhere")

    monkeypatch.setattr(registered, "placed", fail)


@pytest.mark.parametrize(
    "placement",
    [
        Placement(),
        Placement(2, -3),
        Placement(7, -5),
        Placement(0.5, 0.5),
        Placement(0, 0, 10),
        Placement(-2, 1, -5),
        Placement(0, 0, 0, 0.1),
        Placement(0, 0, 0, -0.1),
        Placement(3, 0, 4, -0.05),
    ],
    ids=str,
)
def test_a_match_tells_how_the_photograph_shows_whom(gallery: hf.Gallery, placement: Placement) -> None:
    found = gallery.match(seen_at(PHOTO, placement))
    assert found.name == "3"
    assert found.motion is not None and found.motion is found.motion
    assert_allclose([found.motion.right, found.motion.down], [placement.right, placement.down], atol=0.4)
    assert_allclose([found.motion.turn, 100 * found.motion.growth], [placement.turn, 100 * placement.growth], atol=0.7)
    if placement.turn == placement.growth == 0:
        assert_allclose(found.candidates[0].shift, [placement.right, placement.down], atol=0.6)


@pytest.mark.usefixtures("never_moved")
def test_who_is_named_at_rest_is_not_looked_for_elsewhere(gallery: hf.Gallery) -> None:
    for photo in (PHOTO, seen_at(PHOTO, Placement(4, -3))):
        assert gallery.match(photo).name == "3"


@pytest.mark.usefixtures("never_moved")
def test_walls_darkness_and_saturation_are_not_looked_at_elsewhere(gallery: hf.Gallery) -> None:
    for photo in (np.ones(SHAPE), np.zeros(SHAPE)):
        assert gallery.match(photo).name is None


@pytest.mark.usefixtures("never_moved")
def test_somebody_alone_is_looked_for_where_she_is() -> None:
    alone = hf.Gallery()
    alone.enroll("3", PEOPLE["3"])
    assert alone.match(seen_at(PHOTO, Placement(0, 0, 8))).name is None


def test_scores_of_moved_photographs_are_charged_and_nearly_as_those_at_rest(gallery: hf.Gallery) -> None:
    moved, rest = (gallery.match(seen_at(PHOTO, one)).candidates[0] for one in (Placement(3, 4, 6, 0.05), Placement()))
    assert moved.score is not None and rest.score is not None
    assert 0.6 * rest.score < moved.score + CHARGE < 1.1 * rest.score


def test_where_nobody_is_then_named_the_photograph_stays_as_it_is(gallery: hf.Gallery) -> None:
    turned = seen_at(STRANGER, Placement(0, 0, 6))
    people, asked = gallery._people, gallery._people.asked(turned, None)
    rest = looked_at(people, asked, np.arange(len(people))).verdict
    found = gallery.match(turned, top=6)
    assert found.name is None
    assert [candidate.score for candidate in found.candidates] == sorted(rest.scores.tolist(), reverse=True)


def test_who_nearly_coincides_with_somebody_is_not_moved_to_be_the_other(
    gallery: hf.Gallery, monkeypatch: pytest.MonkeyPatch
) -> None:
    turned = seen_at(PHOTO, Placement(7, -5, 8))
    people, asked = gallery._people, gallery._people.asked(turned, None)
    everybody = np.arange(len(people))
    assert registered.registered_look(people, asked, everybody, 6, 6.0).motion is not STILL
    monkeypatch.setattr(registered.Looked, "nearest", 0.3)  # as if somebody had been as much alike at rest
    found = registered.registered_look(people, asked, everybody, 6, 6.0)
    assert found.motion is STILL and found.verdict.scores.max() < 6


def test_the_light_and_the_explanation_are_those_of_the_photograph(gallery: hf.Gallery) -> None:
    turned = seen_at(PHOTO, Placement(7, -5, 8))
    rest, moved = gallery.match(PHOTO), gallery.match(turned)
    assert rest.light is not None and moved.light is not None
    cosine = rest.light.values @ moved.light.values
    assert cosine / np.linalg.norm(rest.light.values) / np.linalg.norm(moved.light.values) > 0.95
    explained = moved.explain()
    assert_allclose(explained.reconstruction + explained.residual, turned, atol=1e-6)  # in the photograph's own pixels
    assert np.abs(explained.residual[12:-12, 12:-12]).mean() < 0.1 * PHOTO.mean()


def test_who_is_named_though_she_is_turned_is_explained_where_she_is(gallery: hf.Gallery) -> None:
    turned = seen_at(PHOTO, Placement(0, 0, 6))
    match = gallery.match(turned)
    assert match.evidence is not None and match.evidence.where is not None
    whole = match.evidence.explanation()
    errors = [np.linalg.norm(one.residual[12:-12, 12:-12]) for one in (match.explain(), whole)]
    assert errors[0] < 0.8 * errors[1]


def test_shifts_are_in_pixels_of_large_photographs() -> None:
    gallery = hf.Gallery()
    for seed in range(4):
        gallery.enroll(str(seed), hf.synthetic_person(seed, (192, 168)))
    light = hf.lights.directional([0.3, 0.2, 1])
    photo = hf.render(hf.synthetic_person(2, (192, 168)), light).astype(np.float32)
    for placement in (Placement(3, -4), Placement(15, 12, 3)):
        found = gallery.match(seen_at(photo, placement))
        assert found.name == "2"
        assert found.motion is not None
        assert_allclose([found.motion.right, found.motion.down], [placement.right, placement.down], atol=0.8)


def test_what_is_outside_the_mask_is_not_seen_where_it_is_moved_to() -> None:
    mask = np.ones(SHAPE, bool)
    mask[:, :12] = False
    gallery = hf.Gallery(mask=mask)
    for name, person in PEOPLE.items():
        gallery.enroll(name, person)
    photo = seen_at(PHOTO, Placement(0, 0, 6))
    photo[:, :12] = np.random.default_rng(0).uniform(0, 1, (96, 12))
    assert gallery.match(photo).name == "3"


def test_models_that_compare_intensities_tell_no_motion() -> None:
    gallery = hf.Gallery(model="harmonic9")
    gallery.enroll("3", PEOPLE["3"])
    assert gallery.match(PHOTO).motion is None


def test_who_is_displaced_out_of_the_shortlist_is_found() -> None:
    people = list(hf.synthetic_people(24, 48, seed=4))
    gallery = hf.Gallery(shortlist=6, threshold=4)
    for index, person in enumerate(people):
        gallery.enroll(str(index), person)
    for index in (3, 11, 20):
        photo = hf.render(people[index], hf.lights.directional([0.5, 0.3, 0.8])).astype(np.float32)
        assert gallery.match(seen_at(photo, Placement(-3, 3))).name == str(index)
