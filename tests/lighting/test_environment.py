"""Environment maps: where each pixel is, how large it is, and what nine numbers of it are worth."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf

NORMALS = np.random.default_rng(1).normal(size=(300, 3))
NORMALS /= np.linalg.norm(NORMALS, axis=1, keepdims=True)


def test_a_white_environment_gives_every_surface_pi() -> None:
    white = hf.EnvironmentMap(np.ones((64, 128)))
    assert_allclose(white.irradiance(NORMALS), np.pi, rtol=1e-3)
    series = hf.HarmonicLight(white.coefficients(4)).irradiance(NORMALS)
    assert_allclose(series, np.pi, rtol=1e-3)


@pytest.mark.parametrize("shape", [(1, 1), (1, 2), (2, 4), (7, 5), (64, 128)])
def test_solid_angles_fill_the_sphere_exactly(shape: tuple[int, int]) -> None:
    assert_allclose(hf.EnvironmentMap(np.ones(shape)).solid_angles.sum(), 4 * np.pi, rtol=1e-14)


def test_solid_angles_of_rows_are_those_of_bands() -> None:
    angles = hf.EnvironmentMap(np.ones((4, 3))).solid_angles
    root = np.sqrt(0.5)  # bands of 45 degrees, cut in three
    expected = 2 * np.pi / 3 * np.array([1 - root, root, root, 1 - root])
    assert_allclose(angles, np.repeat(expected[:, None], 3, axis=1), rtol=1e-14)


@pytest.mark.parametrize(
    ("row", "column", "direction"),
    [
        ((31, 32), (63, 64), [0, 0, -1]),  # the middle looks away from the camera
        ((31, 32), (0, 127), [0, 0, 1]),  # the borders meet behind it
        ((31, 32), (95, 96), [1, 0, 0]),  # the right half is to the right
        ((31, 32), (31, 32), [-1, 0, 0]),
        ((0, 0), (0, 64), [0, 1, 0]),  # the top row is up
        ((63, 63), (0, 64), [0, -1, 0]),
    ],
    ids=["middle", "borders", "right", "left", "top", "bottom"],
)
def test_axes(row: tuple[int, int], column: tuple[int, int], direction: list[float]) -> None:
    radiance = np.zeros((64, 128))
    radiance[np.ix_(row, column)] = 1
    light = hf.EnvironmentMap(radiance)
    towards = light.coefficients(1)[[3, 1, 2]]  # x, y, z
    assert_allclose(towards / np.linalg.norm(towards), direction, atol=1e-3)
    brightest = NORMALS[light.irradiance(NORMALS).argmax()]
    assert brightest @ direction > 0.95


def test_directions_are_unit_and_each_its_pixel() -> None:
    directions = hf.EnvironmentMap(np.ones((6, 8))).directions
    assert_allclose(np.linalg.norm(directions, axis=-1), 1, rtol=1e-15)
    assert (directions[:3, :, 1] > 0).all()
    assert (directions[:, 4:, 0] > 0).all()
    assert (directions[:, 2:6, 2] < 0).all()


def test_a_small_bright_pixel_is_a_lamp() -> None:
    radiance = np.zeros((64, 128))
    radiance[20, 100] = 1
    light = hf.EnvironmentMap(radiance)
    latitude, longitude = np.pi * (0.5 - 20.5 / 64), 2 * np.pi * (100.5 / 128 - 0.5)
    towards = [np.cos(latitude) * np.sin(longitude), np.sin(latitude), -np.cos(latitude) * np.cos(longitude)]
    size = 2 * np.pi / 128 * (np.cos(np.pi * 20 / 64) - np.cos(np.pi * 21 / 64))
    lamp = hf.lights.directional(towards, size)
    assert_allclose(light.coefficients(6), lamp.coefficients(6), rtol=0, atol=1e-15)
    assert_allclose(light.irradiance(NORMALS), lamp.irradiance(NORMALS), rtol=0, atol=1e-15)


@pytest.mark.parametrize("channels", [(), (3,)], ids=["grey", "colour"])
def test_irradiance_against_a_loop_over_pixels(channels: tuple[int, ...]) -> None:
    height, width = 6, 12
    radiance = np.random.default_rng(2).uniform(0, 5, (height, width, *channels))
    radiance[2, 3] = 0
    expected = np.zeros((20, *channels))
    for i in range(height):
        for j in range(width):
            latitude = np.pi * (0.5 - (i + 0.5) / height)
            longitude = 2 * np.pi * ((j + 0.5) / width - 0.5)
            x, y = np.cos(latitude) * np.sin(longitude), np.sin(latitude)
            z = -np.cos(latitude) * np.cos(longitude)
            size = 2 * np.pi / width * (np.cos(np.pi * i / height) - np.cos(np.pi * (i + 1) / height))
            for k, normal in enumerate(NORMALS[:20]):
                expected[k] += radiance[i, j] * size * max(normal @ [x, y, z], 0)
    light = hf.EnvironmentMap(radiance)
    assert light.channels == (3 if channels else 1)
    assert_allclose(light.irradiance(NORMALS[:20]), expected, rtol=1e-12)


def test_darkness() -> None:
    dark = hf.EnvironmentMap(np.zeros((4, 8)))
    assert not dark.irradiance(NORMALS).any()
    assert not dark.coefficients().any()


def test_grey_is_luminance() -> None:
    colour = hf.EnvironmentMap(np.random.default_rng(3).uniform(0, 1, (8, 16, 3)))
    expected = colour.irradiance(NORMALS) @ [0.2126, 0.7152, 0.0722]
    assert_allclose(colour.grey().irradiance(NORMALS), expected, rtol=1e-13)
    grey = hf.EnvironmentMap(np.ones((2, 4)))
    assert grey.grey() is grey


def test_a_file_comes_back_as_it_was_measured(tmp_path: Path) -> None:
    radiance = np.random.default_rng(4).uniform(0.1, 50, (8, 16, 3)).astype(np.float32)
    np.save(tmp_path / "sky.npy", radiance)
    loaded = hf.EnvironmentMap.load(tmp_path / "sky.npy")
    np.testing.assert_array_equal(loaded.radiance, radiance)
    cv2.imwrite(str(tmp_path / "sky.hdr"), radiance[..., ::-1])
    assert_allclose(hf.EnvironmentMap.load(tmp_path / "sky.hdr").radiance, radiance, rtol=0, atol=0.01 * 50)


def test_a_file_that_is_no_map(tmp_path: Path) -> None:
    np.save(tmp_path / "square.npy", np.ones((8, 8)))
    with pytest.raises(hf.HarmonicFaceError, match=r"square\.npy: expected a map twice as wide as high, got 8 x 8"):
        hf.EnvironmentMap.load(tmp_path / "square.npy")
    with pytest.raises(hf.HarmonicFaceError, match=r"layout: expected one of 'latlong', .*, got 'polar'"):
        hf.EnvironmentMap.load(tmp_path / "square.npy", layout="polar")
    with pytest.raises(hf.HarmonicFaceError, match=r"none\.hdr: expected an image"):
        hf.EnvironmentMap.load(tmp_path / "none.hdr")


@pytest.mark.parametrize(
    ("radiance", "message"),
    [
        (np.full((2, 4), -1.0), "radiance: expected at least 0, got -1"),
        (np.full((2, 4), np.nan), "radiance: expected finite numbers, got 8 NaN"),
        (np.ones(4), "radiance: expected an image"),
    ],
)
def test_radiance_that_is_none(radiance: np.ndarray, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        hf.EnvironmentMap(radiance)


@pytest.mark.data
def test_nine_numbers_of_measured_environments(data_dir: Path) -> None:
    # Share of the irradiance's energy that nine harmonics miss, and their mean and worst error in terms of the
    # brightest irradiance. The sun in one of the maps makes it nearly a single lamp, whose share is 0.78 %.
    found = {}
    for path in sorted((data_dir / "probes" / "latlong").glob("*.hdr")):
        light = hf.EnvironmentMap.load(path).grey()
        exact = light.irradiance(NORMALS)
        error = hf.HarmonicLight(light.coefficients(2)).irradiance(NORMALS) - exact
        found[path.stem] = (
            np.mean(error**2) / np.mean(exact**2),
            np.abs(error).mean() / exact.max(),
            np.abs(error).max() / exact.max(),
        )
    assert found
    for name, (energy, mean, worst) in found.items():
        assert energy < 0.0078, name
        assert mean < 0.03, name
        assert worst < 0.09, name
    assert min(mean for _, mean, _ in found.values()) < 0.012
