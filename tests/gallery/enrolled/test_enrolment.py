"""What stands for a person."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg

import harmonicface as hf
from harmonicface.gallery.enrolled.enrolment import Model, enrolment_of
from harmonicface.gallery.frame import Frame
from harmonicface.recognition.models import harmonic9
from harmonicface.stereo.reconstruction import reconstruct

NINE = Model(harmonic9)
DEFAULT = Model(harmonic9, 1, True)
PERSON = hf.synthetic_person(4, 24)
LAMPS = [[0.0, 0.0, 1.0], [0.4, 0.0, 0.9], [-0.4, 0.1, 0.9], [0.0, 0.45, 0.9], [0.1, -0.4, 0.9]]


def angles(rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    return np.asarray(scipy.linalg.subspace_angles(rows.T.astype(np.float64), columns))


def test_a_surface_spans_its_harmonic_images_in_her_own_frame() -> None:
    enrolled = enrolment_of(PERSON, None, NINE)
    images = np.zeros((9, 24 * 24))
    images[:, PERSON.mask.ravel()] = hf.harmonic_images(PERSON)
    assert enrolled.source == "surface"
    assert enrolled.frame.pixels == 24 * 24
    assert angles(enrolled.subspace.rows, images.T).max() < 1e-5


def test_photographs_span_themselves_up_to_nine_directions() -> None:
    rng = np.random.default_rng(1)
    few, many = rng.uniform(0, 1, (4, 6, 7)), rng.uniform(0, 1, (12, 6, 7))
    enrolled = enrolment_of(few, None, NINE)
    assert (enrolled.source, enrolled.subspace.rank) == ("photographs", 4)
    assert angles(enrolled.subspace.rows, few.reshape(4, -1).T).max() < 1e-6
    strongest = np.linalg.svd(many.reshape(12, -1), full_matrices=False)[2][:9]
    assert angles(enrolment_of(many, None, NINE).subspace.rows, strongest.T).max() < 1e-6


def lit(right: int = 0, down: int = 0) -> np.ndarray:
    """Return photographs of somebody under five lamps, of which the first shows her at her place, the others moved."""
    person = hf.synthetic_person(1, (96, 84))
    photos = [hf.render(person, hf.lights.directional(one)) for one in LAMPS]
    return np.stack([photos[0], *(np.roll(photo, (down, right), axis=(0, 1)) for photo in photos[1:])])


def test_photographs_that_show_a_person_at_different_places_are_registered() -> None:
    still, apart = (enrolment_of(photos, None, DEFAULT) for photos in (lit(), lit(6, -5)))
    assert still.template is not None and apart.template is not None
    middle = np.s_[24:72, 24:60]
    one, other = (enrolled.template.values.astype(np.float32) for enrolled in (still, apart))
    # those of the four stay where they are: the place of most of them is hers
    alike = [
        np.corrcoef(one[middle].ravel(), np.roll(other, shift, (0, 1))[middle].ravel())[0, 1]
        for shift in ((5, -6), (0, 0))
    ]
    assert max(alike) > 0.9
    assert enrolment_of(lit(6, -5), None, NINE).subspace.rank == 5  # a plain projection takes them as they are


def test_cast_shadows_are_those_of_the_depth_that_lit_photographs_give() -> None:
    gallery = hf.Gallery("harmonic_shadowed")
    gallery.enroll("ada", lit(), LAMPS)
    found = reconstruct(lit(), LAMPS)
    expected = np.zeros((25, 96 * 84))
    expected[:, found.mask.ravel()] = hf.harmonic_images(found, order=4, shadows=True)
    assert gallery.source_of("ada") == "lit photographs"
    np.testing.assert_allclose(gallery.pictures_of("ada").reshape(25, -1), expected, atol=1e-4)


def test_photographs_at_about_one_place_and_those_without_anything_in_common_stay_as_they_are() -> None:
    near, noise = lit(1, -1), np.random.default_rng(0).uniform(0.1, 1, (3, 48, 48))
    for photos in (near, noise):
        enrolled = enrolment_of(photos, None, DEFAULT)
        assert angles(enrolled.subspace.rows, photos.reshape(len(photos), -1).T).max() < 1e-3


def test_the_gallerys_frame_is_kept() -> None:
    frame = Frame(np.eye(24, dtype=np.bool_))
    assert enrolment_of(PERSON, frame, NINE).frame is frame


def test_one_photograph_becomes_the_most_probable_surface() -> None:
    person = hf.synthetic_person(5, 48)
    photo = hf.render(person, hf.lights.from_angles(20, 10))
    found = enrolment_of(photo, None, NINE)
    assert (found.source, found.subspace.rank) == ("photograph", 9)
    other = hf.render(person, hf.lights.from_angles(-30, 0)).ravel()
    stranger = hf.render(hf.synthetic_person(6, 48), hf.lights.from_angles(-30, 0)).ravel()
    face = (found.subspace.rows**2).sum(axis=0) > 0
    near, far = (found.subspace.distance(picture * face) for picture in (other, stranger))
    assert near < 0.8 * far


@pytest.mark.parametrize("source", [np.ones((2, 6, 7)), np.ones(7), np.ones((3, 0, 7)), np.ones((3, 1, 1, 1, 1))])
def test_what_is_neither_surface_nor_photographs(source: np.ndarray) -> None:
    with pytest.raises(hf.HarmonicFaceError, match="source: expected a Surface, or at least 3 photographs"):
        enrolment_of(source, None, NINE)


def test_photographs_that_are_one() -> None:
    with pytest.raises(hf.HarmonicFaceError, match="got 1 different of 3"):
        enrolment_of(np.ones((3, 6, 7)), None, NINE)
