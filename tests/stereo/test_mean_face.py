"""The mean face: its table, and where it is found in photographs."""

from __future__ import annotations

import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.people.synthetic import synthetic_person
from harmonicface.stereo.mean_face import FacePlace, mean_face_normals, place_mean_face

PLACE = FacePlace(3.0, 24.0, 12.0, 0.0)
MASK = np.ones((48, 48), bool)


def factors_of(normals, albedo, seed=0):
    """Return nine factors of photographs under random light of second order, and the photographs' mean."""
    rng = np.random.default_rng(seed)
    light = rng.normal([4, 0, 1, 0, 0, 0, 0, 0, 0], size=(15, 9))
    photographs = light @ (albedo * real_harmonics(normals, 2))
    return np.linalg.svd(photographs, full_matrices=False)[2][:9], photographs.mean(axis=0)


def test_unit_normals_of_a_face():
    normals, known = mean_face_normals(MASK, PLACE)
    assert np.allclose(np.linalg.norm(normals, axis=1), 1)
    grid, covered = normals.reshape(48, 48, 3), known.reshape(48, 48)
    assert covered[12, 24] and not covered[47, 0]
    nose = grid[:, 24][20:36]
    assert nose[:4, 1].max() < 0.7 and nose[:, 1].min() < -0.3  # the ridge looks up or ahead, its base down
    mirrored = grid[:, 1:][:, ::-1] * [-1, 1, 1]
    both = covered[:, 1:] & covered[:, 1:][:, ::-1]
    assert both.sum() > 1000
    assert np.allclose(grid[:, 1:][both], mirrored[both], atol=1e-5)


def test_found_where_it_is_whatever_the_light():
    normals, known = mean_face_normals(MASK, PLACE)
    mask = known.reshape(48, 48)
    right, tone = factors_of(normals[known], np.full(known.sum(), 0.5))
    found = place_mean_face(right, tone, mask)
    assert found.misfit < 0.01
    assert abs(found.scale - 3) < 0.1 and abs(found.column - 24) < 0.3 and abs(found.row - 12) < 0.5


def test_found_on_other_people():
    """The frame of synthetic people is 144 mm high, its origin 34 mm below the top, in the middle."""
    person = synthetic_person(3, size=(48, 42))
    right, tone = factors_of(person.pixel_normals.astype(float), person.pixel_albedo.astype(float))
    found = place_mean_face(right, tone, person.mask)
    assert abs(found.scale - 3) < 0.3 and abs(found.column - 20.5) < 1 and abs(found.row - 10.8) < 2.5


def test_what_is_no_face_is_refused():
    y, x = np.mgrid[-1:1:40j, -1:1:40j]
    rng = np.random.default_rng(0)
    normals = np.stack([np.sin(9 * x), np.cos(11 * y + 3 * x), np.full_like(x, 0.8)], axis=-1).reshape(-1, 3)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    right, tone = factors_of(normals, rng.uniform(0.4, 0.6, 1600))
    with pytest.raises(HarmonicFaceError, match="expected a face from the front"):
        place_mean_face(right, tone, np.ones((40, 40), bool))
