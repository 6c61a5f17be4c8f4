"""Environment maps from files: every format and layout, and one line for each that is none."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import OpenEXR
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import harmonicface as hf
from harmonicface.io.transfer import srgb_to_linear
from harmonicface.lighting.cube import FACES, cross_of_faces

RADIANCE = np.random.default_rng(4).gamma(0.5, 4.0, (8, 16, 3)).astype(np.float32)


def write_exr(path: Path, radiance: np.ndarray) -> None:
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, {"RGB": radiance}).write(
        str(path)
    )


def write_opencv(path: Path, radiance: np.ndarray) -> None:
    assert cv2.imwrite(str(path), np.ascontiguousarray(radiance[..., ::-1]))


WRITERS: dict[str, Callable[[Path, np.ndarray], None]] = {
    ".exr": write_exr,
    ".pfm": write_opencv,
    ".tif": write_opencv,
    ".npy": lambda path, radiance: np.save(path, radiance),
}


@pytest.mark.parametrize("ending", WRITERS)
def test_formats_of_floats_come_back_bit_for_bit(tmp_path: Path, ending: str) -> None:
    WRITERS[ending](tmp_path / f"sky{ending}", RADIANCE)
    assert_array_equal(hf.EnvironmentMap.load(tmp_path / f"sky{ending}").radiance, RADIANCE)


def test_sixteen_and_eight_bits(tmp_path: Path) -> None:
    deep = np.random.default_rng(0).integers(0, 65536, (4, 8, 3), np.uint16)
    write_opencv(tmp_path / "sky.tiff", deep)
    assert_allclose(hf.EnvironmentMap.load(tmp_path / "sky.tiff").radiance, deep / 65535, rtol=1e-6)
    shallow = np.random.default_rng(0).integers(0, 256, (4, 8, 3), np.uint8)
    write_opencv(tmp_path / "sky.png", shallow)
    assert_allclose(hf.EnvironmentMap.load(tmp_path / "sky.png").radiance, srgb_to_linear(shallow / 255), rtol=1e-5)
    linear = hf.EnvironmentMap.load(tmp_path / "sky.png", transfer="linear").radiance
    assert_allclose(linear, shallow / 255, rtol=1e-6)


@pytest.fixture
def faces(tmp_path: Path) -> np.ndarray:
    """Six faces in a folder, and what they hold."""
    pixels = np.random.default_rng(1).uniform(size=(6, 4, 4, 3)).astype(np.float32)
    for name, face in zip(FACES, pixels, strict=True):
        np.save(tmp_path / f"{name}.npy", face)
    return pixels


def test_a_cube_from_a_folder_from_six_files_and_from_crosses(tmp_path: Path, faces: np.ndarray) -> None:
    (tmp_path / "readme.txt").write_text("not a face")
    assert_array_equal(hf.EnvironmentMap.load(tmp_path, layout="cube").radiance, faces)
    files = [tmp_path / f"{name}.npy" for name in FACES]
    assert_array_equal(hf.EnvironmentMap.load(files, layout="cube").radiance, faces)
    cross = cross_of_faces(faces)
    np.save(tmp_path / "cross.npy", cross)
    assert_array_equal(hf.EnvironmentMap.load(tmp_path / "cross.npy", layout="cube").radiance, faces)


def test_a_face_that_is_missing_or_there_twice(tmp_path: Path, faces: np.ndarray) -> None:
    np.save(tmp_path / "NX.npy", faces[1])
    with pytest.raises(hf.HarmonicFaceError, match="expected one file a face, got several for nx"):
        hf.EnvironmentMap.load(tmp_path, layout="cube")
    for name in ("NX", "nx", "py"):
        (tmp_path / f"{name}.npy").unlink()
    with pytest.raises(hf.HarmonicFaceError, match=r"expected the faces px nx .*, got none named nx py") as caught:
        hf.EnvironmentMap.load(tmp_path, layout="cube")
    assert "\n" not in str(caught.value)


def test_faces_that_do_not_fit(tmp_path: Path, faces: np.ndarray) -> None:
    files = [tmp_path / f"{name}.npy" for name in FACES]
    with pytest.raises(hf.HarmonicFaceError, match="path: expected six faces, px nx py ny pz nz, got 5"):
        hf.EnvironmentMap.load(files[:5], layout="cube")
    with pytest.raises(hf.HarmonicFaceError, match="path: expected a file of the layout 'latlong', got list"):
        hf.EnvironmentMap.load(files)
    with pytest.raises(hf.HarmonicFaceError, match="path: expected a file of the layout 'cube', got int"):
        hf.EnvironmentMap.load(6, layout="cube")  # type: ignore[arg-type]
    np.save(files[2], faces[2, :3])
    with pytest.raises(hf.HarmonicFaceError, match=r"py\.npy: expected a square face, got 4 x 3"):
        hf.EnvironmentMap.load(tmp_path, layout="cube")
    np.save(files[2], faces[2, :3, :3])
    with pytest.raises(hf.HarmonicFaceError, match=r"py\.npy: expected the shape of .*, got \(3, 3, 3\)"):
        hf.EnvironmentMap.load(tmp_path, layout="cube")


@pytest.mark.parametrize(
    ("shape", "layout", "message"),
    [
        ((8, 8), "latlong", r"map\.npy: expected a map twice as wide as high, got 8 x 8"),
        ((8, 16), "angular", r"map\.npy: expected a square map \(angular\), got 16 x 8"),
        ((8, 16), "mirrorball", r"map\.npy: expected a square map \(mirrorball\), got 16 x 8"),
        ((8, 8), "cube", r"map\.npy: expected a cross of 4 x 3 or 3 x 4 squares, got 8 x 8 pixels"),
    ],
)
def test_pictures_of_other_proportions(tmp_path: Path, shape: tuple[int, int], layout: str, message: str) -> None:
    np.save(tmp_path / "map.npy", np.ones(shape))
    with pytest.raises(hf.HarmonicFaceError, match=message):
        hf.EnvironmentMap.load(tmp_path / "map.npy", layout=layout)


@pytest.mark.parametrize("ending", [*WRITERS, ".hdr"])
def test_a_file_cut_short_is_refused_wherever_it_is_cut(tmp_path: Path, ending: str) -> None:
    whole, cut = tmp_path / f"whole{ending}", tmp_path / f"cut{ending}"
    WRITERS.get(ending, write_opencv)(whole, RADIANCE)
    data = whole.read_bytes()
    for length in (0, 3, len(data) // 4, len(data) // 2, len(data) - 1):
        cut.write_bytes(data[:length])
        with pytest.raises(hf.HarmonicFaceError, match=f"cut{ending}: expected") as caught:
            hf.EnvironmentMap.load(cut)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("value", "message"), [(-1.0, "at least 0, got -1"), (np.nan, "finite pixels, got 1 NaN")])
@pytest.mark.parametrize("ending", WRITERS)
def test_bad_pixels_are_refused(tmp_path: Path, ending: str, value: float, message: str) -> None:
    bad = RADIANCE.copy()
    bad[3, 5, 1] = value
    WRITERS[ending](tmp_path / f"bad{ending}", bad)
    with pytest.raises(hf.HarmonicFaceError, match=message):
        hf.EnvironmentMap.load(tmp_path / f"bad{ending}")


@pytest.mark.data
def test_every_measured_environment_is_read(data_dir: Path) -> None:
    seen = 0
    for layout in ("latlong", "angular", "cube"):
        for path in sorted((data_dir / "probes" / layout).iterdir()):
            light = hf.EnvironmentMap.load(path, layout=layout)
            assert light.channels == 3
            # light comes from above in every one of them
            assert (light.coefficients(1)[1] > 0).all(), path
            seen += 1
    assert seen >= 3
