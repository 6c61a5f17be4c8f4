"""OpenEXR: floats of high dynamic range, as film and graphics keep them."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout, suppress
from typing import Any

import numpy as np
import OpenEXR
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError

COLOURS = ("R", "G", "B")


def exr_pixels(data: bytes) -> NDArray[Any]:
    """Decode the first part of an OpenEXR file.

    Parameters
    ----------
    data
        The file's bytes: scan lines or tiles, any compression, half or float.

    Returns
    -------
    array
        (h, w, 3) of the channels R, G, B, or (h, w) of the channel Y or of the only one; float16 or float32 as
        stored. Alpha and further channels are left out.

    Raises
    ------
    HarmonicFaceError
        A file that is cut short or corrupt, channels that are no picture, subsampled or of integers.
    """
    with _silence():
        try:
            part = OpenEXR.File(io.BytesIO(data), separate_channels=True, num_threads=0)
            channels = {name: channel.pixels for name, channel in part.channels().items()}
        except Exception as error:  # the library raises whatever it likes on bad files, and nothing on some
            reason = " ".join(str(error).split()) or type(error).__name__
            raise HarmonicFaceError(f"expected a whole image, got an OpenEXR cut short or corrupt: {reason}") from None
    names = _picture_channels(list(channels))
    planes = [channels[name] for name in names]
    if any(plane.ndim != 2 or plane.shape != planes[0].shape or plane.dtype.kind != "f" for plane in planes):
        kinds = ", ".join(f"{name} {channels[name].shape} {channels[name].dtype}" for name in names)
        raise HarmonicFaceError(f"expected channels of floats of one size, got {kinds}")
    return np.stack(planes, axis=-1) if len(planes) == 3 else np.asarray(planes[0])


def _picture_channels(names: list[str]) -> tuple[str, ...]:
    """Choose the channels that are the picture."""
    if all(colour in names for colour in COLOURS):
        return COLOURS
    if "Y" in names and not {"RY", "BY"} & set(names):
        return ("Y",)
    if len(names) == 1:
        return (names[0],)
    raise HarmonicFaceError(f"expected the OpenEXR channels R G B or Y, got {' '.join(sorted(names)) or 'none'}")


@contextmanager
def _silence() -> Iterator[None]:
    """Keep the library from printing about bad files, below Python and through it: the error says it."""
    kept = []
    for stream in (1, 2):
        with suppress(OSError):  # a stream that is closed is silent already
            kept.append((stream, os.dup(stream)))
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        for stream, _ in kept:
            os.dup2(nowhere, stream)
        with redirect_stdout(io.StringIO()):  # some of it goes through Python
            yield
    finally:
        os.close(nowhere)
        for stream, copy in kept:
            os.dup2(copy, stream)
            os.close(copy)
