from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from scipy.ndimage import gaussian_filter

from harmonicface.datasets.diligent import DiligentObject, load_diligent
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.bad_images import FEWEST, MOST, find_bad_images


def scene(count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Observations (n, p) of a rough matte and glossy thing with noise, and its lamps."""
    generator = np.random.default_rng(seed)
    lamps = generator.normal(size=(count, 3)) * [0.5, 0.5, 0.1] + [0, 0, 1]
    lamps /= np.linalg.norm(lamps, axis=1, keepdims=True)
    normals = generator.normal(size=(500, 3)) * [0.5, 0.5, 0.1] + [0, 0, 1]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    halves = lamps + np.array([0, 0, 1])
    halves /= np.linalg.norm(halves, axis=1, keepdims=True)
    albedo = generator.uniform(0.2, 0.8, 500)
    images = albedo * np.maximum(lamps @ normals.T, 0) + 0.3 * np.clip(halves @ normals.T, 0, 1) ** 60
    return images + 0.005 * generator.normal(size=images.shape), lamps


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("count", [12, 20, 60])
def test_nothing_is_left_out_where_all_belong(count: int, seed: int) -> None:
    images, lamps = scene(count, seed)
    found = find_bad_images(images, lamps)
    assert found.left_out == {}
    assert found.unexplained.shape == (count,)
    assert found.kept(count).all()


def test_one_of_another_scene_among_twenty_is_found() -> None:
    images, lamps = scene(20)
    images[7] = scene(20, seed=9)[0][7]
    found = find_bad_images(images, lamps)
    assert list(found.left_out) == [7]
    assert "times worse" in found.left_out[7]
    assert_array_equal(found.kept(20), np.arange(20) != 7)


def test_a_wrong_lamp_is_found_as_well() -> None:
    images, lamps = scene(40)
    lamps[[3, 30]] = lamps[[30, 3]]
    assert set(find_bad_images(images, lamps).left_out) == {3, 30}


def test_observations_that_are_not_used_are_no_reason() -> None:
    images, lamps = scene(40)
    usable = np.ones(images.shape, bool)
    usable[5, ::2] = False
    images[5, ::2] = 3.0
    assert find_bad_images(images, lamps, usable=usable).left_out == {}
    assert find_bad_images(images, lamps, saturation=3.0).left_out == {}
    assert set(find_bad_images(images, lamps).left_out) == {5}


def test_the_brightness_of_lamps_does_not_matter() -> None:
    images, lamps = scene(40)
    images[11] = images[11, ::-1]
    brightness = np.geomspace(1, 100, 40)[:, None]
    assert set(find_bad_images(images * brightness, lamps * brightness).left_out) == {11}


def test_too_few_photographs_or_pixels_tell_nothing() -> None:
    images, lamps = scene(FEWEST - 1)
    images[2] = images[2, ::-1]
    assert find_bad_images(images, lamps).left_out == {}
    images, lamps = scene(20)
    assert find_bad_images(np.zeros_like(images), lamps).left_out == {}


def test_where_half_are_wrong_nobody_can_say_which() -> None:
    images, lamps = scene(40)
    generator = np.random.default_rng(1)
    for index in range(20):
        images[index] = images[index, generator.permutation(500)]
    assert len(find_bad_images(images, lamps).left_out) <= MOST * 40


def test_the_seed_is_a_seed() -> None:
    images, lamps = scene(20)
    with pytest.raises(HarmonicFaceError, match="seed"):
        find_bad_images(images, lamps, seed=-1)


@pytest.fixture(scope="module")
def cat(data_dir: Path) -> DiligentObject:
    return load_diligent(data_dir / "diligent" / "catPNG")


def blurred(image: np.ndarray) -> np.ndarray:
    return gaussian_filter(image, 4)


def displaced(image: np.ndarray) -> np.ndarray:
    return np.roll(image, (3, 3), (0, 1))


def dimmed_in_part(image: np.ndarray) -> np.ndarray:
    """What a reflector or an occluder does: a band of a third of the object has 0.7 of its light."""
    changed = image.copy()
    changed[250:330] *= 0.7
    return changed


@pytest.mark.data
@pytest.mark.parametrize("spoil", [blurred, displaced, dimmed_in_part])
def test_the_first_twenty_of_a_real_object_are_found(
    cat: DiligentObject, spoil: Callable[[np.ndarray], np.ndarray]
) -> None:
    images = cat.grey()
    picture = np.zeros(cat.mask.shape)
    for index in range(20):
        picture[cat.mask] = images[index]
        images[index] = spoil(picture)[cat.mask]
    assert sorted(find_bad_images(images, cat.directions).left_out) == list(range(20))


@pytest.mark.data
def test_swapped_photographs_of_a_real_object_are_found(cat: DiligentObject) -> None:
    images = cat.grey()
    assert find_bad_images(images, cat.directions).left_out == {}
    images[[10, 60]] = images[[60, 10]]
    assert sorted(find_bad_images(images, cat.directions).left_out) == [10, 60]
