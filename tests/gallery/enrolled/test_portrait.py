"""What the default model keeps of a person."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

import harmonicface as hf
from harmonicface.gallery.enrolled.portrait import Portrait, _lamps, photographed_template, rendered_template
from harmonicface.recognition.patterns import patterns, similarity

PERSON = hf.synthetic_person(4, 48)
EVERYWHERE = np.ones((48, 48), np.bool_)


def test_the_lamps_are_spread_about_the_camera() -> None:
    lamps = np.array(_lamps())
    assert lamps.shape == (13, 3)
    assert_allclose(np.linalg.norm(lamps, axis=1), 1)
    assert_allclose(lamps.mean(axis=0)[:2], 0, atol=1e-12)
    assert_allclose(np.degrees(np.arccos(lamps[:, 2])), [0] + 6 * [30] + 6 * [60], atol=1e-5)
    assert len(np.unique(lamps.round(6), axis=0)) == 13


def test_a_surface_resembles_her_photographs_more_than_others() -> None:
    own = rendered_template(PERSON, EVERYWHERE)
    other = rendered_template(hf.synthetic_person(5, 48), EVERYWHERE)
    photo = hf.photograph(hf.render(PERSON, hf.lights.directional([0.7, 0.3, 1])), 0)
    scores = similarity(patterns(photo), [own, other]).scores
    assert scores[0] > scores[1] + 0.1


def test_colour_is_taken_as_luminance() -> None:
    grey = PERSON.albedo
    coloured = hf.Surface(PERSON.normals, np.repeat(grey[..., None], 3, axis=2), PERSON.mask)
    assert_allclose(
        rendered_template(coloured, EVERYWHERE).values.astype(float),
        rendered_template(PERSON, EVERYWHERE).values.astype(float),
        atol=0.01,
    )


def test_the_gallerys_mask_hides_the_rest() -> None:
    mask = EVERYWHERE.copy()
    mask[:, 24:] = False
    template = photographed_template([hf.render(PERSON, hf.lights.ambient(1.0))], mask)
    assert not template.values[:, 24:].any()
    assert template.values[:, :24].any()


def test_pictures_are_made_when_they_are_asked_for() -> None:
    images = np.random.default_rng(0).uniform(0, 1, (3, 48, 48))
    asked = []
    portrait = Portrait(rendered_template(PERSON, EVERYWHERE), lambda: asked.append(1) or images, EVERYWHERE)
    small = portrait.nbytes
    assert_array_equal(portrait.pictures.light.shape, (3, 48, 48))
    assert portrait.pictures is portrait.pictures
    assert asked == [1]
    assert portrait.nbytes == small + 2 * 3 * 48 * 48 * 4
