"""Photographs of another scene among those of one."""

from __future__ import annotations

import numpy as np

from harmonicface.harmonics.basis import real_harmonics
from harmonicface.stereo.general.foreign_photographs import foreign_photographs, outside_the_others


def photographs(count=20):
    rng = np.random.default_rng(0)
    normals = rng.normal([0, 0, 2], size=(900, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    albedo = rng.uniform(0.3, 1, 900)
    light = rng.normal(size=(count, 9)) + np.eye(9)[0] * 6
    return light @ (albedo * real_harmonics(normals, 2)) + 0.01 * rng.normal(size=(count, 900))


def test_nobody_is_foreign_among_photographs_of_one_thing():
    assert foreign_photographs(photographs()) == {}
    assert outside_the_others(photographs()).max() < 0.1


def test_another_scene_is_found():
    mixed = photographs()
    mixed[7] = mixed[7][::-1] * np.linspace(0, 2, 900) ** 2
    found = foreign_photographs(mixed)
    assert list(found) == [7] and "% of it is nothing" in found[7]


def test_against_projection():
    some = photographs(14)
    others = np.delete(some, 5, axis=0)
    others = others / np.sqrt((others**2).mean(axis=1, keepdims=True))
    basis = np.linalg.svd(others, full_matrices=False)[2][:9]
    rest = some[5] - basis.T @ (basis @ some[5])
    assert np.isclose(outside_the_others(some)[5], np.linalg.norm(rest) / np.linalg.norm(some[5]), rtol=1e-6)


def test_of_few_nothing_is_said():
    few = photographs(11)
    few[3] = np.random.default_rng(1).uniform(size=900)
    assert foreign_photographs(few) == {}
