"""Nine factors and the harmonics of one unit field."""

from __future__ import annotations

import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.stereo.linear_shape import unit
from harmonicface.stereo.second_order import _quadratic, _towards, _value, harmonic_transformation


def field(seed=0, count=800):
    rng = np.random.default_rng(seed)
    normals = unit(rng.normal([0, 0, 2], size=(count, 3)))
    return normals, rng.uniform(0.4, 1, count), rng


def factors_of(normals, albedo, rng, noise=0.0):
    mixed = rng.normal(size=(20, 9)) @ (albedo * real_harmonics(normals, 2))
    mixed += noise * rng.normal(size=mixed.shape)
    return np.linalg.svd(mixed, full_matrices=False)[2][:9]


def angles(found, normals):
    return np.degrees(np.arccos(np.clip((unit(found) * normals).sum(axis=1), -1, 1)))


def test_the_truth_stays():
    normals, albedo, rng = field()
    found = harmonic_transformation(factors_of(normals, albedo, rng), albedo[:, None] * normals)
    assert found.cost[-1] < 1e-15 * len(normals)
    assert angles(found.scaled, normals).max() < 1e-3
    assert np.allclose(np.linalg.norm(found.scaled, axis=1), albedo)
    assert found.matrix.shape == (9, 9)


def test_wrong_normals_are_drawn_to_harmonics_of_one_field():
    normals, albedo, rng = field()
    factors = factors_of(normals, albedo, rng)
    wrong = albedo[:, None] * unit(normals + 0.15 * rng.normal(size=normals.shape))
    found = harmonic_transformation(factors, wrong, 200)
    assert (np.diff(found.cost) <= 1e-12).all()
    assert found.cost[-1] < 0.02 * found.cost[0]
    assert angles(found.scaled, normals).mean() < angles(wrong, normals).mean() / 3


def test_noise_leaves_a_cost():
    normals, albedo, rng = field()
    found = harmonic_transformation(factors_of(normals, albedo, rng, 0.01), albedo[:, None] * normals)
    assert (np.diff(found.cost) <= 1e-12).all()
    assert angles(found.scaled, normals).mean() < 3


def test_steps_on_the_sphere_go_uphill():
    normals, _, rng = field()
    wanted = rng.normal(size=(9, len(normals)))
    linear, form = _quadratic(wanted)
    constant = wanted[0] * real_harmonics(normals[:1], 0)[0, 0] - wanted[6] * np.sqrt(5 / (16 * np.pi))
    assert np.allclose(_value(linear, form, normals) + constant, (wanted * real_harmonics(normals, 2)).sum(axis=0))
    better = _towards(normals, wanted)
    assert (_value(linear, form, better) >= _value(linear, form, normals)).all()


@pytest.mark.parametrize(
    ("right", "start", "rounds", "message"),
    [
        (np.ones((8, 5)), np.ones((5, 3)), 1, "k of at least 9"),
        (np.ones((9, 5)), np.ones((4, 3)), 1, r"start of \(p, 3\)"),
        (np.ones(9), np.ones((4, 3)), 1, "expected shape"),
        (np.full((9, 5), np.nan), np.ones((5, 3)), 1, "right: expected finite"),
        (np.ones((9, 5)), np.full((5, 3), np.nan), 1, "start: expected finite"),
        (np.ones((9, 5)), np.ones((5, 3)), 0, "rounds: expected an integer of at least 1"),
    ],
)
def test_refusals(right, start, rounds, message):
    with pytest.raises(HarmonicFaceError, match=message):
        harmonic_transformation(right, start, rounds)
