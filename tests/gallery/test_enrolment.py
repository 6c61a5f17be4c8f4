"""What stands for a person."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg

import harmonicface as hf
from harmonicface.gallery.enrolment import Model, enrolment_of
from harmonicface.gallery.frame import Frame
from harmonicface.recognition.models import harmonic9

NINE = Model(harmonic9)
PERSON = hf.synthetic_person(4, 24)


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


def test_the_gallerys_frame_is_kept() -> None:
    frame = Frame(np.eye(24, dtype=np.bool_))
    assert enrolment_of(PERSON, frame, NINE).frame is frame


@pytest.mark.parametrize("source", [np.ones((2, 6, 7)), np.ones((6, 7)), np.ones((3, 0, 7)), np.ones((3, 1, 1, 1, 1))])
def test_what_is_neither_surface_nor_photographs(source: np.ndarray) -> None:
    with pytest.raises(hf.HarmonicFaceError, match="source: expected a Surface, or at least 3 photographs"):
        enrolment_of(source, None, NINE)


def test_photographs_that_are_one() -> None:
    with pytest.raises(hf.HarmonicFaceError, match="got 1 different of 3"):
        enrolment_of(np.ones((3, 6, 7)), None, NINE)
