"""Depth maps: the numbers as stored, in the units and of the kind that the caller names."""

from __future__ import annotations

import cv2
import numpy as np
import OpenEXR
import pytest
from PIL import Image

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.depth_maps import read_depth_map

STEPS = np.array([[1500, 0, 65535], [1, 40000, 300]], dtype=np.uint16)
FLOATS = np.array([[1.5, np.nan, 3.25], [0.0, 0.5, 100.0]], dtype=np.float32)


def test_sixteen_bits_are_read_whole_and_never_as_srgb(tmp_path):
    Image.fromarray(STEPS).save(tmp_path / "a.png")
    np.save(tmp_path / "a.npy", STEPS)
    for name in ("a.png", "a.npy"):
        distance = read_depth_map(tmp_path / name, "distance", scale=0.001)
        assert distance.dtype == np.float32
        np.testing.assert_allclose(distance, np.where(STEPS == 0, np.nan, STEPS / -1000), rtol=1e-7)
        height = read_depth_map(tmp_path / name, "height", scale=2.0, invalid=65535)
        np.testing.assert_allclose(height, np.where(STEPS == 65535, np.nan, 2.0 * STEPS), rtol=1e-7)
    assert (read_depth_map(tmp_path / "a.png", "height", invalid=None) == STEPS).all()


def test_eight_bits_are_numbers_too(tmp_path):
    Image.fromarray(np.array([[0, 10, 255]], dtype=np.uint8)).save(tmp_path / "a.png")
    np.testing.assert_array_equal(read_depth_map(tmp_path / "a.png", "height"), [[np.nan, 10, 255]])


def test_floats_of_every_format(tmp_path):
    np.save(tmp_path / "a.npy", FLOATS)
    cv2.imwrite(str(tmp_path / "a.tiff"), FLOATS)
    cv2.imwrite(str(tmp_path / "a.pfm"), FLOATS)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {"Z": FLOATS}) as file:
        file.write(str(tmp_path / "a.exr"))
    expected = np.where(FLOATS == 0, np.nan, -FLOATS)
    for name in ("a.npy", "a.tiff", "a.pfm", "a.exr"):
        np.testing.assert_allclose(read_depth_map(tmp_path / name, "distance"), expected, rtol=1e-7)
    np.save(tmp_path / "d.npy", FLOATS.astype(np.float64))
    assert read_depth_map(tmp_path / "d.npy", "distance").dtype == np.float64


def test_too_far_is_a_hole_but_infinitely_high_is_wrong(tmp_path):
    np.save(tmp_path / "a.npy", np.array([[1.0, np.inf]]))
    np.testing.assert_array_equal(read_depth_map(tmp_path / "a.npy", "distance"), [[-1, np.nan]])
    with pytest.raises(HarmonicFaceError, match="expected finite heights, got infinite ones"):
        read_depth_map(tmp_path / "a.npy", "height")
    np.save(tmp_path / "b.npy", np.array([[1.0, -np.inf]]))
    with pytest.raises(HarmonicFaceError, match="expected finite distances"):
        read_depth_map(tmp_path / "b.npy", "distance")


@pytest.mark.parametrize(
    ("array", "arguments", "message"),
    [
        (np.ones((2, 2)), {"kind": "depth"}, "kind: expected 'distance' or 'height', got 'depth'"),
        (np.ones((2, 2)), {"scale": 0}, "scale: expected a finite number above 0"),
        (np.ones((2, 2)), {"scale": np.nan}, "scale: expected a finite number above 0"),
        (np.ones((2, 2, 3)), {}, "expected a depth map of one channel of numbers"),
        (np.ones((2, 2), dtype=bool), {}, "expected a depth map of one channel of numbers"),
        (np.full((2, 2), np.nan), {}, "expected some pixels with depth, got none of 4"),
        (np.zeros((2, 2)), {}, "expected some pixels with depth, got none of 4"),
        (-np.ones((2, 2)), {}, "expected distances of at least 0, got -1"),
        (np.full((2, 2), 1e30, dtype=np.float32), {"scale": 1e30}, "expected distances that float32 holds"),
    ],
)
def test_bad_depth_maps_are_refused(tmp_path, array, arguments, message):
    np.save(tmp_path / "a.npy", array)
    with pytest.raises(HarmonicFaceError, match=message) as caught:
        read_depth_map(tmp_path / "a.npy", **({"kind": "distance"} | arguments))
    assert "\n" not in str(caught.value)


def test_missing_files_are_refused(tmp_path):
    with pytest.raises(HarmonicFaceError, match="No such file"):
        read_depth_map(tmp_path / "none.png", "height")


def test_a_signalling_nan_is_a_hole_without_a_warning(tmp_path):
    array = np.array([[1.0, 2.0]], dtype=np.float32)
    array.view(np.uint32)[0, 1] = 0x7F800001
    np.save(tmp_path / "a.npy", array)
    np.testing.assert_array_equal(read_depth_map(tmp_path / "a.npy", "distance"), [[-1, np.nan]])
