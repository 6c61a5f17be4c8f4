from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from harmonicface.datasets import photographs
from harmonicface.datasets.photographs import images_in, opened_photographs, photograph_files
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.images import read_image

SHAPE = (70, 9)  # more rows than are decoded at a time
MASK = np.random.default_rng(1).uniform(size=SHAPE) > 0.5


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Colour photographs in 16 bits, one pixel of one colour burnt out, and pictures that are none."""
    random = np.random.default_rng(0)
    for number in (1, 2, 10):
        colours = random.integers(0, 60000, (*SHAPE, 3)).astype(np.uint16)
        colours[3, 4, 1] = 65535
        cv2.imwrite(str(tmp_path / f"photo_{number}.png"), colours)
    for name in ("mask.png", "Normals.png", ".hidden.png"):
        cv2.imwrite(str(tmp_path / name), np.zeros(SHAPE, np.uint8))
    (tmp_path / "lights.txt").write_text("0 0 1\n")
    return tmp_path


def test_a_folder_holds_its_photographs_in_the_order_of_their_numbers(folder: Path) -> None:
    assert [file.name for file in images_in(folder)] == ["photo_1.png", "photo_2.png", "photo_10.png"]
    files = [folder / "photo_2.png", folder / "mask.png"]
    assert photograph_files(files) == files  # what is named is meant


def test_grey_is_the_mean_and_saturated_where_one_colour_is(folder: Path) -> None:
    files = photograph_files([folder])
    with opened_photographs(files) as found:
        assert found.names == ("photo_1.png", "photo_2.png", "photo_10.png") and found.coloured
        assert found.images.shape == (3, *SHAPE) and found.images.dtype == np.float32
        for image, file in zip(found.images, files, strict=True):
            expected = read_image(file).mean(axis=2)
            expected[3, 4] = 1
            assert_allclose(image, expected, atol=1e-6)
        assert_array_equal(found.brightest, np.asarray(found.images).max(axis=0))


def test_colours_are_read_again(folder: Path) -> None:
    files = photograph_files([folder])
    with opened_photographs(files) as found:
        colours = found.colours(1, MASK | (np.indices(SHAPE).sum(axis=0) == 7))
    inside = MASK | (np.indices(SHAPE).sum(axis=0) == 7)
    expected = read_image(files[1])[inside]
    full = np.zeros(SHAPE, bool)
    full[3, 4] = True
    assert np.isinf(colours[full[inside]]).all()
    assert_allclose(colours[~full[inside]], expected[~full[inside]], atol=1e-6)


def test_balanced_colours_weigh_alike(folder: Path) -> None:
    files = photograph_files([folder])
    balance = np.array([[2.0, 0.5, 0.5]] * 3)
    with opened_photographs(files, balance=balance) as found:
        expected = (read_image(files[0]) * balance[0]).mean(axis=2)
        expected[3, 4] = 1
        assert_allclose(found.images[0], expected, atol=1e-6)


def test_squares_become_pixels(folder: Path) -> None:
    files = photograph_files([folder])
    with opened_photographs(files, reduce=2) as found:
        assert found.shape == (35, 4)
        expected = read_image(files[0])[:, :8].mean(axis=2).reshape(35, 2, 4, 2).mean(axis=(1, 3))
        expected[1, 2] = 1
        assert_allclose(found.images[0], expected, atol=1e-6)
        assert found.colours(0, np.ones((35, 4), bool)).shape == (140, 3)


def test_many_photographs_are_held_in_a_file_that_goes(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files = photograph_files([folder])
    with opened_photographs(files) as found:
        expected = np.array(found.images)
    monkeypatch.setattr(photographs, "LARGE", 100)
    place = folder / "out"
    place.mkdir()
    with opened_photographs(files, folder=place) as found:
        assert isinstance(found.images, np.memmap)
        assert len(list(place.iterdir())) == 1
        assert_array_equal(found.images, expected)
    assert list(place.iterdir()) == []


def test_grey_files_in_three_colours_have_no_colour(tmp_path: Path) -> None:
    grey = np.random.default_rng(0).integers(0, 255, SHAPE).astype(np.uint8)
    cv2.imwrite(str(tmp_path / "a.png"), np.repeat(grey[..., None], 3, axis=2))
    cv2.imwrite(str(tmp_path / "b.png"), grey)
    with opened_photographs(photograph_files([tmp_path]), transfer="linear") as found:
        assert not found.coloured
        assert_allclose(found.images[0], found.images[1], atol=1e-6)
        assert found.colours(1, MASK).shape == (MASK.sum(), 3)


def test_refuses_what_are_no_photographs_of_one_size(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    files = photograph_files([folder])
    empty = tmp_path_factory.mktemp("empty")
    with pytest.raises(HarmonicFaceError, match=r"expected a folder of photographs \(.*\), got none in it"):
        photograph_files([empty])
    with pytest.raises(HarmonicFaceError, match="No such file"):
        images_in(empty / "none")
    with pytest.raises(HarmonicFaceError, match="expected photographs, got none"):
        photograph_files([])
    with pytest.raises(HarmonicFaceError, match=r"expected each photograph once, got .*photo_1.png twice"):
        photograph_files([folder, folder / "photo_1.png"])
    cv2.imwrite(str(folder / "photo_3.png"), np.zeros((9, 70), np.uint8))
    message = r"photo_3.png: expected 9 x 70 pixels as photo_1.png has, got 70 x 9"
    with pytest.raises(HarmonicFaceError, match=message), opened_photographs(photograph_files([folder])):
        pass
    with (
        pytest.raises(HarmonicFaceError, match="reduce: expected at most 9 pixels"),
        opened_photographs(files, reduce=10),
    ):
        pass
    np.save(folder / "photo_2.npy", np.full(SHAPE, -1.0))
    message = r"photo_2.npy: expected finite pixels of at least 0"
    with pytest.raises(HarmonicFaceError, match=message), opened_photographs([files[0], folder / "photo_2.npy"]):
        pass


def test_a_disk_that_is_full_is_told(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(photographs, "LARGE", 100)
    files = photograph_files([folder])
    message = r"expected 7.56e-06 GB of disk in .*, got No such file"
    with pytest.raises(HarmonicFaceError, match=message), opened_photographs(files, folder=folder / "none"):
        pass
