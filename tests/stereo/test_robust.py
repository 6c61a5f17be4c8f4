from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from harmonicface.appearance.render import render
from harmonicface.datasets.diligent import load_diligent
from harmonicface.lighting.lights import directional
from harmonicface.reflectance.materials import Material, Microfacet, Phong
from harmonicface.stereo.calibrated import lit_least_squares
from harmonicface.stereo.robust import FEWEST, robust_normals
from harmonicface.surfaces.surface import Surface


def dome(count: int) -> np.ndarray:
    """Lamps spread evenly within 60 degrees of the camera."""
    index = np.arange(count)
    height, turn = 1 - 0.5 * (index + 0.5) / count, index * np.pi * (3 - np.sqrt(5))
    across = np.sqrt(1 - height**2)
    return np.stack([across * np.cos(turn), across * np.sin(turn), height], axis=1)


def ball(size: int = 21) -> Surface:
    y, x = np.mgrid[1 : -1 : size * 1j, -1 : 1 : size * 1j]
    inside = x**2 + y**2 < 0.9
    normals = np.dstack([x, y, np.sqrt(np.where(inside, 1 - x**2 - y**2, 0))])
    return Surface(np.where(inside[..., None], normals, [0.0, 0.0, 1.0]), np.where(x > 0, 0.3, 0.6), inside)


def seen(surface: Surface, lamps: np.ndarray, material: Material | None = None) -> np.ndarray:
    """(n, p) observations."""
    return np.stack([render(surface, directional(lamp), material=material)[surface.mask] for lamp in lamps])


def degrees(found: np.ndarray, true: np.ndarray) -> np.ndarray:
    unit = found / np.linalg.norm(found, axis=1, keepdims=True)
    return np.degrees(2 * np.arcsin(np.clip(np.linalg.norm(unit - true, axis=1) / 2, 0, 1)))


def test_a_matte_ball_is_exact_in_spite_of_shadows() -> None:
    surface, lamps = ball(), dome(40)
    observations = seen(surface, lamps)
    assert (observations == 0).mean() > 0.02  # attached shadows
    cast = np.random.default_rng(0).random(observations.shape) < 0.1
    observations[cast] *= 0.2
    found = robust_normals(observations, lamps)
    assert np.quantile(degrees(found.scaled, surface.pixel_normals), 0.95) < 0.2
    assert_allclose(
        np.quantile(np.linalg.norm(found.scaled, axis=1) / surface.pixel_albedo, [0.05, 0.95]), 1, rtol=0.02
    )


@pytest.mark.parametrize("material", [Phong(20, 0.25), Phong(100, 0.3), Microfacet(0.15), Microfacet(0.3)])
def test_highlights_of_other_shapes_than_ours_are_explained(material: Material) -> None:
    surface, lamps = ball(), dome(60)
    observations = seen(surface, lamps, material)
    found = robust_normals(observations, lamps)
    error = degrees(found.scaled, surface.pixel_normals).mean()
    matte = degrees(lit_least_squares(observations, lamps, observations >= 0)[0], surface.pixel_normals).mean()
    assert error < 1
    assert error < matte / 3


def test_the_lamps_brightness_is_divided_out() -> None:
    surface, lamps = ball(11), dome(20)
    observations = seen(surface, lamps, Phong(20, 0.2))
    brightness = np.linspace(1, 3, 20)
    even = robust_normals(observations, lamps)
    uneven = robust_normals(observations * brightness[:, None], lamps * brightness[:, None])
    assert_allclose(uneven.scaled, even.scaled, atol=1e-4)


def test_a_photograph_with_much_dimmer_light_hardly_counts() -> None:
    surface, lamps = ball(11), dome(20)
    brightness = np.where(np.arange(20) == 7, 0.001, 1.0)
    generator = np.random.default_rng(1)
    observations = seen(surface, lamps) * brightness[:, None]
    observations += 1e-3 * generator.normal(size=observations.shape)
    found = robust_normals(observations, lamps * brightness[:, None])
    assert degrees(found.scaled, surface.pixel_normals).mean() < 0.5


def test_saturated_and_other_unusable_observations_are_left_out() -> None:
    surface, lamps = ball(11), dome(30)
    clean = seen(surface, lamps)
    burnt = np.minimum(2.2 * clean, 1)
    assert (burnt == 1).mean() > 0.05
    spoilt = np.random.default_rng(2).random(clean.shape) < 0.2
    observations = np.where(spoilt, 0.5, burnt)
    found = robust_normals(observations, lamps, 1.0, ~spoilt)
    good = ((burnt < 1) & ~spoilt).sum(axis=0) >= FEWEST + 4
    assert degrees(found.scaled, surface.pixel_normals)[good].mean() < 0.5
    without = robust_normals(observations, lamps)
    assert degrees(without.scaled, surface.pixel_normals)[good].mean() > 1


def test_few_photographs_are_solved_as_matte() -> None:
    surface, lamps = ball(11), dome(FEWEST - 1)
    observations = seen(surface, lamps, Phong(20, 0.2))
    found = robust_normals(observations, lamps)
    scaled, residual, used, determined = lit_least_squares(observations, lamps, observations >= 0)
    assert_array_equal(found.scaled, scaled)
    assert_array_equal(found.residual, residual)
    assert_array_equal(found.used, used)
    assert not np.isfinite(found.confidence[~determined]).any()


def test_a_black_pixel_is_undetermined() -> None:
    found = robust_normals(np.zeros((20, 2)), dome(20))
    assert_array_equal(found.scaled, np.zeros((2, 3)))
    assert np.isinf(found.confidence).all()


def test_the_standard_error_is_that_of_noise() -> None:
    lamps = dome(40)
    normal = np.array([0.36, 0.48, 0.8])
    generator = np.random.default_rng(3)
    observations = np.maximum(0.5 * lamps @ normal, 0)[:, None] + 0.01 * generator.normal(size=(40, 400))
    found = robust_normals(observations, lamps)
    error = degrees(found.scaled, np.tile(normal, (400, 1)))
    assert 0.5 < np.sqrt(np.mean(error**2)) / np.median(found.confidence) < 1.6


def test_tells_how_far_it_is() -> None:
    told: list[tuple[int, int]] = []
    robust_normals(np.ones((8, 40000), np.float32), dome(8), tell=lambda done, of: told.append((done, of)))
    assert told[-1] == (40000, 40000)
    assert len(told) > 1


@pytest.mark.data
@pytest.mark.parametrize(("name", "goal"), [("ball", 1.7), ("cat", 6.2)])
def test_real_objects(data_dir: Path, name: str, goal: float) -> None:
    found = load_diligent(data_dir / "diligent" / f"{name}PNG")
    some = slice(None, None, 8)
    result = robust_normals(found.grey()[:, some], found.directions, np.inf, ~found.saturated()[:, some])
    assert degrees(result.scaled, found.normals[some]).mean() <= goal
