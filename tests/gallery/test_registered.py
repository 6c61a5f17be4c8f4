"""Photographs that show people displaced or turned, and what a gallery makes of them."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.gallery.frame import Frame
from harmonicface.gallery.portrait import Portrait, photographed_template
from harmonicface.gallery.registered import CHARGE, SURE, registered_look
from harmonicface.recognition.placement import Placement

SHAPE = (96, 84)
LAMPS = [[0, 0, 1], [0.5, 0.2, 1], [-0.4, 0.3, 1]]
PEOPLE = {str(seed): hf.synthetic_person(seed, SHAPE) for seed in range(6)}


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


PHOTO = hf.render(PEOPLE["3"], hf.lights.directional([0.7, -0.2, 0.6])).astype(np.float32)


@pytest.mark.parametrize(
    "placement",
    [
        Placement(),
        Placement(2, -3),
        Placement(7, -5),
        Placement(0.5, 0.5),
        Placement(0, 0, 6),
        Placement(-2, 1, -5),
        Placement(0, 0, 0, 0.06),
        Placement(3, 0, 4, -0.05),
    ],
    ids=str,
)
def test_a_match_tells_how_the_photograph_shows_whom(gallery: hf.Gallery, placement: Placement) -> None:
    found = gallery.match(seen_at(PHOTO, placement))
    assert found.name == "3"
    assert found.motion is not None
    assert_allclose([found.motion.right, found.motion.down], [placement.right, placement.down], atol=0.4)
    assert_allclose([found.motion.turn, 100 * found.motion.growth], [placement.turn, 100 * placement.growth], atol=0.7)
    assert_allclose(found.candidates[0].shift, [placement.right, placement.down], atol=1.1)


def test_turned_photographs_score_nearly_as_those_at_rest(gallery: hf.Gallery) -> None:
    moved, rest = (gallery.match(seen_at(PHOTO, one)).candidates[0] for one in (Placement(3, 4, 6, 0.05), Placement()))
    assert moved.score is not None
    assert rest.score is not None
    assert moved.score > SURE
    assert moved.score + CHARGE > 0.6 * rest.score


def test_the_light_and_the_explanation_are_those_of_the_photograph_as_moved(gallery: hf.Gallery) -> None:
    rest, moved = gallery.match(PHOTO), gallery.match(seen_at(PHOTO, Placement(0, 0, 6)))
    assert rest.light is not None
    assert moved.light is not None
    cosine = rest.light.values @ moved.light.values
    assert cosine / np.linalg.norm(rest.light.values) / np.linalg.norm(moved.light.values) > 0.95
    residual = moved.explain().residual[10:-10, 10:-10]
    assert np.abs(residual).mean() < 0.1 * PHOTO.mean()


def test_a_search_moves_the_photograph_as_a_match_does(gallery: hf.Gallery) -> None:
    photo = seen_at(PHOTO, Placement(7, 0, 4))
    found, searched = gallery.match(photo, top=6), gallery.search_scores(photo)
    for candidate in found.candidates:
        place = searched.names.index(candidate.name)
        assert_allclose(searched.scores[place], candidate.score)
        assert_allclose(searched.shifts[place], candidate.shift)


def test_shifts_are_in_pixels_of_large_photographs() -> None:
    people = {str(seed): hf.synthetic_person(seed, (192, 168)) for seed in range(4)}
    gallery = hf.Gallery()
    for name, person in people.items():
        gallery.enroll(name, person)
    photo = hf.render(people["2"], hf.lights.directional([0.3, 0.2, 1])).astype(np.float32)
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


def test_strangers_walls_and_somebody_alone_are_left_where_they_are() -> None:
    frame = Frame(np.ones(SHAPE, bool))
    people = [
        Portrait(
            photographed_template([hf.render(one, lamp) for lamp in LAMPS], frame.mask),
            lambda one=one: photos(one),
            frame.mask,
        )
        for one in PEOPLE.values()
    ]
    good = np.ones(frame.pixels, bool)
    stranger = hf.render(hf.synthetic_person(50, SHAPE), [0.3, 0.3, 1])
    turned = seen_at(PHOTO, Placement(0, 0, 6))
    for photo, portraits in (
        (stranger, people),
        (np.ones(SHAPE), people),
        (np.zeros(SHAPE), people),
        (turned, people[3:4]),
    ):
        seen = registered_look(frame, photo.ravel().astype(np.float32), good, portraits)
        assert seen.placement == Placement()
        assert seen.look.scores.max() < SURE


def photos(person: hf.Surface) -> np.ndarray:
    return np.stack([hf.render(person, lamp) for lamp in LAMPS]).astype(np.float32)


def test_models_that_compare_intensities_tell_no_motion() -> None:
    gallery = hf.Gallery(model="harmonic9")
    gallery.enroll("3", PEOPLE["3"])
    assert gallery.match(PHOTO).motion is None


def test_who_is_displaced_out_of_the_shortlist_is_found() -> None:
    people = list(hf.synthetic_people(24, 48, seed=4))
    gallery = hf.Gallery(shortlist=6)
    for index, person in enumerate(people):
        gallery.enroll(str(index), person)
    for index in (3, 11, 20):
        photo = hf.render(people[index], hf.lights.directional([0.5, 0.3, 0.8])).astype(np.float32)
        assert gallery.match(seen_at(photo, Placement(-3, 3))).candidates[0].name == str(index)
