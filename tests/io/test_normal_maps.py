"""Normal maps: 16 bits there and back, and what is no normal map is refused."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.normal_maps import read_normal_map, write_normal_map


@pytest.fixture
def normals():
    vectors = np.random.default_rng(0).normal(size=(12, 9, 3))
    vectors /= np.linalg.norm(vectors, axis=2, keepdims=True)
    vectors[3:5, 2:4] = 0
    return vectors


def test_there_and_back_within_sixteen_bits(tmp_path, normals):
    write_normal_map(tmp_path / "a.png", normals)
    back = read_normal_map(tmp_path / "a.png")
    np.testing.assert_allclose(back, normals, atol=2.0 / 65535)
    assert (back[3:5, 2:4] == 0).all()
    assert back.dtype == np.float32


def test_eight_bits_are_scaled_to_unit_length(tmp_path, normals):
    Image.fromarray(np.rint((normals + 1) / 2 * 255).astype(np.uint8)).save(tmp_path / "a.png")
    back = read_normal_map(tmp_path / "a.png")
    inside = normals.any(axis=2)
    np.testing.assert_allclose(np.linalg.norm(back[inside], axis=1), 1, atol=1e-6)
    np.testing.assert_allclose(back, normals, atol=0.01)
    assert (back[~inside] == 0).all()  # middle grey means no surface, like black


@pytest.mark.parametrize("name", ["a.png", "a.npy"])
def test_green_may_point_down(tmp_path, normals, name):
    if name == "a.png":
        write_normal_map(tmp_path / name, normals)
    else:
        np.save(tmp_path / name, normals)
    back = read_normal_map(tmp_path / name, green="down")
    np.testing.assert_allclose(back, normals * [1, -1, 1], atol=2.0 / 65535)
    with pytest.raises(HarmonicFaceError, match=r"green: expected 'up' .* got 'sideways'"):
        read_normal_map(tmp_path / name, green="sideways")


def test_an_npy_file_holds_the_vectors_themselves(tmp_path, normals):
    np.save(tmp_path / "a.npy", normals)
    np.testing.assert_allclose(read_normal_map(tmp_path / "a.npy"), normals, atol=1e-7)


def test_what_is_no_normal_map_is_refused(tmp_path, normals):
    Image.fromarray(np.full((4, 4), 128, dtype=np.uint8)).save(tmp_path / "grey.png")
    with pytest.raises(HarmonicFaceError, match="expected an RGB normal map"):
        read_normal_map(tmp_path / "grey.png")
    Image.fromarray(np.full((4, 4, 3), 255, dtype=np.uint8)).save(tmp_path / "white.png")
    with pytest.raises(HarmonicFaceError, match=r"about unit length, got 16 others \(length 1\.73\)"):
        read_normal_map(tmp_path / "white.png")
    normals[0, 0, 0] = np.nan
    np.save(tmp_path / "nan.npy", normals)
    with pytest.raises(HarmonicFaceError, match="expected finite normals"):
        read_normal_map(tmp_path / "nan.npy")


def test_bad_writes_are_refused_and_leave_nothing(tmp_path, normals):
    for name, array, message in [
        ("a.jpg", normals, r"ends in \.png"),
        ("a.png", normals[..., 0], r"normals: expected shape \(h, w, 3\)"),
        ("a.png", normals * 2, "normals: expected unit vectors"),
        ("a.png", normals * np.nan, "normals: expected finite"),
    ]:
        with pytest.raises(HarmonicFaceError, match=message):
            write_normal_map(tmp_path / name, array)
    assert list(tmp_path.iterdir()) == []
