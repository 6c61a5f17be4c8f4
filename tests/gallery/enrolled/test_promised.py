"""A person is the same, whether her Surface is given, made by a call, or read from a file."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest

import harmonicface as hf
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.enrolled.enrolment import Model, enrolment_of
from harmonicface.gallery.enrolled.promised import enrolled, fulfilled
from harmonicface.gallery.frame import Frame
from harmonicface.recognition.models import harmonic9

PERSON = hf.synthetic_person(3, 24)
MODEL = Model(harmonic9)


def test_ways_to_say_the_same_person(tmp_path: Path) -> None:
    PERSON.save(tmp_path / "person.npz")
    expected = enrolment_of(PERSON, None, MODEL)
    for source in (PERSON, partial(hf.synthetic_person, 3, 24), tmp_path / "person.npz", str(tmp_path / "person.npz")):
        found = enrolled(source, expected.frame, MODEL)
        np.testing.assert_array_equal(found.subspace.rows, expected.subspace.rows)
        assert found.source == "surface"


@pytest.mark.data
def test_a_mesh_is_seen_as_large_as_the_frame(data_dir: Path) -> None:
    heads = sorted((data_dir / "heads").rglob("*.glb"))
    assert fulfilled(heads[0], Frame(np.ones((20, 20), np.bool_))).shape == (20, 20)  # type: ignore[union-attr]
    assert fulfilled(heads[0], None).shape == (64, 64)  # type: ignore[union-attr]


def test_photographs_are_what_they_are() -> None:
    photographs = np.ones((3, 4, 5))
    assert fulfilled(photographs, None) is photographs
    assert fulfilled(lambda: photographs, None) is photographs


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(HarmonicFaceError):
        fulfilled(tmp_path / "nobody.npz", None)
