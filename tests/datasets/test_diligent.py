from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.io import savemat

from harmonicface.datasets.diligent import LUMINANCE, load_diligent
from harmonicface.errors import HarmonicFaceError

SHAPE = (6, 5)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A made-up object of three photographs, with all the files of the data set."""
    root = tmp_path / "cubePNG"
    root.mkdir()
    generator = np.random.default_rng(0)
    mask = np.zeros(SHAPE, np.uint8)
    mask[1:5, 1:4] = 255
    cv2.imwrite(str(root / "mask.png"), mask)
    for number in (1, 2, 10):
        cv2.imwrite(str(root / f"{number:03d}.png"), generator.integers(0, 65000, (*SHAPE, 3)).astype(np.uint16))
    (root / "light_directions.txt").write_text("0 0 1\n0.6 0 0.8\n0 0.6 0.8\n")
    (root / "light_intensities.txt").write_text("1 2 4\n2 2 2\n.5 1 1\n")
    normals = np.zeros((*SHAPE, 3))
    normals[mask > 0] = [0.0, 0.6, 0.8]
    savemat(root / "Normal_gt.mat", {"Normal_gt": normals})
    return root


def test_reads_the_mask_the_lamps_and_the_normals(folder: Path) -> None:
    found = load_diligent(folder)
    assert found.name == "cubePNG"
    assert [path.name for path in found.files] == ["001.png", "002.png", "010.png"]
    assert found.mask.sum() == 12
    assert found.pixels.shape == (3, 12, 3)
    assert found.pixels.dtype == np.float32
    stored = cv2.imread(str(folder / "002.png"), cv2.IMREAD_UNCHANGED)[found.mask][:, ::-1]  # red first
    assert_allclose(found.pixels[1], stored / 65535, atol=1e-7)
    assert_allclose(found.normals, np.tile([0.0, 0.6, 0.8], (12, 1)))
    assert_allclose(found.directions[1], [0.6, 0.0, 0.8])


def test_grey_divides_each_colour_by_its_lamp(folder: Path) -> None:
    found = load_diligent(folder)
    assert_allclose(found.grey()[0], (found.pixels[0] / [1, 2, 4]).mean(axis=1), rtol=1e-5)
    assert_allclose(found.grey(divided=False), found.pixels.mean(axis=2), rtol=1e-5)
    assert_allclose(found.grey(luminance=True)[0], found.pixels[0] @ (LUMINANCE / [1, 2, 4]), rtol=1e-5)


def test_saturated_where_any_colour_is(folder: Path) -> None:
    white = np.full((*SHAPE, 3), 40000, np.uint16)
    white[2, 2, 1] = 65535
    cv2.imwrite(str(folder / "001.png"), white)
    saturated = load_diligent(folder).saturated()
    assert saturated.shape == (3, 12)
    assert saturated.sum() == 1
    assert saturated[0, 4]  # row 2, column 2 of the picture is row 1, column 1 of the mask


def test_the_list_of_names_tells_the_order(folder: Path) -> None:
    (folder / "filenames.txt").write_text("010.png\r\n001.png\r\n002.png\r\n")
    assert [path.name for path in load_diligent(folder).files] == ["010.png", "001.png", "002.png"]


def test_a_normal_that_was_not_measured_is_zero(folder: Path) -> None:
    normals = np.tile([0.0, 0.6, 0.8], (*SHAPE, 1))
    normals[1, 1], normals[1, 2] = np.nan, 0.0
    savemat(folder / "Normal_gt.mat", {"Normal_gt": normals})
    assert_array_equal(load_diligent(folder).normals.any(axis=1), [False, False] + 10 * [True])


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("filenames.txt", "", "expected pictures 001.png"),
        ("filenames.txt", "001.png 002.png lost.png", "lost.png: expected an image"),
        ("light_directions.txt", "0 0 1\n", "for each of 3 pictures, got"),
        ("light_directions.txt", "0 0 1\n0 one 0\n0 0 1", "three numbers in each line"),
        ("light_directions.txt", "0 0 1\n0 0 0\n0 0 1", "with a direction and a brightness"),
        ("light_intensities.txt", "1 1 1\n1 -1 1\n1 1 1", "with a direction and a brightness"),
        ("light_intensities.txt", "1 1 1\n1 nan 1\n1 1 1", "three finite numbers"),
        ("Normal_gt.mat", "nothing", "expected a MATLAB file"),
        ("mask.png", "nothing", "mask.png: expected a PNG"),
    ],
)
def test_a_damaged_file_is_named(folder: Path, name: str, content: str, message: str) -> None:
    (folder / name).write_text(content)
    with pytest.raises(HarmonicFaceError, match=message):
        load_diligent(folder)


@pytest.mark.parametrize("name", ["light_directions.txt", "light_intensities.txt", "mask.png", "Normal_gt.mat"])
def test_a_missing_file_is_named(folder: Path, name: str) -> None:
    (folder / name).unlink()
    with pytest.raises(HarmonicFaceError, match=name):
        load_diligent(folder)


def test_pictures_and_normals_that_do_not_fit_are_refused(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(HarmonicFaceError, match="got no folder"):
        load_diligent(tmp_path / "nowhere")
    savemat(folder / "Normal_gt.mat", {"other": np.zeros(3)})
    with pytest.raises(HarmonicFaceError, match="a matrix Normal_gt, got none"):
        load_diligent(folder)
    savemat(folder / "Normal_gt.mat", {"Normal_gt": np.zeros((3, 4, 3))})
    with pytest.raises(HarmonicFaceError, match=r"normals of shape \(6, 5, 3\)"):
        load_diligent(folder)
    savemat(folder / "Normal_gt.mat", {"Normal_gt": np.zeros((*SHAPE, 3))})
    with pytest.raises(HarmonicFaceError, match="unit normals in the mask, got none"):
        load_diligent(folder)
    savemat(folder / "Normal_gt.mat", {"Normal_gt": np.tile([0.0, 0.6, 0.8], (*SHAPE, 1))})
    cv2.imwrite(str(folder / "002.png"), np.zeros((3, 3, 3), np.uint16))
    with pytest.raises(HarmonicFaceError, match=r"002.png: expected a colour picture"):
        load_diligent(folder)
    cv2.imwrite(str(folder / "mask.png"), np.zeros(SHAPE, np.uint8))
    with pytest.raises(HarmonicFaceError, match="expected an object in the mask"):
        load_diligent(folder)


@pytest.mark.data
@pytest.mark.parametrize(("name", "pixels", "published"), [("ball", 15791, 4.10), ("cat", 45200, 8.41)])
def test_least_squares_is_as_published(data_dir: Path, name: str, pixels: int, published: float) -> None:
    found = load_diligent(data_dir / "diligent" / f"{name}PNG")
    assert found.pixels.shape == (96, pixels, 3)
    scaled = np.linalg.lstsq(found.directions, found.grey(luminance=True), rcond=None)[0].T
    cosines = np.einsum("pi,pi->p", scaled, found.normals) / np.linalg.norm(scaled, axis=1)
    assert abs(np.degrees(np.arccos(np.clip(cosines, -1, 1))).mean() - published) < 0.6
