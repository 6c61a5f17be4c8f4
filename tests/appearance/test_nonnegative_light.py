"""Non-negative light against scipy on the whole problem, against what is known, and in the dark."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import nnls

import harmonicface as hf
from harmonicface.appearance.inverse import estimate_light
from harmonicface.appearance.nonnegative_light import fibonacci_sphere, nonnegative_light


def ball(size: int = 24, colours: int = 0) -> hf.Surface:
    """Return pixels with normals in all directions."""
    rng = np.random.default_rng(0)
    normals = rng.normal(size=(size, size, 3))
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    return hf.Surface(normals, rng.uniform(0.3, 1, (size, size, colours) if colours else (size, size)))


def test_the_spiral_is_even() -> None:
    spiral = fibonacci_sphere(400)
    assert_allclose(np.linalg.norm(spiral, axis=1), 1)
    assert_allclose(spiral.T @ spiral / 400, np.eye(3) / 3, atol=1e-3)
    nearest = np.sort(spiral @ spiral.T, axis=1)[:, -2]
    assert np.degrees(np.arccos(nearest.max())) > 5
    assert np.degrees(np.arccos(nearest.min())) < 11


def test_it_is_non_negative_least_squares_over_all_pixels() -> None:
    surface = ball()
    photo = np.asarray(hf.render(surface, hf.lights.natural(1)))
    grid = fibonacci_sphere(60)
    pictures = surface.pixel_albedo[:, None] * np.maximum(surface.pixel_normals @ grid.T, 0)
    _, misfit = nnls(pictures, photo.ravel())
    found = nonnegative_light(photo, surface, grid)
    assert_allclose(found.residual, misfit / np.sqrt(photo.size), rtol=1e-6)
    assert_allclose(np.sqrt(np.mean((hf.render(surface, found.light) - photo) ** 2)), found.residual, rtol=1e-6)


def test_lamps_on_the_grid_come_back() -> None:
    surface = ball()
    grid = fibonacci_sphere(300)
    lamps = hf.lights.directional(grid[10], 0.7) + hf.lights.directional(grid[200], 0.4)
    found = nonnegative_light(hf.render(surface, lamps), surface, grid)
    strong = found.light.strengths > 1e-6
    assert_allclose(found.light.directions[strong], grid[[10, 200]])
    assert_allclose(found.light.strengths[strong], [0.7, 0.4], atol=1e-8)


def test_a_face_tells_its_light_better_than_to_least_squares() -> None:
    face = hf.synthetic_person(3, 48)
    rng = np.random.default_rng(0)
    ratios = []
    for seed in range(5):
        light = hf.lights.natural(seed)
        photo = np.asarray(hf.render(face, light), np.float64)
        photo += rng.normal(0, 0.01, photo.shape)
        truth = light.coefficients(2)
        free = np.linalg.norm(estimate_light(photo, face).coefficients - truth)
        ratios.append(np.linalg.norm(nonnegative_light(photo, face, 250).light.coefficients(2) - truth) / free)
    assert np.median(ratios) < 0.8


@pytest.mark.parametrize("colours", [0, 3])
def test_colours(colours: int) -> None:
    surface = ball(16, colours)
    lamp = hf.lights.directional([1, 2, 2], [0.9, 0.5, 0.0])
    found = nonnegative_light(hf.render(surface, lamp), surface, np.concatenate([np.eye(3), [[1.0, 2.0, 2.0]]]))
    assert_allclose(found.light.strengths.sum(axis=0), [0.9, 0.5, 0.0], atol=1e-9)
    assert np.shape(found.residual) == (3,)


def test_in_the_dark_and_on_a_wall() -> None:
    surface = ball(8)
    dark = nonnegative_light(np.zeros((8, 8)), surface)
    assert_allclose(dark.light.strengths, [0.0])
    assert dark.residual == 0
    wall = hf.Surface(np.tile([0.0, 0.0, 1.0], (4, 4, 1)), np.ones((4, 4)))
    assert_allclose(nonnegative_light(np.ones((4, 4)), wall).light.irradiance([0.0, 0.0, 1.0]), 1)


def test_bad_input() -> None:
    surface = ball(8)
    with pytest.raises(hf.HarmonicFaceError, match=r"directions: expected shape \(n, 3\) or a number of them"):
        nonnegative_light(np.ones((8, 8)), surface, np.ones(3))
    with pytest.raises(hf.HarmonicFaceError, match="count: expected an integer of at least 1"):
        nonnegative_light(np.ones((8, 8)), surface, 0)
    with pytest.raises(hf.HarmonicFaceError, match="photo: expected shape"):
        nonnegative_light(np.ones((8, 9)), surface)
    for photo, message in ((1e300, "intensities of at most 1e"), (-1.0, "some light, got values from -1 to -1")):
        with pytest.raises(hf.HarmonicFaceError, match=f"photo: expected {message}"):
            nonnegative_light(np.full((8, 8), photo), surface)
    with pytest.raises(hf.HarmonicFaceError, match="count: expected an integer of at least 1, got bool True"):
        nonnegative_light(np.ones((8, 8)), surface, True)
    with pytest.raises(hf.HarmonicFaceError, match=r"1000000000000 directions: need 6.4e.04 GB of memory"):
        fibonacci_sphere(10**12)
    with pytest.raises(hf.HarmonicFaceError, match=r"lamps in 1000000 directions: need 1.6e.04 GB of memory"):
        nonnegative_light(np.ones((8, 8)), surface, 10**6)
