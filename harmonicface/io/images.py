"""Images: files to linear arrays and back."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.files import replacing
from harmonicface.io.pixels import read_pixels
from harmonicface.io.transfer import linear_to_srgb, srgb_to_linear

WRITTEN = {".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG"}
SRGB_OF_BYTE = srgb_to_linear(np.arange(256) / 255).astype(np.float32)


def read_image(path: str | os.PathLike[str], transfer: str | None = None) -> NDArray[np.float32]:
    """Return an image file as linear light.

    Parameters
    ----------
    path
        PNG (8 or 16 bit, palette), JPEG, PGM, PPM, TIFF (8 or 16 bit, float), Radiance HDR, OpenEXR, PFM (divided
        by the scale in its header) or NPY (8- or 16-bit integers or floats, never pickled). EXIF orientation is
        applied. An alpha channel is left out: the colours are those stored.
    transfer
        "srgb" or "linear": what the stored values mean. By default srgb for 8-bit PNG, JPEG and TIFF, and linear for
        PGM, PPM, NPY and whatever has 16 bits or floats.

    Returns
    -------
    (h, w) or (h, w, 3) float32, red first; integers are scaled to 0..1, floats stay as they are.

    Raises
    ------
    HarmonicFaceError
        No such file, an unknown format, a file cut short or corrupt, NaN or negative values, an unknown transfer.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "grey.png"
    >>> write_image(path, np.full((2, 3), 0.25))
    >>> read_image(path).round(2)
    array([[0.25, 0.25, 0.25],
           [0.25, 0.25, 0.25]], dtype=float32)
    """
    check_transfer(transfer)
    pixels = read_pixels(path)
    array = linear_pixels(pixels.values, transfer or pixels.transfer)
    if not np.isfinite(array).all():
        raise HarmonicFaceError(
            f"{path}: expected finite pixels, got {int((~np.isfinite(array)).sum())} NaN or infinite"
        )
    if array.min() < 0:
        raise HarmonicFaceError(f"{path}: expected pixels of at least 0, got {array.min():.4g}")
    return array


def write_image(path: str | os.PathLike[str], array: ArrayLike, transfer: str = "srgb") -> None:
    """Write linear light to an 8-bit PNG or JPEG; the file is replaced whole or not at all.

    Values outside 0..1 are clipped, as a camera clips them: scale the array first if nothing may be lost.

    Parameters
    ----------
    path
        A name that ends in .png, .jpg or .jpeg.
    array
        (h, w) or (h, w, 3) finite linear values.
    transfer
        "srgb" encodes the values as screens expect; "linear" stores them as they are.

    Raises
    ------
    HarmonicFaceError
        Another ending, another shape, NaN, an unknown transfer, or a file that cannot be written.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> write_image(pathlib.Path(tempfile.mkdtemp()) / "white.jpg", np.ones((8, 8, 3)))
    """
    ending = Path(path).suffix.lower()
    if ending not in WRITTEN:
        raise HarmonicFaceError(f"{path}: expected a name that ends in {', '.join(WRITTEN)}, got {ending!r}")
    if transfer not in ("srgb", "linear"):
        raise HarmonicFaceError(f"transfer: expected 'srgb' or 'linear', got {transfer!r}")
    values = np.clip(_validate.image(array, "array"), 0, 1)
    stored = linear_to_srgb(values) if transfer == "srgb" else values
    picture = Image.fromarray(np.rint(stored * 255).astype(np.uint8))
    options: dict[str, Any] = {"quality": 95, "subsampling": 0} if WRITTEN[ending] == "JPEG" else {}
    with replacing(path) as temporary:
        picture.save(temporary, WRITTEN[ending], **options)


def check_transfer(transfer: str | None) -> None:
    """Refuse anything but "srgb", "linear" and None, which leaves it to the type of the file."""
    if transfer not in (None, "srgb", "linear"):
        raise HarmonicFaceError(f"transfer: expected 'srgb' or 'linear', got {transfer!r}")


def linear_pixels(values: NDArray[Any], transfer: str) -> NDArray[np.float32]:
    """Return stored pixels as linear float32: integers scaled to 0..1, sRGB decoded."""
    if values.dtype == np.uint8 and transfer == "srgb":
        return np.asarray(SRGB_OF_BYTE[values])
    scale = np.iinfo(values.dtype).max if values.dtype.kind == "u" else 1
    with np.errstate(over="ignore", invalid="ignore"):  # what is beyond float32 becomes infinite: the caller refuses it
        linear = (values / scale).astype(np.float32) if scale != 1 else values.astype(np.float32)
        return srgb_to_linear(linear).astype(np.float32) if transfer == "srgb" else linear
