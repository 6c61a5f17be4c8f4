"""The errors that inverse lighting tells of: against drawn noise, and against what single lamps and rooms do."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

import harmonicface as hf
from harmonicface.appearance.inverse import estimate_light

Array = NDArray[np.float64]


def whole_sphere(size: int = 40, seed: int = 0, colours: int = 0) -> hf.Surface:
    """Return pixels with normals in all directions."""
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(size, size, 3))
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    return hf.Surface(normals, rng.uniform(0.3, 1, (size, size, colours) if colours else (size, size)))


def half_sphere(size: int = 48) -> hf.Surface:
    """Return a white ball as a camera sees it."""
    x, y = np.meshgrid(np.linspace(-1, 1, size), np.linspace(1, -1, size))
    inside = x**2 + y**2 < 0.999
    normals = np.stack([x, y, np.sqrt(np.clip(1 - x**2 - y**2, 0, 1))], axis=-1) * inside[..., None]
    return hf.Surface(normals, np.ones((size, size)) * inside)


@pytest.mark.parametrize(
    ("surface", "order", "draws"),
    [
        (whole_sphere(32), 2, 200),
        (half_sphere(32), 2, 200),
        (half_sphere(32), 4, 200),
        (hf.synthetic_person(0, 32), 2, 200),
        (whole_sphere(16), 8, 500),  # the largest of 48 ratios from 200 draws would be off by 15 % itself
    ],
)
def test_the_standard_deviation_is_that_of_drawn_noise(surface: hf.Surface, order: int, draws: int) -> None:
    rng = np.random.default_rng(3)
    photo = np.asarray(hf.render(surface, hf.lights.natural(0)), np.float64)
    found = [estimate_light(photo + rng.normal(0, 0.02, photo.shape), surface, order, noise=0.02) for _ in range(draws)]
    sure = found[0].recoverable
    assert sure.sum() >= 5
    ratio = np.std([each.coefficients for each in found], axis=0)[sure] / found[0].std[sure]
    assert_allclose(ratio, 1, atol=0.15)


def test_the_residual_tells_the_noise() -> None:
    surface = whole_sphere(24)
    rng = np.random.default_rng(8)
    photo = np.asarray(hf.render(surface, hf.lights.natural(0), order=4))
    noises = [estimate_light(photo + rng.normal(0, 0.02, photo.shape), surface, 4).noise for _ in range(20)]
    assert_allclose(np.mean(noises), 0.02, rtol=0.02)


@pytest.mark.parametrize("ridge", [0.003, "decay"])
def test_the_standard_deviation_under_a_ridge(ridge: float) -> None:
    surface = whole_sphere(24)
    rng = np.random.default_rng(4)
    photo = np.asarray(hf.render(surface, hf.lights.natural(0)))
    each = [
        estimate_light(photo + rng.normal(0, 0.05, photo.shape), surface, 4, noise=0.05, ridge=ridge)
        for _ in range(200)
    ]
    sure = each[0].recoverable
    assert_allclose(np.std([e.coefficients for e in each], axis=0)[sure] / each[0].std[sure], 1, atol=0.15)


@pytest.mark.parametrize(("ridge", "least", "most"), [(0.0, 0.2, 1.0), ("decay", 0.08, 0.5)])
def test_systematic_errors_are_of_the_size_told(ridge: float, least: float, most: float) -> None:
    """Under single lamps and under natural light the errors' root mean square is below what is told."""
    surface = hf.synthetic_person(2, 40)
    rng = np.random.default_rng(6)
    ratios: dict[str, list[Array]] = {"lamp": [], "natural": []}
    for seed in range(40):
        lamp = hf.lights.directional(rng.normal(size=3) * [1, 1, 0.5] + [0, 0, 1])
        for name, light in (("lamp", lamp), ("natural", hf.lights.natural(seed, 16))):
            photo = np.asarray(hf.render(surface, light), np.float64)
            found = estimate_light(photo, surface, 2, noise=0.0, ridge=ridge)
            truth = light.coefficients(2)
            ratios[name].append((found.coefficients - truth) / found.systematic)
    for name in ratios:
        assert least < np.sqrt(np.mean(np.square(ratios[name]))) < most
        assert ridge == 0 or np.abs(ratios[name]).max() < 1


def test_noise_drowns_what_it_exceeds() -> None:
    surface = whole_sphere(10)
    photo = np.asarray(hf.render(surface, hf.lights.ambient(0.01)))
    loud = estimate_light(photo, surface, 4, noise=1.0)
    assert {mode.reason for mode in loud.unrecoverable if mode.name.count("(4")} == {loud.unrecoverable[-1].reason}
    assert "noise" in loud.unrecoverable[-1].reason
    assert estimate_light(photo, surface, 4, noise=1e-4).recoverable.sum() == 18
