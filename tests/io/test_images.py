"""Images: every format reads back what was stored, and every cut is refused."""

from __future__ import annotations

import io
import struct
import zlib

import cv2
import numpy as np
import pytest
import tifffile
from PIL import Image

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.images import read_image, write_image
from harmonicface.io.pixels import read_pixels
from harmonicface.io.transfer import srgb_to_linear

RNG = np.random.default_rng(0)
GREY8 = RNG.integers(0, 256, (21, 30), dtype=np.uint8)
COLOUR8 = RNG.integers(0, 256, (21, 30, 3), dtype=np.uint8)
GREY16 = RNG.integers(0, 65536, (21, 30), dtype=np.uint16)
COLOUR16 = RNG.integers(0, 65536, (21, 30, 3), dtype=np.uint16)
FLOAT = RNG.random((21, 30, 3)).astype(np.float32) * 5


def opencv(ending, array):
    stored = array[..., ::-1] if array.ndim == 3 else array
    return cv2.imencode(ending, stored)[1].tobytes()


def pillow(array, kind, **options):
    stream = io.BytesIO()
    picture = array if isinstance(array, Image.Image) else Image.fromarray(array)
    picture.save(stream, kind, **options)
    return stream.getvalue()


def tiff(array, **options):
    stream = io.BytesIO()
    photometric = "rgb" if array.ndim == 3 else "minisblack"
    tifffile.imwrite(stream, array, photometric=photometric, **options)
    return stream.getvalue()


def npy(array):
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


# name -> (bytes, what it stores, what its default transfer is)
LOSSLESS = {
    "grey8.png": (opencv(".png", GREY8), GREY8, "srgb"),
    "colour8.png": (opencv(".png", COLOUR8), COLOUR8, "srgb"),
    "grey16.png": (opencv(".png", GREY16), GREY16, "linear"),
    "colour16.png": (opencv(".png", COLOUR16), COLOUR16, "linear"),
    "grey8.pgm": (opencv(".pgm", GREY8), GREY8, "linear"),
    "colour8.ppm": (opencv(".ppm", COLOUR8), COLOUR8, "linear"),
    "grey16.pgm": (opencv(".pgm", GREY16), GREY16, "linear"),
    "colour16.ppm": (opencv(".ppm", COLOUR16), COLOUR16, "linear"),
    "grey8.tif": (tiff(GREY8), GREY8, "srgb"),
    "colour8.tif": (tiff(COLOUR8), COLOUR8, "srgb"),
    "lzw.tiff": (pillow(COLOUR8, "TIFF", compression="tiff_lzw"), COLOUR8, "srgb"),
    "grey16.tif": (tiff(GREY16), GREY16, "linear"),
    "colour16.tif": (tiff(COLOUR16, compression="zlib"), COLOUR16, "linear"),
    "grey32.tif": (tiff(FLOAT[..., 0]), FLOAT[..., 0], "linear"),
    "colour32.tif": (tiff(FLOAT), FLOAT, "linear"),
    "grey8.npy": (npy(GREY8), GREY8, "linear"),
    "colour32.npy": (npy(FLOAT), FLOAT, "linear"),
    "colour64.npy": (npy(FLOAT.astype(np.float64)), FLOAT, "linear"),
}
LOSSY = {
    "grey.jpg": pillow(GREY8, "JPEG", quality=95),
    "colour.jpeg": pillow(COLOUR8, "JPEG", quality=95),
    "progressive.jpg": pillow(COLOUR8, "JPEG", progressive=True),
    "radiance.hdr": opencv(".hdr", FLOAT),
}


def stored(tmp_path, name, data):
    path = tmp_path / name
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("name", LOSSLESS)
def test_what_is_stored_is_read(tmp_path, name):
    data, values, transfer = LOSSLESS[name]
    path = stored(tmp_path, name, data)
    scale = np.iinfo(values.dtype).max if values.dtype.kind == "u" else 1
    linear = values / scale
    np.testing.assert_allclose(read_image(path, transfer="linear"), linear, rtol=1e-6)
    np.testing.assert_allclose(read_image(path, transfer="srgb"), srgb_to_linear(linear), rtol=1e-5, atol=1e-7)
    image = read_image(path)
    np.testing.assert_array_equal(image, read_image(path, transfer=transfer))
    assert image.dtype == np.float32
    assert image.flags.c_contiguous


@pytest.mark.parametrize("quality_of", ["grey.jpg", "colour.jpeg"])
def test_jpeg_is_srgb_and_close_to_what_was_stored(tmp_path, quality_of):
    smooth = np.tile(np.linspace(20, 230, 64).astype(np.uint8), (64, 1))
    smooth = smooth if quality_of == "grey.jpg" else np.stack([smooth, smooth[::-1], smooth.T], axis=2)
    path = stored(tmp_path, quality_of, pillow(smooth, "JPEG", quality=98, subsampling=0))
    np.testing.assert_allclose(read_image(path, transfer="linear"), smooth / 255, atol=0.03)
    np.testing.assert_array_equal(read_image(path), read_image(path, transfer="srgb"))


