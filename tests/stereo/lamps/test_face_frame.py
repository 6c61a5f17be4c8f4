"""The frame in which normals look like the mean face."""

import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.lamps.face_frame import MeanFace, find_mean_face
from tests.stereo.lamp_scenes import angles, bumpy_ball, lamps

NORMALS, MASK = bumpy_ball()
MEAN = MeanFace(NORMALS, np.ones(len(NORMALS), bool))


def test_any_matrix_is_undone():
    matrix = np.random.default_rng(0).normal(size=(3, 3))
    seen = NORMALS @ matrix.T * np.random.default_rng(1).uniform(0.2, 1, (len(NORMALS), 1))
    found = seen @ MEAN.frame(seen).T
    assert angles(found, NORMALS).max() < 0.01
    assert MEAN.angle(found) < 0.01


def test_noise_on_both_sides_makes_it_neither_flat_nor_deep():
    random = np.random.default_rng(2)
    person = NORMALS + random.normal(0, 0.15, NORMALS.shape)
    other = MeanFace(NORMALS + random.normal(0, 0.15, NORMALS.shape), MEAN.known)
    frame = other.frame(person)
    frame /= np.cbrt(np.linalg.det(frame))
    assert np.abs(np.linalg.svd(frame)[1] - 1).max() < 0.06


def test_a_plane_of_normals_is_refused():
    with pytest.raises(HarmonicFaceError, match="lie in a plane"):
        MEAN.frame(NORMALS * [1, 0, 1])


def test_too_few_photographs_are_refused():
    with pytest.raises(HarmonicFaceError, match="at least 4"):
        find_mean_face(lamps(3) @ NORMALS.T, MASK)
