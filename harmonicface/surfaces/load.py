"""Load: a Surface from a file, be it a mesh, points, a saved Surface, or pictures of normals and albedo."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.images import read_image
from harmonicface.io.meshes import ENDINGS, read_mesh
from harmonicface.io.normal_maps import green_sign, read_normal_map
from harmonicface.io.point_clouds import is_point_cloud, read_point_cloud
from harmonicface.surfaces.mesh import surface_from_mesh
from harmonicface.surfaces.points import surface_from_points
from harmonicface.surfaces.surface import Surface


def load_surface(
    path: str | os.PathLike[str],
    size: int | tuple[int, int] | None = None,
    *,
    texture: str | os.PathLike[str] | None = None,
    flip_texture: bool = False,
    rotation: Sequence[float] | None = None,
    frame: Sequence[float] | None = None,
    intrinsics: Sequence[float] | None = None,
    distance: float | None = None,
    supersample: int | None = None,
) -> Surface:
    r"""Load a Surface from a mesh or points, as a camera sees them, or from an .npz file that `Surface.save` wrote.

    Parameters
    ----------
    path
        A GLB, OBJ, PLY or STL mesh, see `read_mesh`; points with normals (a PLY without faces, .xyz or .npy), see
        `read_point_cloud`; or a saved Surface (.npz).
    size
        Height and width in pixels; one number means a square. A mesh is seen at 64 x 64 if nothing is said.
    texture
        An image to use as the mesh's albedo in place of its own.
    flip_texture
        Turn the texture upside down first.
    rotation
        (yaw, pitch, roll) in degrees; (0, 0, 0) by default.
    frame
        (x0, y0, x1, y1) in world units after the rotation: what the picture shows; by default all of the mesh. Not
        together with intrinsics.
    intrinsics
        (fx, fy, cx, cy) in pixels of this size: a pinhole camera, see `PerspectiveView`, in place of an orthographic
        one. Of meshes only.
    distance
        World units from the pinhole to the middle of the mesh; by default the least that shows all of it.
    supersample
        Divisions of each pixel along each side, see `surface_from_mesh`. Of meshes only.

    Returns
    -------
    Surface
        Of a mesh or of points: float32, with depth and pixel size in their units. A saved Surface comes back bit for
        bit.

    Raises
    ------
    HarmonicFaceError
        A file that is missing, of another kind or corrupt; a frame or intrinsics that show nothing; arguments of a
        view together with a saved Surface, whose pixels are fixed; those of a mesh together with points.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "triangle.obj"
    >>> _ = path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    >>> load_surface(path, size=8).shape
    (8, 8)
    """
    file = Path(path)
    ending = file.suffix.lower()
    of_meshes: dict[str, object] = {
        "texture": texture,
        "flip_texture": flip_texture or None,
        "intrinsics": intrinsics,
        "distance": distance,
        "supersample": supersample,
    }
    if ending == ".npz":
        given = _given({"size": size, "rotation": rotation, "frame": frame, **of_meshes})
        saved = Surface.load(file)  # a file that is none is the graver fault
        if given:
            raise HarmonicFaceError(f"{file}: expected no view of a saved Surface, got {given}")
        return saved
    if is_point_cloud(file):
        if given := _given(of_meshes):
            raise HarmonicFaceError(f"{file}: expected size, rotation and frame of points at most, got {given}")
        return _of_points(file, size, rotation, frame)
    if ending not in ENDINGS:
        raise HarmonicFaceError(
            f"{file}: expected a mesh ({' '.join(ENDINGS)}), points with normals (.ply .xyz .npy) or a saved Surface"
            f" (.npz), got the ending {file.suffix!r}"
        )
    mesh = read_mesh(file, texture=texture, flip_texture=flip_texture)
    try:
        return surface_from_mesh(
            mesh,
            64 if size is None else size,
            rotation=(0.0, 0.0, 0.0) if rotation is None else rotation,
            frame=frame,
            intrinsics=intrinsics,
            distance=distance,
            supersample=supersample,
        )
    except HarmonicFaceError as error:
        raise HarmonicFaceError(f"{file}: {error}") from None


def _given(arguments: dict[str, object]) -> str:
    """Name the arguments that are given."""
    return ", ".join(name for name, value in arguments.items() if value is not None)


def _of_points(
    file: Path, size: int | tuple[int, int] | None, rotation: Sequence[float] | None, frame: Sequence[float] | None
) -> Surface:
    """Return the Surface of a point cloud's file."""
    cloud = read_point_cloud(file)
    try:
        return surface_from_points(
            cloud.points,
            cloud.normals,
            cloud.albedo,
            64 if size is None else size,
            rotation=(0.0, 0.0, 0.0) if rotation is None else rotation,
            frame=frame,
        )
    except HarmonicFaceError as error:
        raise HarmonicFaceError(f"{file}: {error}") from None


def surface_from_normals(
    normals: str | os.PathLike[str] | ArrayLike,
    albedo: str | os.PathLike[str] | ArrayLike = 0.5,
    *,
    mask: NDArray[np.bool_] | None = None,
    pixel_size: float = 1.0,
    green: str = "up",
) -> Surface:
    """Return the Surface of a picture of normals and a picture of albedo.

    Parameters
    ----------
    normals
        The path of a normal map, see `read_normal_map`, or (h, w, 3) unit vectors with zero vectors outside.
    albedo
        The path of an image, see `read_image`; or (h, w) or (h, w, 3) linear reflectances; or one number for all.
    mask
        (h, w) booleans; by default every pixel with a normal.
    pixel_size
        World units a pixel.
    green
        Which way y (the green of a picture) points in what is given: "up" (OpenGL) or "down" (DirectX). In the
        Surface it points up.

    Raises
    ------
    HarmonicFaceError
        A file that cannot be read, arrays that make no Surface, or another word for green.

    Examples
    --------
    >>> surface_from_normals(np.tile([0.0, 0.0, 1.0], (4, 5, 1)), albedo=0.7).shape
    (4, 5)
    """
    upward = green_sign(green)
    if isinstance(normals, (str, os.PathLike)):
        vectors: Floats = read_normal_map(normals, green)
    else:
        vectors = _validate.floats(normals, "normals")
        if upward < 0 and vectors.ndim == 3 and vectors.shape[2] == 3:
            vectors = vectors * np.array([1, -1, 1], dtype=vectors.dtype) + 0
    values = read_image(albedo) if isinstance(albedo, (str, os.PathLike)) else np.asarray(albedo)
    if values.ndim == 0:
        values = np.full(vectors.shape[:2], values)
    return Surface(vectors, values, mask, pixel_size=pixel_size)