def test_radiance_is_linear_to_its_eight_bits_of_mantissa(tmp_path):
    image = read_image(stored(tmp_path, "a.hdr", LOSSY["radiance.hdr"]))
    np.testing.assert_allclose(image, FLOAT, atol=FLOAT.max() / 128)


@pytest.mark.parametrize("name", [*LOSSLESS, *LOSSY])
def test_a_file_cut_short_is_refused_wherever_it_is_cut(tmp_path, name):
    data = LOSSLESS[name][0] if name in LOSSLESS else LOSSY[name]
    cuts = {*range(0, 40, 7), *range(len(data) - 20, len(data)), *np.linspace(40, len(data) - 20, 20).astype(int)}
    for cut in sorted(cuts):
        with pytest.raises(HarmonicFaceError) as caught:
            read_image(stored(tmp_path, name, data[:cut]))
        assert "\n" not in str(caught.value), cut


def test_a_flipped_byte_of_a_png_is_refused_or_harmless(tmp_path):
    data = LOSSLESS["colour8.png"][0]
    whole = read_image(stored(tmp_path, "a.png", data))
    for place in RNG.integers(0, len(data), 150):
        flipped = bytearray(data)
        flipped[place] ^= 0x55
        try:
            image = read_image(stored(tmp_path, "b.png", bytes(flipped)))
        except HarmonicFaceError:
            continue
        np.testing.assert_array_equal(image, whole)


def test_bytes_that_are_no_picture_are_refused(tmp_path):
    for name in ("a.png", "a.jpg", "a.pgm", "a.tif", "a.hdr", "a.npy"):
        with pytest.raises(HarmonicFaceError, match=r"a\.\w+: expected"):
            read_image(stored(tmp_path, name, RNG.bytes(500)))


def test_alpha_is_left_out_and_palettes_are_looked_up(tmp_path):
    opaque = np.dstack([COLOUR8, GREY8])
    path = stored(tmp_path, "rgba.png", pillow(opaque, "PNG"))
    np.testing.assert_allclose(read_image(path, "linear"), COLOUR8 / 255, rtol=1e-6)
    path = stored(tmp_path, "la.png", pillow(Image.fromarray(GREY8).convert("LA"), "PNG"))
    np.testing.assert_allclose(read_image(path, "linear"), GREY8 / 255, rtol=1e-6)
    deep = np.dstack([COLOUR16[..., ::-1], GREY16])
    path = stored(tmp_path, "rgba16.png", cv2.imencode(".png", deep)[1].tobytes())
    np.testing.assert_allclose(read_image(path), COLOUR16 / 65535, rtol=1e-6)
    few = Image.fromarray(COLOUR8).quantize(8)
    path = stored(tmp_path, "palette.png", pillow(few, "PNG"))
    np.testing.assert_allclose(read_image(path, "linear"), np.asarray(few.convert("RGB")) / 255, rtol=1e-6)
    path = stored(tmp_path, "bits.png", pillow(Image.fromarray(GREY8 > 99), "PNG"))
    np.testing.assert_array_equal(read_image(path), GREY8 > 99)


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("name", ["a.png", "a.jpg", "deep.png", "a.tif"])
def test_exif_orientation_is_applied(tmp_path, name, orientation):
    corner = np.zeros((16, 24, 3), dtype=np.uint8)
    corner[:8, :8] = 255
    upright = {
        1: corner, 2: corner[:, ::-1], 3: corner[::-1, ::-1], 4: corner[::-1],
        5: corner.transpose(1, 0, 2), 6: corner.transpose(1, 0, 2)[:, ::-1],
        7: corner.transpose(1, 0, 2)[::-1, ::-1], 8: corner.transpose(1, 0, 2)[::-1],
    }[orientation]  # fmt: skip
    exif = Image.Exif()
    exif[274] = orientation
    if name == "deep.png":
        data = with_chunk(opencv(".png", corner.astype(np.uint16) * 257), b"eXIf", exif.tobytes()[6:])
    elif name == "a.tif":
        data = tiff(corner, extratags=[(274, "H", 1, orientation, True)])
    else:
        data = pillow(corner, "PNG" if name == "a.png" else "JPEG", exif=exif)
    image = read_image(stored(tmp_path, name, data), "linear")
    np.testing.assert_allclose(image, upright / 255, atol=0.02)


def with_chunk(png, name, content):
    """A PNG with one chunk more, behind its header."""
    chunk = struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))
    return png[:33] + chunk + png[33:]


