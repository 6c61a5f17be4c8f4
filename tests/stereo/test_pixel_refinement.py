"""Normals, albedo and lights refined together: the cost falls, the pixels come nearer, the deviation is theirs."""

from __future__ import annotations

import numpy as np
import pytest

from harmonicface.stereo.linear_shape import unit
from harmonicface.stereo.pixel_refinement import refine
from harmonicface.stereo.positive_lights import positive_lights
from harmonicface.stereo.sky_cells import (
    SOLID_ANGLE,
    cell_directions,
    cell_flow,
    cell_shades,
    cell_visibility,
)

COUNT, NOISE = 16, 0.01


@pytest.fixture(scope="module")
def scene():
    """Return normals, albedo, lights of a few bright cells over a dim sky, and photographs of them."""
    rng = np.random.default_rng(0)
    normals = unit(rng.normal(size=(300, 3)) * 0.5 + [0, 0, 1])
    albedo = rng.uniform(0.4, 0.8, 300)
    radiance = rng.uniform(0, 0.1, (COUNT, 192)) + 2.0 * (rng.random((COUNT, 192)) < 0.04)
    photographs = albedo * (radiance @ cell_shades(normals)) + NOISE * rng.normal(size=(COUNT, 300))
    return normals, albedo, radiance, photographs


def angles(found, normals):
    return np.degrees(np.arccos(np.clip((unit(found) * normals).sum(axis=1), -1, 1)))


def test_pixels_come_nearer_and_the_cost_falls(scene):
    normals, albedo, radiance, photographs = scene
    rng = np.random.default_rng(1)
    start = albedo[:, None] * unit(normals + 0.05 * rng.normal(size=normals.shape))
    found = refine(photographs, start, radiance, None, rounds=3)
    assert (np.diff(found.cost) <= 0).all()
    assert angles(found.scaled, normals).mean() < 0.65 * angles(start, normals).mean()
    assert found.residual.mean() < 1.2 * NOISE


def test_deviation_is_that_of_the_errors(scene):
    normals, albedo, radiance, photographs = scene
    found = refine(photographs, albedo[:, None] * normals, radiance, None, rounds=1)
    errors = angles(found.scaled, normals)
    assert 0.5 < np.sqrt((errors**2).mean()) / np.sqrt((found.deviation**2).mean()) < 1.5


def test_no_round_leaves_the_start(scene):
    normals, albedo, radiance, photographs = scene
    start = albedo[:, None] * normals
    found = refine(photographs, start, radiance, None, rounds=0)
    assert np.array_equal(found.scaled, start) and len(found.cost) == 1


def test_flow_is_the_derivative_of_the_shade():
    rng = np.random.default_rng(2)
    normals, radiance = unit(rng.normal([0, 0, 1], size=(20, 3))), rng.uniform(0, 1, (3, 192))
    flow = cell_flow(normals, radiance)
    assert np.allclose(np.einsum("pni,pi->np", flow, normals), radiance @ cell_shades(normals), rtol=1e-5)
    moved = unit(normals + 1e-3 * rng.normal(size=normals.shape))
    linear = np.einsum("pni,pi->np", flow, moved)
    assert np.abs(radiance @ cell_shades(moved) - linear).max() < 1e-3


def test_cells_are_even():
    towards = cell_directions()
    assert np.allclose(np.linalg.norm(towards, axis=1), 1)
    assert np.allclose(SOLID_ANGLE * towards.T @ towards, 4 * np.pi / 3 * np.eye(3), atol=0.04)
    white = cell_shades(np.array([[0.0, 0.0, 1.0]])).sum()
    assert np.isclose(white, np.pi, rtol=0.01)


def test_a_wall_hides_half_of_what_a_pixel_beside_it_sees():
    depth = np.zeros((9, 30))
    depth[:, 15:] = 1000.0
    visible = cell_visibility(depth, np.ones((9, 30), bool)).reshape(9, 30, 16, 12)[4, 14]
    assert visible[0, 6:].max() < 0.05  # toward +x, above the horizon of the picture's plane
    assert visible[8, 6:].min() > 0.95  # away from the wall nothing hides
    assert cell_visibility(np.zeros((5, 5)), np.ones((5, 5), bool))[12].reshape(16, 12)[:, 6:].min() == 1


def test_positive_lights_find_lights_and_albedo(scene):
    normals, albedo, _, photographs = scene
    shades = cell_shades(normals)
    found = positive_lights(photographs, shades, np.full(300, 0.6), rounds=30)
    assert (found.radiance >= 0).all()
    assert np.linalg.norm(photographs - found.albedo * found.irradiance) < 1.1 * NOISE * np.sqrt(photographs.size)
    ratio = found.albedo / albedo
    assert ratio.std() / ratio.mean() < 0.05
    again = positive_lights(photographs, shades, found.albedo, active=found.active)
    assert np.allclose(again.irradiance, positive_lights(photographs, shades, found.albedo).irradiance, atol=0.05)
