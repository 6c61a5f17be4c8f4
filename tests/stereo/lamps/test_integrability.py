"""Integrability finds the frame of a surface: up to bas-relief, or of a rotation up to its sign."""

import numpy as np
from scipy.spatial.transform import Rotation

from harmonicface.stereo.lamps.integrability import integrable_frame, integrable_rotation
from tests.stereo.lamp_scenes import angles, bumpy_ball

NORMALS, MASK = bumpy_ball()


def test_rotation_is_undone_up_to_convex_and_concave():
    for seed in range(3):
        turned = NORMALS @ Rotation.random(random_state=seed).as_matrix().T
        found = turned @ integrable_rotation(turned, MASK).matrix.T
        errors = [angles(found * sign, NORMALS).mean() for sign in ([1, 1, 1], [-1, -1, 1], [1, 1, -1], [-1, -1, -1])]
        assert min(errors) < 1


def test_any_matrix_is_undone_up_to_bas_relief():
    random = np.random.default_rng(0)
    for _ in range(3):
        matrix = random.normal(size=(3, 3))
        found = NORMALS @ matrix.T @ integrable_frame(NORMALS @ matrix.T, MASK).matrix.T
        relief = np.linalg.lstsq(NORMALS, found, rcond=None)[0].T  # found = relief normals
        relief /= relief[2, 2]
        wrong = [relief[0, 1], relief[1, 0], relief[2, 0], relief[2, 1], abs(relief[0, 0]) - abs(relief[1, 1])]
        assert np.abs(wrong).max() < 0.05 * abs(relief[0, 0])


def test_a_cylinder_leaves_its_frame_open():
    x = np.tile(np.linspace(-0.9, 0.9, 40), (40, 1))
    cylinder = np.stack([x, np.zeros_like(x), np.sqrt(1 - x**2)], axis=2).reshape(-1, 3)
    everywhere = np.ones((40, 40), bool)
    noisy = cylinder + np.random.default_rng(0).normal(0, 1e-3, cylinder.shape)
    ball = NORMALS + np.random.default_rng(0).normal(0, 1e-3, NORMALS.shape)
    assert integrable_frame(noisy, everywhere).gap < 3 < integrable_frame(ball, MASK).gap
