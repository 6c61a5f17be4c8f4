"""Point clouds: PLY files without faces, and tables of positions, normals and colours."""

from __future__ import annotations

import io
import os
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from trimesh.exchange.ply import load_ply

from harmonicface import _validate
from harmonicface._memory import require
from harmonicface.errors import HarmonicFaceError
from harmonicface.io._mesh_bytes import ply_complaint, ply_counts
from harmonicface.io._reasons import reason_of
from harmonicface.io.images import linear_pixels

ENDINGS = (".ply", ".xyz", ".npy")
BYTES_A_POINT = 200  # that reading a PLY takes beside the file, measured at 3 million
TABLE_COPIES = 5  # of a table's file that reading takes: 3.9 measured
COLUMNS = ("x", "y", "z", "nx", "ny", "nz")
COLOURS = ("red", "green", "blue")

Doubles = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PointCloud:
    """Points of a surface, in the order of the file.

    Parameters
    ----------
    points
        (n, 3) float64 positions in the file's units: x right, y up, z toward the viewer.
    normals
        (n, 3) float64 unit normals.
    albedo
        (n, 3) float64 linear reflectances; None where the file has no colours.
    """

    points: Doubles
    normals: Doubles
    albedo: Doubles | None


def read_point_cloud(path: str | os.PathLike[str]) -> PointCloud:
    r"""Read points with normals.

    Parameters
    ----------
    path
        A PLY file without faces and with nx, ny, nz, and red, green, blue if it has colours (integers of 8 or 16 bits,
        or floats of 0 to 1); or a table with the columns x y z nx ny nz, or x y z nx ny nz r g b with r, g, b whole
        numbers of 0 to 255: as text (.xyz, between blanks or commas, # begins a comment) or as .npy. Colours are sRGB.

    Returns
    -------
    PointCloud
        Its normals scaled to unit length.

    Raises
    ------
    HarmonicFaceError
        No such file, another ending, a file cut short, corrupt or beyond the memory, no points, a PLY with faces, no
        normals, NaN, normals of zero length, colours out of range.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "two.xyz"
    >>> _ = path.write_text("0 0 0  0 0 2  255 255 255\n1 0 0  0 0 1  0 0 0\n")
    >>> cloud = read_point_cloud(path)
    >>> cloud.normals[0], cloud.albedo[0]
    (array([0., 0., 1.]), array([1., 1., 1.]))
    """
    file = Path(path)
    ending = file.suffix.lower()
    if ending not in ENDINGS:
        raise HarmonicFaceError(f"{file}: expected a point cloud ({' '.join(ENDINGS)}), got {file.suffix!r}")
    try:
        require(file.stat().st_size, f"{file}: a file of {file.stat().st_size} bytes")
        data = file.read_bytes()
    except (OSError, ValueError) as error:  # ValueError: a null character
        got = getattr(error, "strerror", error)
        raise HarmonicFaceError(f"{file!s:.300}: expected a point cloud, got {got}") from None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # an empty table is a warning
            if ending != ".ply":
                require(TABLE_COPIES * len(data), f"{file}: a table of {len(data)} bytes")
            return _cloud(*(_from_ply(data, file) if ending == ".ply" else _from_table(data, ending)))
    except HarmonicFaceError as error:
        message = str(error)
        raise HarmonicFaceError(message if message.startswith(str(file)) else f"{file}: {message}") from None
    except Exception as error:  # the parsers raise whatever they stumble over
        raise HarmonicFaceError(
            f"{file}: expected a point cloud, got one cut short or corrupt{reason_of(error)}"
        ) from None


def is_point_cloud(path: str | os.PathLike[str]) -> bool:
    r"""Tell whether a file is one of points: a table, or a PLY whose header announces vertices and no faces.

    Examples
    --------
    >>> is_point_cloud("scan.xyz"), is_point_cloud("scan.obj")
    (True, False)
    """
    file = Path(path)
    if file.suffix.lower() != ".ply":
        return file.suffix.lower() in ENDINGS
    try:
        with file.open("rb") as stream:
            faces, vertices = ply_counts(stream.read(1 << 16))
    except (OSError, ValueError):
        return False
    return vertices > 0 and faces == 0


def _from_ply(data: bytes, file: Path) -> tuple[Doubles, Doubles | None]:
    """Return the columns of a PLY file and its colours, 0 to 1 as stored."""
    problem = ply_complaint(data)
    if problem:
        raise HarmonicFaceError(problem)
    faces, vertices = ply_counts(data)
    if faces:
        raise HarmonicFaceError(f"expected points without faces, got {faces} faces (read_mesh reads those)")
    if not vertices:
        raise HarmonicFaceError("expected at least one point, got none")
    require(len(data) + BYTES_A_POINT * vertices, f"{file}: {vertices} points")
    element = load_ply(io.BytesIO(data), skip_materials=True)["metadata"]["_ply_raw"]["vertex"]
    names, columns = set(element["properties"]), element["data"]
    missing = [name for name in COLUMNS if name not in names]
    if missing:
        raise HarmonicFaceError(f"expected points with normals (nx ny nz), got a PLY without {' '.join(missing)}")
    values = np.stack([np.asarray(columns[name], dtype=np.float64).reshape(-1) for name in COLUMNS], axis=1)
    if not names.issuperset(COLOURS):
        return values, None
    stored = np.stack([np.asarray(columns[name]).reshape(-1) for name in COLOURS], axis=1)
    kinds = [str(element["properties"][name]).lstrip("<>|=") for name in COLOURS]
    largest = {"u1": 255.0, "u2": 65535.0}.get(kinds[0], 1.0)
    return values, stored.astype(np.float64) / largest


def _from_table(data: bytes, ending: str) -> tuple[Doubles, Doubles | None]:
    """Return the six columns of a table, and the colours behind them, 0 to 1."""
    if not data.strip():
        raise HarmonicFaceError("expected a table of points, got an empty file")
    if ending == ".npy":
        table = np.lib.format.read_array(io.BytesIO(data), allow_pickle=False)
    else:
        table = np.loadtxt(io.BytesIO(data.replace(b",", b" ")), ndmin=2)
    if table.ndim != 2 or table.shape[1] not in (6, 9) or not len(table):
        raise HarmonicFaceError(
            f"expected rows of x y z nx ny nz or x y z nx ny nz r g b, got {_validate.describe(table)}"
        )
    values = _validate.floats(table, "points").astype(np.float64)
    if values.shape[1] == 6:
        return values, None
    colours = values[:, 6:]
    if not ((colours == np.rint(colours)) & (colours >= 0) & (colours <= 255)).all():
        raise HarmonicFaceError("expected colours of whole numbers from 0 to 255 in the last three columns, got others")
    return values[:, :6], colours / 255


def _cloud(values: Doubles, colours: Doubles | None) -> PointCloud:
    """Return checked points with unit normals and linear albedo."""
    finite = _validate.finite(values, "points")
    albedo: Any = None
    if colours is not None:
        if not ((colours >= 0) & (colours <= 1)).all():
            raise HarmonicFaceError("expected colours from 0 to the largest that their type stores, got others")
        albedo = linear_pixels(colours[:, None, :], "srgb")[:, 0].astype(np.float64)
    normals = np.asarray(_validate.directions(finite[:, 3:], "normals"), dtype=np.float64)
    return PointCloud(np.ascontiguousarray(finite[:, :3], dtype=np.float64), normals, albedo)
