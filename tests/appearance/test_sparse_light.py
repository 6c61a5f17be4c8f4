"""One to three lamps from a photograph: to rounding without noise, as sure as told with it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

import harmonicface as hf
from harmonicface.appearance.sparse_light import sparse_light

Array = NDArray[np.float64]


def half_sphere(size: int = 32, colours: int = 0) -> hf.Surface:
    """Return a ball as a camera sees it, in double precision."""
    x, y = np.meshgrid(np.linspace(-1, 1, size), np.linspace(1, -1, size))
    inside = x**2 + y**2 < 0.999
    normals = np.stack([x, y, np.sqrt(np.clip(1 - x**2 - y**2, 0, 1))], axis=-1) * inside[..., None]
    shape = (size, size, colours) if colours else (size, size)
    return hf.Surface(normals, np.random.default_rng(0).uniform(0.4, 1, shape))


def clamped(surface: hf.Surface, directions: Array, strengths: Array) -> Array:
    """Return the photograph under lamps by the plain sum."""
    return surface.albedo * (np.maximum(surface.normals @ directions.T, 0) @ strengths)


def lamps(rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    """Return lamps in front, at least 25 degrees apart."""
    while True:
        directions = rng.normal(size=(count, 3))
        directions[:, 2] = np.abs(directions[:, 2])
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        if (directions @ directions.T - 2 * np.eye(count)).max() < np.cos(np.radians(25)):
            return directions, rng.uniform(0.3, 1.0, count)


def degrees_off(found: Array, truth: Array) -> Array:
    """Return the angle of each true lamp to the one that is meant by it."""
    angles = np.arctan2(np.linalg.norm(np.cross(truth[:, None], found[None]), axis=2), truth @ found.T)
    return np.degrees(angles[linear_sum_assignment(angles)])


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("told", [True, False])
def test_without_noise_directions_are_exact(count: int, told: bool) -> None:
    surface = half_sphere()
    for seed in range(3):
        directions, strengths = lamps(np.random.default_rng(seed), count)
        found = sparse_light(clamped(surface, directions, strengths), surface, count if told else None)
        assert len(found.light.directions) == count
        assert degrees_off(found.light.directions, directions).max() < 1e-6
        assert_allclose(np.sort(found.light.strengths), np.sort(strengths), rtol=1e-10)
        assert found.residual < 1e-12
        assert (np.diff(found.light.strengths) <= 0).all()


def test_a_lamp_nearly_behind_a_face() -> None:
    face = hf.synthetic_person(0, 40)
    lamp = hf.lights.directional([1.0, 0.5, -0.3])
    assert degrees_off(sparse_light(hf.render(face, lamp), face).light.directions, lamp.directions)[0] < 1e-3  # float32


def test_with_noise_it_is_as_sure_as_it_says() -> None:
    surface = half_sphere(24)
    rng = np.random.default_rng(1)
    directions = np.array([[0.6, 0.0, 0.8], [-0.48, 0.64, 0.6]])
    photo = clamped(surface, directions, np.array([1.0, 0.7]))
    errors, told = [], []
    for _ in range(40):
        found = sparse_light(photo + rng.normal(0, 0.02, photo.shape), surface, 2)
        errors.append(degrees_off(found.light.directions, directions))
        told.append(found.std_degrees)
    assert_allclose(np.sqrt(np.mean(np.square(errors), axis=0)), np.mean(told, axis=0), rtol=0.25)
    assert np.mean(told) < 1


def test_how_many_lamps_is_found_in_noise() -> None:
    surface = half_sphere(32)
    rng = np.random.default_rng(2)
    for count in (1, 2, 3):
        directions, strengths = lamps(np.random.default_rng(5), count)
        photo = clamped(surface, directions, strengths)
        assert len(sparse_light(photo + rng.normal(0, 0.01, photo.shape), surface).light.directions) == count


@pytest.mark.parametrize("colours", [0, 3])
def test_coloured_lamps(colours: int) -> None:
    surface = half_sphere(24, colours)
    light = hf.lights.directional([1, 0, 1], [1.0, 0.5, 0.2]) + hf.lights.directional([-1, 1, 2], [0.1, 0.2, 0.9])
    found = sparse_light(hf.render(surface, light), surface, 2, noise=0.01)
    expected = np.array([[1, 0, 1], [-1, 1, 2]]) / np.sqrt([[2], [6]])
    assert degrees_off(found.light.directions, expected).max() < 1e-6
    assert_allclose(np.sort(found.light.strengths.sum(axis=1)), [1.2, 1.7])
    assert found.residual.shape == (3,)
    assert (found.std_degrees > 0).all()


def test_a_wall_has_no_direction() -> None:
    wall = hf.Surface(np.tile([0.0, 0.0, 1.0], (6, 6, 1)), np.ones((6, 6)))
    found = sparse_light(np.full((6, 6), 0.4), wall, 1)
    assert np.isinf(found.std_degrees).all()
    assert_allclose(found.light.irradiance([0.0, 0.0, 1.0]), 0.4)
    one = np.zeros((6, 6), bool)
    one[0, 0] = True
    assert np.isinf(sparse_light(np.full((6, 6), 0.4), wall, mask=one).std_degrees).all()


def test_bad_input() -> None:
    surface = half_sphere(12)
    photo = clamped(surface, np.eye(3)[2:], np.ones(1))
    with pytest.raises(hf.HarmonicFaceError, match="count: expected 1, 2 or 3 lamps, got 4"):
        sparse_light(photo, surface, 4)
    with pytest.raises(hf.HarmonicFaceError, match="count: expected an integer"):
        sparse_light(photo, surface, 0)
    for noise in (-1.0, np.ones(3), "a", True):
        with pytest.raises(hf.HarmonicFaceError, match="noise: expected a finite number of at least 0"):
            sparse_light(photo, surface, noise=noise)  # type: ignore[arg-type]
    for dark in (0 * photo, -photo):
        with pytest.raises(
            hf.HarmonicFaceError,
            match=r"photo: expected (light that some lamp explains|some light)",
        ):
            sparse_light(dark, surface)
