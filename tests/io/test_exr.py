"""OpenEXR and PFM: what was stored is read, and what is no picture is refused in one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenEXR
import pytest

import harmonicface as hf
from harmonicface.io.exr import exr_pixels

PIXELS = np.random.default_rng(0).gamma(0.3, 5.0, (32, 48, 3)).astype(np.float32)
LOSSLESS = ("NO", "RLE", "ZIPS", "ZIP", "PIZ")


def stored(path: Path, channels: dict[str, np.ndarray], compression: str = "ZIP") -> bytes:
    header = {"compression": getattr(OpenEXR, f"{compression}_COMPRESSION"), "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, channels).write(str(path))
    return path.read_bytes()


@pytest.mark.parametrize("compression", LOSSLESS)
@pytest.mark.parametrize("dtype", [np.float32, np.float16])
def test_lossless_compressions_come_back_bit_for_bit(tmp_path: Path, compression: str, dtype: type) -> None:
    pixels = PIXELS.astype(dtype)
    stored(tmp_path / "a.exr", {"RGB": pixels}, compression)
    np.testing.assert_array_equal(hf.read_image(tmp_path / "a.exr"), pixels.astype(np.float32))


def test_grey_alpha_and_further_channels(tmp_path: Path) -> None:
    grey = PIXELS[..., 0].copy()
    np.testing.assert_array_equal(exr_pixels(stored(tmp_path / "a.exr", {"Y": grey})), grey)
    np.testing.assert_array_equal(exr_pixels(stored(tmp_path / "a.exr", {"depth": grey})), grey)
    many = {"RGBA": np.concatenate([PIXELS, PIXELS[..., :1]], axis=-1), "Z": grey}
    np.testing.assert_array_equal(exr_pixels(stored(tmp_path / "a.exr", many)), PIXELS)


@pytest.mark.parametrize(
    ("channels", "message"),
    [
        ({"U": PIXELS[..., 0].copy(), "V": PIXELS[..., 1].copy()}, "expected the OpenEXR channels R G B or Y, got U V"),
        ({"Y": np.ones((4, 4), np.uint32)}, r"expected channels of floats of one size, got Y \(4, 4\) uint32"),
    ],
)
def test_channels_that_are_no_picture(tmp_path: Path, channels: dict[str, np.ndarray], message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        exr_pixels(stored(tmp_path / "a.exr", channels))


def test_damage_is_refused_in_one_line_and_silently(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    data = stored(
        tmp_path / "a.exr", {"RGB": np.tile(np.linspace(0, 1, 64, dtype=np.float32)[:, None, None], (1, 64, 3))}
    )
    refused = 0
    for place in range(400, len(data), 37):
        flipped = bytearray(data)
        flipped[place] ^= 0x55
        (tmp_path / "b.exr").write_bytes(flipped)
        try:
            hf.read_image(tmp_path / "b.exr")
        except hf.HarmonicFaceError as error:
            assert "\n" not in str(error)
            refused += 1
    assert refused > 5  # ZIP has a checksum a block
    (tmp_path / "b.exr").write_bytes(b"no picture at all")
    with pytest.raises(
        hf.HarmonicFaceError, match=r"b\.exr: expected a whole image, got an OpenEXR cut short or corrupt"
    ):
        hf.read_image(tmp_path / "b.exr")
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(("mark", "shape"), [(b"PF", (3, 5, 3)), (b"Pf", (3, 5))])
@pytest.mark.parametrize(("scale", "order"), [(b"-1.0", "<f4"), (b"1.0", ">f4")])
def test_pfm_by_its_definition(tmp_path: Path, mark: bytes, shape: tuple[int, ...], scale: bytes, order: str) -> None:
    pixels = np.random.default_rng(1).uniform(0, 9, shape).astype(np.float32)
    rows = pixels[::-1].astype(order).tobytes()  # from the bottom to the top
    (tmp_path / "a.pfm").write_bytes(mark + b"\n5 3\n" + scale + b"\n" + rows)
    np.testing.assert_array_equal(hf.read_image(tmp_path / "a.pfm"), pixels)