def test_a_deep_ppm_is_scaled_by_its_own_maximum(tmp_path):
    values = np.array([[[1000, 250, 0]]], dtype=">u2")
    path = stored(tmp_path, "a.ppm", b"P6 # a comment\n1 1\n1000\n" + values.tobytes())
    np.testing.assert_allclose(read_image(path), [[[1, 0.25, 0]]])
    assert read_pixels(path).transfer == "linear"


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("a.gif", b"", "expected an image .* got the ending '.gif'"),
        ("a.npy", npy(np.array([[np.nan, 1.0]])), "expected finite pixels, got 1 NaN"),
        ("a.npy", npy(np.array([[-0.5, 1.0]])), "expected pixels of at least 0, got -0.5"),
        ("a.npy", npy(np.array([[1, 2]])), "expected 8- or 16-bit or float pixels"),
        ("a.npy", npy(np.zeros((4, 4, 2))), r"expected an image of shape \(h, w\)"),
        ("a.npy", npy(np.zeros((0, 4))), r"expected an image of shape \(h, w\)"),
        ("a.tif", tiff(-FLOAT), "expected pixels of at least 0"),
        ("a.tif", tiff(FLOAT * np.float32(np.nan)), "expected finite pixels"),
        ("a.jpg", pillow(Image.new("CMYK", (8, 8)), "JPEG"), "expected grey or RGB pixels, got the Pillow mode 'CMYK'"),
    ],
)
def test_what_is_no_image_of_light_is_refused(tmp_path, name, data, message):
    with pytest.raises(HarmonicFaceError, match=message):
        read_image(stored(tmp_path, name, data))


def test_a_header_that_promises_too_much_is_refused(tmp_path):
    data = npy(np.zeros((20, 20)))
    huge = data.replace(b"(20, 20), }" + b" " * 20, b"(99999999, 99999999), }" + b" " * 8)
    assert len(huge) == len(data) and huge != data
    with pytest.raises(HarmonicFaceError, match="expected a whole image"):
        read_image(stored(tmp_path, "a.npy", huge))


def test_nothing_is_unpickled(tmp_path):
    path = tmp_path / "a.npy"
    np.save(path, np.array([{"code": 1}], dtype=object), allow_pickle=True)
    with pytest.raises(HarmonicFaceError, match="Object arrays cannot be loaded"):
        read_image(path)


def test_a_missing_file_a_folder_and_an_unknown_transfer_are_refused(tmp_path):
    with pytest.raises(HarmonicFaceError, match="No such file"):
        read_image(tmp_path / "none.png")
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(HarmonicFaceError, match="Is a directory"):
        read_image(tmp_path / "folder.png")
    with pytest.raises(HarmonicFaceError, match="transfer: expected 'srgb' or 'linear', got 'gamma'"):
        read_image(tmp_path / "none.png", transfer="gamma")


@pytest.mark.parametrize("transfer", ["srgb", "linear"])
@pytest.mark.parametrize("shape", [(9, 7), (9, 7, 3)])
def test_png_round_trip_is_within_half_a_step(tmp_path, shape, transfer):
    array = np.linspace(0, 1, int(np.prod(shape))).reshape(shape)
    write_image(tmp_path / "a.png", array, transfer)
    back = read_image(tmp_path / "a.png", transfer)
    steepest = {"srgb": 2.4 / 1.055, "linear": 1.0}[transfer]  # slope of the decoding curve at 1
    assert np.abs(back - array).max() <= steepest / 255 / 2 + 1e-6


def test_values_outside_the_range_are_clipped_and_eight_bit_files_survive(tmp_path):
    write_image(tmp_path / "a.png", [[-1.0, 0.0, 1.0, 7.0]])
    assert read_image(tmp_path / "a.png").tolist() == [[0, 0, 1, 1]]
    levels = np.arange(256, dtype=np.uint8)[None]
    path = stored(tmp_path, "levels.png", pillow(levels, "PNG"))
    write_image(tmp_path / "again.png", read_image(path))
    np.testing.assert_array_equal(read_pixels(tmp_path / "again.png").values, levels)


def test_bad_writes_are_refused_and_leave_nothing(tmp_path):
    with pytest.raises(HarmonicFaceError, match=r"expected a name that ends in \.png"):
        write_image(tmp_path / "a.bmp", np.ones((2, 2)))
    with pytest.raises(HarmonicFaceError, match="transfer: expected"):
        write_image(tmp_path / "a.png", np.ones((2, 2)), "gamma")
    with pytest.raises(HarmonicFaceError, match="array: expected finite"):
        write_image(tmp_path / "a.png", [[np.nan]])
    with pytest.raises(HarmonicFaceError, match="array: expected an image"):
        write_image(tmp_path / "a.png", np.ones((2, 2, 4)))
    with pytest.raises(HarmonicFaceError, match="cannot write"):
        write_image(tmp_path / "nowhere" / "a.png", np.ones((2, 2)))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.data
def test_real_photographs_and_probes_are_read(data_dir):
    faces = read_image(next((data_dir / "yaleb" / "yaleB01").glob("*.pgm")))
    assert faces.shape == (192, 168)
    stereo = read_image(next((data_dir / "diligent" / "ballPNG").glob("0*.png")))
    assert stereo.shape == (512, 612, 3)
    probe = read_image(next((data_dir / "probes" / "latlong").glob("*.hdr")))
    assert probe.ndim == 3 and probe.max() > 1
