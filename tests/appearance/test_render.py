"""Pictures against a loop over pixels and lamps, and the published errors of nine harmonics."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.lighting.sources import DirectionalLights

RNG = np.random.default_rng(0)
NORMALS = RNG.normal(size=(6, 5, 3))
NORMALS /= np.linalg.norm(NORMALS, axis=2, keepdims=True)
MASK = RNG.uniform(size=(6, 5)) < 0.7
GREY = RNG.uniform(0.1, 1, (6, 5))
COLOUR = RNG.uniform(0.1, 1, (6, 5, 3))
LAMPS = RNG.normal(size=(4, 3))


@pytest.mark.parametrize("albedo", [GREY, COLOUR], ids=["grey surface", "coloured surface"])
@pytest.mark.parametrize("strengths", [RNG.uniform(0, 1, 4), RNG.uniform(0, 1, (4, 3))], ids=["grey", "coloured"])
def test_exact_pictures(albedo: np.ndarray, strengths: np.ndarray) -> None:
    colours = max(albedo.ndim - 1, strengths.ndim) > 1
    expected = np.zeros((6, 5, 3) if colours else (6, 5))
    for row, column in zip(*np.nonzero(MASK), strict=True):
        for lamp, strength in zip(LAMPS, strengths, strict=True):
            cosine = NORMALS[row, column] @ lamp / np.sqrt(lamp @ lamp)
            if cosine > 0:
                expected[row, column] += albedo[row, column] * strength * cosine
    picture = hf.render(hf.Surface(NORMALS, albedo, MASK), DirectionalLights(LAMPS, strengths))
    assert picture.shape == expected.shape
    assert_allclose(picture, expected, rtol=1e-12)
    assert not picture[~MASK].any()


def test_a_wall_that_faces_the_lamp_is_as_bright_as_its_albedo() -> None:
    wall = hf.Surface(np.tile([0.0, 0.0, 1.0], (2, 3, 1)), np.full((2, 3), 0.25))
    assert_allclose(hf.render(wall, hf.lights.directional([0, 0, 9])), 0.25, rtol=1e-15)
    assert_allclose(hf.render(wall, hf.lights.ambient(1.0)), 0.25, rtol=1e-15)
    assert not hf.render(wall, hf.lights.directional([0, 0, -1])).any()


def test_pictures_add_as_lights_do() -> None:
    surface = hf.Surface(NORMALS, COLOUR, MASK)
    sun, sky = hf.lights.directional([1, 1, 1], [1, 0.9, 0.7]), hf.lights.natural(1, size=4)
    together = hf.render(surface, 0.5 * sun + sky)
    assert_allclose(together, 0.5 * hf.render(surface, sun) + hf.render(surface, sky), rtol=1e-12)


def sphere_of_normals() -> hf.Surface:
    """Normals all over the sphere, evenly: Fibonacci's spiral."""
    count = 40_000
    z = 1 - (2 * np.arange(count) + 1) / count
    angles = np.arange(count) * np.pi * (3 - np.sqrt(5))
    across = np.sqrt(1 - z**2)
    normals = np.stack([across * np.cos(angles), across * np.sin(angles), z], axis=-1)
    return hf.Surface(normals.reshape(200, 200, 3), np.ones((200, 200)))


# Of the energy 2 pi / 3 of the clamped cosine, order 2 leaves 1 - .375 - .5 - .1171875 = .0078125: its root is 8.84 %.
@pytest.mark.parametrize(("order", "energy_left"), [(0, 0.625), (1, 0.125), (2, 0.0078125), (4, 0.001953125)])
@pytest.mark.parametrize("towards", [[0, 0, 1], [1, -2, 0.5]])
def test_error_of_few_harmonics_under_one_lamp(order: int, energy_left: float, towards: list[float]) -> None:
    sphere = sphere_of_normals()
    lamp = hf.lights.directional(towards)
    exact = hf.render(sphere, lamp)
    error = hf.render(sphere, lamp, order=order) - exact
    assert_allclose(np.mean(error**2) / np.mean(exact**2), energy_left, rtol=2e-3)


def test_single_precision_stays_single() -> None:
    surface = hf.Surface(NORMALS.astype(np.float32), GREY.astype(np.float32), MASK)
    lamp = hf.lights.directional([1, 1, 1])
    for order in (None, 2):
        assert hf.render(surface, lamp, order=order).dtype == np.float32


def test_no_order() -> None:
    with pytest.raises(hf.HarmonicFaceError, match="order: expected an integer of at least 0"):
        hf.render(hf.Surface(NORMALS, GREY, MASK), hf.lights.ambient(1), order=-1)
