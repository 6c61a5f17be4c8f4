"""Pixels: the numbers that an image file stores, before anybody asks what light they mean."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageOps, UnidentifiedImageError

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.io._reasons import reason_of
from harmonicface.io.exr import exr_pixels
from harmonicface.io.radiance import radiance_exposure

ENDINGS = (".png", ".jpg", ".jpeg", ".pgm", ".ppm", ".pnm", ".tif", ".tiff", ".hdr", ".pfm", ".exr", ".npy")
PNG_END = b"IEND\xaeB`\x82"  # the name of the last chunk and its checksum
PILLOW_FORMATS = ("PNG", "JPEG", "PPM", "TIFF")
EIGHT_BIT_MODES = {"1": "1", "L": "L", "LA": "L", "P": "RGB", "PA": "RGB", "RGB": "RGB", "RGBA": "RGB", "RGBX": "RGB"}
STORED_TYPES = (np.bool_, np.uint8, np.uint16, np.float16, np.float32, np.float64)


@dataclass(frozen=True, eq=False)
class Pixels:
    """What a file stores.

    Parameters
    ----------
    values
        (h, w) or (h, w, 3), red first: booleans, 8- or 16-bit integers, or floats.
    transfer
        "srgb" or "linear": what such a file means if nobody says otherwise.
    """

    values: NDArray[Any]
    transfer: str


def read_pixels(path: str | os.PathLike[str]) -> Pixels:
    """Return the numbers stored in an image file, upright (EXIF orientation applied) and without alpha.

    Every byte of the picture is decoded, so a file that was cut short is refused; PNG checksums are verified.

    Parameters
    ----------
    path
        PNG, JPEG, PGM, PPM, TIFF, Radiance HDR, PFM, OpenEXR or NPY.

    Raises
    ------
    HarmonicFaceError
        No such file, another ending, a file that is cut short or corrupt, colours other than grey or RGB.
    """
    file = Path(path)
    if file.suffix.lower() not in ENDINGS:
        raise HarmonicFaceError(f"{file}: expected an image ({' '.join(ENDINGS)}), got the ending {file.suffix!r}")
    try:
        data = file.read_bytes()
    except (OSError, ValueError) as error:  # ValueError: a null character
        raise HarmonicFaceError(f"{file!s:.300}: expected an image, got {getattr(error, 'strerror', error)}") from None
    try:
        pixels = _decode(data, file.suffix.lower())
    except HarmonicFaceError as error:
        raise HarmonicFaceError(f"{file}: {error}") from None
    except Exception as error:  # decoders raise whatever they like on bad files: struct, zlib, even memory errors
        reason = f": {error}" if isinstance(error, OSError) else reason_of(error)
        raise HarmonicFaceError(f"{file}: expected a whole image, got one cut short or corrupt{reason}") from None
    return pixels


def pillow_pixels(picture: Image.Image) -> NDArray[Any]:
    """Return the numbers of a picture that Pillow opened, upright, without alpha, red first."""
    picture.load()
    upright = ImageOps.exif_transpose(picture)
    if upright.mode in EIGHT_BIT_MODES:
        mode = EIGHT_BIT_MODES[upright.mode]
        return np.asarray(upright if upright.mode == mode else upright.convert(mode))
    if upright.mode.startswith("I;16") or (upright.mode == "I" and picture.format in ("PPM", "PNG")):
        return np.asarray(upright).astype(np.uint16)
    if upright.mode == "F":
        return np.asarray(upright)
    raise HarmonicFaceError(f"expected grey or RGB pixels, got the Pillow mode {upright.mode!r}")


def _decode(data: bytes, ending: str) -> Pixels:
    if ending == ".npy":
        values, transfer = np.lib.format.read_array(io.BytesIO(data), allow_pickle=False), ""
    elif ending == ".hdr":
        exposure = radiance_exposure(data)
        values, transfer = _opencv(data), "linear"
        values = values if exposure == 1 else (values / exposure).astype(np.float32)
    elif ending == ".pfm":
        values, transfer = _opencv(data), "linear"
    elif ending == ".exr":
        values, transfer = exr_pixels(data), "linear"
    else:
        values, transfer = _picture(data)
    if values.dtype not in STORED_TYPES:
        raise HarmonicFaceError(f"expected 8- or 16-bit or float pixels, got {_validate.describe(values)}")
    if not (values.ndim == 2 or (values.ndim == 3 and values.shape[2] == 3)) or values.size == 0:
        raise HarmonicFaceError(f"expected an image of shape (h, w) or (h, w, 3), got {_validate.describe(values)}")
    return Pixels(values, transfer or "linear")


def _picture(data: bytes) -> tuple[NDArray[Any], str]:
    """Decode PNG, JPEG, PNM and TIFF: Pillow is the judge, OpenCV reads what Pillow would cut down to 8 bits."""
    tiff = data[:4] in (b"II*\0", b"MM\0*")
    deep = _opencv(data) if tiff else None  # first: of a TIFF that is cut short Pillow warns before it refuses
    try:
        picture = Image.open(io.BytesIO(data), formats=PILLOW_FORMATS)
    except UnidentifiedImageError:
        if deep is not None:  # Pillow knows no colour TIFF of floats
            return deep, "linear"
        raise HarmonicFaceError("expected a PNG, JPEG, PGM, PPM or TIFF picture, got another or broken file") from None
    with picture:
        if picture.format == "PNG":
            _verify_png(data)
        maximum = _deep_maximum(picture, data)
        values = pillow_pixels(picture)
        if maximum:
            values = _opencv(data) if deep is None else deep
        if maximum > 0 and maximum != 65535:
            values = (values / maximum).astype(np.float32)
    return values, "srgb" if values.dtype in (np.uint8, np.bool_) and picture.format != "PPM" else "linear"


def _verify_png(data: bytes) -> None:
    """Check the checksums of all chunks to the last one, which decoding alone does not."""
    if PNG_END not in data:
        raise HarmonicFaceError("expected a whole image, got a PNG without its end")
    with Image.open(io.BytesIO(data), formats=("PNG",)) as picture:
        picture.verify()


def _deep_maximum(picture: Image.Image, data: bytes) -> int:
    """Return the largest value of a colour picture of more than 8 bits, 0 for the others."""
    if picture.mode not in ("RGB", "RGBA"):
        return 0
    if picture.format == "PNG":
        return 65535 if data[24] == 16 else 0  # the bit depth of the IHDR chunk
    if picture.format == "TIFF":
        bits = picture.getexif().get(258, (8,))
        return 65535 if max(bits if isinstance(bits, tuple) else (bits,)) == 16 else 0
    if picture.format == "PPM":
        header = b" ".join(line.split(b"#")[0] for line in data[:1000].splitlines()).split()
        maximum = int(header[3])
        return maximum if maximum > 255 else 0
    return 0


def _opencv(data: bytes) -> NDArray[Any]:
    """Decode by OpenCV, which keeps 16 bits and floats, red first."""
    try:
        with _quiet_opencv():
            values = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_ANYDEPTH | cv2.IMREAD_ANYCOLOR)
    except cv2.error:  # it tells of its own source files
        values = None
    if values is None:
        raise HarmonicFaceError("expected a whole image, got one cut short or corrupt")
    return np.ascontiguousarray(values[..., ::-1]) if values.ndim == 3 else np.asarray(values)


@contextmanager
def _quiet_opencv() -> Iterator[None]:
    """Keep OpenCV from printing about bad files: the error says it."""
    level = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        yield
    finally:
        cv2.utils.logging.setLogLevel(level)
