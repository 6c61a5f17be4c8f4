"""Normal maps: unit vectors stored as the red, green and blue of a picture."""

from __future__ import annotations

import os
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.files import replacing
from harmonicface.io.images import linear_pixels
from harmonicface.io.pixels import read_pixels

SHORTEST, LONGEST = 0.5, 1.2  # of a stored normal: filtering shortens it, rounding changes it by a percent


GREENS = ("up", "down")


def read_normal_map(path: str | os.PathLike[str], green: str = "up") -> NDArray[np.float32]:
    """Return the normals of a picture, n = 2 rgb - 1 scaled to unit length.

    Parameters
    ----------
    path
        An RGB image with 8 or 16 bits or floats of 0 to 1, read linearly: red is x to the right, green y, blue z
        toward the camera. Black and middle grey mean that there is no surface. An .npy file holds (h, w, 3) vectors
        themselves, with zero vectors where there is no surface.
    green
        Which way green (y) points in the file: "up" as OpenGL has it, the default, or "down" as DirectX does. The
        normals that are returned have y up in either case.

    Returns
    -------
    (h, w, 3) float32 unit vectors, the zero vector where there is no surface.

    Raises
    ------
    HarmonicFaceError
        A file that cannot be read, a grey image, colours that are no normals (their vector's length is not between
        0.5 and 1.2), or another word for green.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "normals.png"
    >>> write_normal_map(path, np.array([[[0.0, 0.6, 0.8], [0.0, 0.0, 0.0]]]))
    >>> read_normal_map(path).round(4) + 0.0
    array([[[0. , 0.6, 0.8], [0. , 0. , 0. ]]], dtype=float32)
    """
    upward = green_sign(green)
    values = read_pixels(path).values
    if values.ndim != 3:
        raise HarmonicFaceError(f"{path}: expected an RGB normal map, got {_validate.describe(values)}")
    stored = linear_pixels(values, "linear").astype(np.float64)
    if not np.isfinite(stored).all():
        raise HarmonicFaceError(f"{path}: expected finite normals, got NaN or infinite ones")
    if Path(path).suffix.lower() == ".npy":
        vectors = stored
        nothing = ~stored.any(axis=2)
    else:
        vectors = 2 * stored - 1
        nothing = ~stored.any(axis=2) | (np.abs(vectors).max(axis=2) < 0.01)
    vectors[nothing] = 0
    vectors[..., 1] *= upward
    length = np.linalg.norm(vectors, axis=2)
    odd = ~nothing & ((length < SHORTEST) | (length > LONGEST))
    if odd.any():
        raise HarmonicFaceError(
            f"{path}: expected normals of about unit length, got {int(odd.sum())} others (length {length[odd][0]:.3g})"
        )
    length[nothing] = 1
    return np.asarray(vectors / length[..., None], dtype=np.float32) + np.float32(0.0)  # no negative zeros


def green_sign(green: str) -> float:
    """Return what the second component of stored normals has to be multiplied by: 1.0 for "up", -1.0 for "down".

    Raises
    ------
    HarmonicFaceError
        Another word.

    Examples
    --------
    >>> green_sign("down")
    -1.0
    """
    if green not in GREENS:
        raise HarmonicFaceError(f"green: expected 'up' (OpenGL) or 'down' (DirectX), got {green!r}")
    return 1.0 if green == "up" else -1.0


def write_normal_map(path: str | os.PathLike[str], normals: ArrayLike) -> None:
    """Write normals to a 16-bit PNG, rgb = (n + 1) / 2; the file is replaced whole or not at all.

    Parameters
    ----------
    path
        A name that ends in .png.
    normals
        (h, w, 3) unit vectors; zero vectors, where there is no surface, become black.

    Raises
    ------
    HarmonicFaceError
        Another ending, another shape, vectors that are not of unit length, or a file that cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> write_normal_map(Path(tempfile.mkdtemp()) / "wall.png", np.tile([0.0, 0.0, 1.0], (4, 5, 1)))
    """
    if Path(path).suffix.lower() != ".png":
        raise HarmonicFaceError(f"{path}: expected a name that ends in .png, got {Path(path).suffix!r}")
    vectors = _validate.image(normals, "normals")
    if vectors.ndim != 3:
        raise HarmonicFaceError(f"normals: expected shape (h, w, 3), got {_validate.describe(vectors)}")
    inside = vectors.any(axis=2)
    _validate.unit_normals(vectors[inside], "normals")
    stored = np.rint((vectors.clip(-1, 1) + 1) / 2 * 65535).astype(np.uint16)
    stored[~inside] = 0
    encoded = cv2.imencode(".png", stored[..., ::-1])[1]
    with replacing(path) as temporary:
        temporary.write_bytes(encoded.tobytes())
