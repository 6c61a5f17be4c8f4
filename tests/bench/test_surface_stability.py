"""The table of hard cases: every one of them there, and each as exact as it claims to be."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import sph_harm_y_all

from harmonicface.bench.hard_surfaces import nine_images
from harmonicface.bench.surface_stability import stability_records
from harmonicface.harmonics.conventions import to_scipy

# Rounding of the arithmetic that a case uses, a few times over.
DOUBLE, SINGLE = 1e-14, 1e-6
CASES = {
    "all normals equal (a wall): harmonic images": DOUBLE,
    "all normals equal (a wall): transport": 1e-12,
    "all normals equal (a wall): render": DOUBLE,
    "a mask of 9 pixels or fewer: harmonic images": DOUBLE,
    "a mask of 9 pixels or fewer: transport": 1e-12,
    "albedo zero in places: harmonic images": DOUBLE,
    "grazing normals (z from 0 to 1e-3): harmonic images": DOUBLE,
    "grazing normals (z from 0 to 1e-3): render": DOUBLE,
    "grazing depth: normals": DOUBLE,
    "a spike one pixel wide: horizon": 1e-12,
    "a spike one pixel wide: normals": DOUBLE,
    "depth with steps and holes: normals": 1e-13,
    "depth with steps: horizon": 1e-12,
    "a mesh times 0.001: harmonic images": 1e-5,
    "a mesh times 0.001: harmonic images with shadows": 1e-5,
    "a mesh times 1000: harmonic images": 1e-5,
    "a mesh times 1000: harmonic images with shadows": 1e-5,
    "a mesh 1e+06 away from the origin: harmonic images": 1e-5,
    "a mesh 1e+06 away from the origin: harmonic images with shadows": 1e-5,
    "1e6 : 1 dynamic range, float64: render": 1e-12,
    "1e6 : 1 dynamic range, float32: render": SINGLE,
    "float32 against float64: harmonic images": SINGLE,
    "float32 against float64: render": SINGLE,
    "float32 against float64: transport": 1e-5,
}


@pytest.fixture(scope="module")
def records():
    return stability_records()


def test_every_case_is_there(records):
    assert {record.name for record in records} == set(CASES)
    assert all(record.note for record in records)


@pytest.mark.parametrize("name", CASES)
def test_each_case_is_as_exact_as_its_arithmetic(records, name):
    errors = [record.error for record in records if record.name == name]
    assert errors and max(errors) <= CASES[name]


def test_scaled_meshes_are_seen_by_the_same_pixels(records):
    assert all("pixels: True" in record.note for record in records if record.name.startswith("a mesh"))


def test_the_polynomials_are_the_harmonics_times_the_filter():
    """Against scipy's harmonics: nothing of the package but the order of coefficients."""
    normals = np.random.default_rng(0).normal(size=(20, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    polar, azimuth = np.arccos(normals[:, 2]), np.arctan2(normals[:, 1], normals[:, 0])
    theirs = sph_harm_y_all(2, 2, polar, azimuth)
    filters = np.repeat([np.pi, 2 * np.pi / 3, np.pi / 4], [1, 3, 5])
    for row, image in enumerate(nine_images(normals)):
        expected = np.tensordot(to_scipy(filters[row] * np.eye(9)[row]), theirs, ([0, 1], [0, 1]))
        np.testing.assert_allclose(image, expected.real, atol=1e-13)
