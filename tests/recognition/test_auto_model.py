"""The pictures that a gallery of model auto keeps: few, of natural light, and telling the light."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.recognition.auto_model import auto, dim_natural_light

SURFACE = hf.synthetic_person(0, size=32)


@pytest.mark.parametrize("number", range(4))
def test_four_pictures_do_for_a_face(number: int) -> None:
    assert hf.Subspace.of(auto(hf.synthetic_person(number, 32))).rank == 4


def test_what_they_combine_to_is_the_light() -> None:
    few = hf.Subspace.of(auto(SURFACE))
    photo = hf.render(SURFACE, hf.lights.natural(11))[SURFACE.mask]
    found = hf.HarmonicLight(few.coefficients(photo))
    assert_allclose(hf.render(SURFACE, found)[SURFACE.mask], few.nearest(photo), rtol=0, atol=1e-4)
    assert few.distance(photo) < 0.2


def test_lights_that_are_dim_in_front_count_for_more() -> None:
    moment = dim_natural_light()
    assert_allclose(moment, moment.T, rtol=1e-9)
    assert moment[0, 2] < -0.1 * moment[0, 0]  # of L_00 L_10: more light from behind
    lights = np.stack([hf.lights.natural(seed, 16).coefficients(1) for seed in range(400)])
    assert abs((lights[:, 0] * lights[:, 2]).mean()) < 0.1 * (lights[:, 0] ** 2).mean()  # as drawn, from nowhere more


def test_a_gallery_of_few_pictures_names_everybody_under_natural_light() -> None:
    people = list(hf.synthetic_people(30, 32, seed=77))
    galleries = {model: hf.Gallery(model=model) for model in ("auto", "harmonic9")}
    for gallery in galleries.values():
        for number, person in enumerate(people):
            gallery.enroll(str(number), person)
    assert galleries["auto"].bytes_per_person <= 0.6 * galleries["harmonic9"].bytes_per_person
    for number, person in enumerate(people):
        photo = hf.render(person, hf.lights.natural(1000 + number))
        match = galleries["auto"].match(photo)
        assert match.candidates[0].name == str(number)
        assert match.light is not None


def test_a_wall_needs_one() -> None:
    wall = hf.Surface(np.tile([0.0, 0.0, 1.0], (8, 8, 1)), np.ones((8, 8)))
    assert hf.Subspace.of(auto(wall)).rank == 1
