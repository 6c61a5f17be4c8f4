"""Synthetic people under different lights, moved by known amounts."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.ndimage import map_coordinates

import harmonicface as hf
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.motion import then, undone
from harmonicface.stereo.registration import register

SIZE = 144
CORNERS = np.array([[x, y, 1.0] for x in (0, SIZE - 1) for y in (0, SIZE - 1)])


def moved_photographs(person: int, degrees: float) -> tuple[np.ndarray, np.ndarray]:
    """Return seven photographs of a person with noise, and where the pixels of the unmoved one are in each."""
    random = np.random.default_rng(person)
    surface = hf.synthetic_person(person, size=SIZE)
    photographs, motions = [], []
    for number in range(7):
        tilt = np.radians(degrees * random.uniform(0.5, 1)) if number else 0.0
        towards = [np.sin(tilt) * np.cos(number), np.sin(tilt) * np.sin(number), np.cos(tilt)]
        photo = np.clip(0.9 * hf.render(surface, hf.lights.directional(towards)), 0, 1)
        turn, shift = np.radians(random.uniform(-1, 1)), random.uniform(-6, 6, 2)
        if number == 2:
            turn, shift = 0.0, np.zeros(2)
        linear = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        centre = np.full(2, (SIZE - 1) / 2)
        motion = np.column_stack([linear, centre - linear @ centre + shift])
        y, x = np.mgrid[:SIZE, :SIZE]
        back = undone(motion) @ np.stack([x.ravel(), y.ravel(), np.ones(x.size)])
        picture = map_coordinates(photo, [back[1], back[0]], order=3, mode="nearest").reshape(SIZE, SIZE)
        photographs.append(np.clip(picture + random.normal(0, 0.003, picture.shape), 0, 1))
        motions.append(motion)
    return np.array(photographs), np.array(motions)


def corner_errors(found: np.ndarray, true: np.ndarray) -> np.ndarray:
    """Return by how many pixels motions differ at the corners, where rotation counts most, (n, 4)."""
    return np.linalg.norm(CORNERS @ (found - true).transpose(0, 2, 1), axis=2)


@pytest.mark.parametrize(("degrees", "bound"), [(12, 0.4), (40, 1.0)])
def test_known_motions_are_found_under_different_lights(degrees: float, bound: float) -> None:
    errors = []
    for person in range(3):
        photographs, motions = moved_photographs(person, degrees)
        found = register(photographs, reference=2, least=0)
        errors.append(corner_errors(found.motions, motions))
        assert found.reference == 2
    assert np.max(errors) < bound  # of shifts up to 8 pixels and turns up to a degree
    assert np.median(errors) < bound / 3


def test_registered_photographs_show_the_same_points() -> None:
    photographs, motions = moved_photographs(1, 12)
    found = register(photographs, reference=2)
    alike = hf.synthetic_person(1, size=SIZE)
    # a frontal photograph, wherever it was, comes back as the frontal rendering of the person who did not move
    frontal = np.clip(0.9 * hf.render(alike, hf.lights.directional([0, 0, 1])), 0, 1)
    known = found.known[0]
    before = np.abs(photographs[0] - frontal)[known].mean()
    after = np.abs(found.photographs[0] - frontal)[known].mean()
    assert after < before / 4
    assert found.photographs.dtype == np.float32
    assert corner_errors(found.motions[:1], motions[:1]).max() < 0.4


def test_motions_relative_to_another_reference_are_those_between_the_photographs() -> None:
    photographs, _ = moved_photographs(0, 12)
    second, fifth = (register(photographs, reference=index, least=0) for index in (2, 5))
    between = [then(undone(second.motions[5]), motion) for motion in second.motions]
    assert_allclose(fifth.motions, between, atol=1e-9)
    assert_array_equal(fifth.motions[5], np.eye(2, 3))
    assert_array_equal(fifth.photographs[5], photographs[5].astype(np.float32))


def test_one_who_moved_is_brought_back_to_those_who_did_not() -> None:
    random = np.random.default_rng(0)
    skin = random.uniform(0.2, 1, (48, 48))
    photographs = np.stack([np.roll(skin, 4, axis=1), skin, skin, skin])
    found = register(photographs)
    assert found.reference in (1, 2, 3)
    assert_allclose(found.motions[0], [[1, 0, 4], [0, 1, 0]], atol=0.02)
    assert_array_equal(found.known[0][:, :44], True)
    assert not found.known[0][:, 44:].all()


def test_what_light_alone_does_to_a_person_who_holds_still_is_no_motion() -> None:
    surface = hf.synthetic_person(4, size=SIZE)
    lights = [hf.lights.directional(towards) for towards in ([0, 0, 1], [0.2, 0, 1], [0, 0.2, 1], [-0.2, 0, 1])]
    photographs = np.stack([np.clip(hf.render(surface, light), 0, 1) for light in lights])
    found = register(photographs)
    assert_array_equal(found.motions, [np.eye(2, 3)] * 4)
    assert_array_equal(found.photographs, photographs.astype(np.float32))
    assert not (register(photographs, least=0).motions == np.eye(2, 3)).all()


def test_brightness_of_a_photograph_changes_nothing() -> None:
    photographs, _ = moved_photographs(0, 12)
    scale = np.array([1, 3, 0.01, 1, 200, 1, 1])[:, None, None]
    assert_allclose(
        register(scale * photographs, 0, least=0).motions, register(photographs, 0, least=0).motions, atol=1e-3
    )


SKIN = np.random.default_rng(3).uniform(0.1, 1, (3, 32, 32))


@pytest.mark.parametrize(
    ("photographs", "reference", "message"),
    [
        (SKIN[0], None, r"photographs: expected shape \(n, h, w\), got an array of shape \(32, 32\)"),
        (SKIN[:1], None, "photographs: expected at least 2 to register to each other, got 1"),
        (SKIN[:, :15], None, "photographs: expected at least 16 pixels a side, got 15 x 32"),
        (-SKIN, None, "photographs: expected intensities of at least 0, got -"),
        (SKIN * [[[1]], [[0]], [[1]]], None, "photographs: expected contrast, got photograph 1 with 0 everywhere"),
        (np.where(SKIN > 0.9, np.nan, SKIN), None, "photographs: expected finite numbers"),
        (SKIN, 3, "reference: expected an index below 3, got 3"),
        (SKIN, -1, "reference: expected an integer of at least 0, got int -1"),
    ],
)
def test_bad_input(photographs: np.ndarray, reference: int | None, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        register(photographs, reference)


def test_no_negative_dead_zone() -> None:
    with pytest.raises(HarmonicFaceError, match="least: expected a finite number above 0, got -1"):
        register(SKIN, least=-1)


def test_photographs_of_different_things_are_refused() -> None:
    others = np.random.default_rng(1).uniform(0, 1, (3, 96, 96))
    with pytest.raises(HarmonicFaceError, match=r"expected one person, holding nearly still, got photograph \d, whose"):
        register(others)


@pytest.mark.data
def test_people_of_yale_b_moved_most_before_the_first_flash(data_dir) -> None:  # type: ignore[no-untyped-def]
    from harmonicface.datasets.yale_b import load_yale_b

    for person in load_yale_b(data_dir / "yaleb", [3, 11]):
        found = register(person.photographs[person.subsets == 1])
        shifts = np.linalg.norm(found.motions @ [83.5, 95.5, 1] - [83.5, 95.5], axis=1)
        assert shifts[0] > 3  # the light straight ahead
        assert (shifts[1:] < 1).all()
