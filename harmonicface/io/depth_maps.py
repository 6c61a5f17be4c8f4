"""Depth maps: pictures of distances or heights, in world units, with holes where nothing was measured."""

from __future__ import annotations

import os

import numpy as np

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.pixels import read_pixels

KINDS = ("distance", "height")


def read_depth_map(
    path: str | os.PathLike[str], kind: str, *, scale: float = 1.0, invalid: float | None = 0.0
) -> Floats:
    """Return the depth of a picture: larger is nearer the camera, NaN where there is no surface.

    Parameters
    ----------
    path
        PNG of 16 (or 8) bits, TIFF, OpenEXR, PFM or NPY with one channel of integers or floats. Nothing is decoded as
        sRGB: the stored numbers count.
    kind
        What they are: "distance" from the camera's plane along its axis (z, not the length of the ray), as depth
        cameras store it; or "height" above some plane toward the camera.
    scale
        World units a stored step: 0.001 for millimetres where metres are wanted. Above 0.
    invalid
        The stored number that says "nothing measured here", 0 by default; None if there is none. NaN says so too, and
        so does the infinite distance of what is too far away.

    Returns
    -------
    (h, w) floats: -scale * distance, which is z in the axes of a camera at the origin, or scale * height. 8- and 16-bit
    integers, half and single floats become float32; double stays float64.

    Raises
    ------
    HarmonicFaceError
        A file that cannot be read, colour, another kind, negative distances or infinite heights, no pixel with depth.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "depth.npy"
    >>> np.save(path, np.array([[1500, 0], [1400, 1300]], dtype=np.uint16))
    >>> read_depth_map(path, "distance", scale=0.001)
    array([[-1.5,  nan],
           [-1.4, -1.3]], dtype=float32)
    """
    if kind not in KINDS:
        raise HarmonicFaceError(f"kind: expected 'distance' or 'height', got {kind!r}")
    unit = _validate.positive(scale, "scale")
    stored = read_pixels(path).values
    if stored.ndim != 2 or stored.dtype == np.bool_:
        got = _validate.describe(stored)
        raise HarmonicFaceError(f"{path}: expected a depth map of one channel of numbers, got {got}")
    nothing = np.isnan(stored)
    if invalid is not None:
        nothing |= stored == invalid
    if kind == "distance":
        nothing |= np.isposinf(stored)
    measured = stored[~nothing]
    if measured.size == 0:
        raise HarmonicFaceError(f"{path}: expected some pixels with depth, got none of {stored.size}")
    if not np.isfinite(measured).all():
        raise HarmonicFaceError(f"{path}: expected finite {kind}s, got infinite ones")
    if kind == "distance" and measured.min() < 0:
        raise HarmonicFaceError(f"{path}: expected distances of at least 0, got {measured.min():.6g}")
    dtype = np.float64 if stored.dtype == np.float64 else np.float32
    with np.errstate(over="ignore", invalid="ignore"):  # beyond float32 is infinite and refused; some NaN signal
        depth: Floats = (stored.astype(np.float64) * (-unit if kind == "distance" else unit)).astype(dtype)
    depth[nothing] = np.nan
    if not np.isfinite(depth[~nothing]).all():
        name = np.dtype(dtype).name
        raise HarmonicFaceError(f"{path}: expected {kind}s that {name} holds, got infinite ones in this scale")
    return depth
