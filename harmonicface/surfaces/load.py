"""Load: a Surface from a file, be it a mesh, a saved Surface, or pictures of normals and albedo."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.io.images import read_image
from harmonicface.io.meshes import ENDINGS, read_mesh
from harmonicface.io.normal_maps import read_normal_map
from harmonicface.surfaces.mesh import surface_from_mesh
from harmonicface.surfaces.surface import Surface


def load_surface(
    path: str | os.PathLike[str],
    size: int | tuple[int, int] | None = None,
    *,
    texture: str | os.PathLike[str] | None = None,
    flip_texture: bool = False,
    rotation: Sequence[float] | None = None,
    frame: Sequence[float] | None = None,
    supersample: int | None = None,
) -> Surface:
    r"""Load a Surface from a mesh, as an orthographic camera sees it, or from an .npz file that `Surface.save` wrote.

    Parameters
    ----------
    path
        A GLB, OBJ, PLY or STL mesh, see `read_mesh`, or a saved Surface (.npz).
    size
        Height and width in pixels; one number means a square. A mesh is seen at 64 x 64 if nothing is said.
    texture
        An image to use as the mesh's albedo in place of its own.
    flip_texture
        Turn the texture upside down first.
    rotation
        (yaw, pitch, roll) in degrees; (0, 0, 0) by default.
    frame
        (x0, y0, x1, y1) in world units after the rotation: what the picture shows; by default all of the mesh.
    supersample
        Divisions of each pixel along each side, see `surface_from_mesh`.

    Returns
    -------
    Surface
        Of a mesh: float32, with depth and pixel size in the mesh's units. A saved Surface comes back bit for bit.

    Raises
    ------
    HarmonicFaceError
        A file that is missing, of another kind or corrupt; a frame that shows nothing; arguments of a view together
        with a saved Surface, whose pixels are fixed.

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
    if ending == ".npz":
        view = {"size": size, "texture": texture, "rotation": rotation, "frame": frame, "supersample": supersample}
        given = [name for name, value in view.items() if value is not None] + ["flip_texture"] * bool(flip_texture)
        if given:
            raise HarmonicFaceError(f"{file}: expected no view of a saved Surface, got {', '.join(given)}")
        return Surface.load(file)
    if ending not in ENDINGS:
        raise HarmonicFaceError(
            f"{file}: expected a mesh ({' '.join(ENDINGS)}) or a saved Surface (.npz), got the ending {file.suffix!r}"
        )
    mesh = read_mesh(file, texture=texture, flip_texture=flip_texture)
    try:
        return surface_from_mesh(
            mesh,
            64 if size is None else size,
            rotation=(0.0, 0.0, 0.0) if rotation is None else rotation,
            frame=frame,
            supersample=supersample,
        )
    except HarmonicFaceError as error:
        raise HarmonicFaceError(f"{file}: {error}") from None


def surface_from_normals(
    normals: str | os.PathLike[str] | ArrayLike,
    albedo: str | os.PathLike[str] | ArrayLike = 0.5,
    *,
    mask: NDArray[np.bool_] | None = None,
    pixel_size: float = 1.0,
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

    Raises
    ------
    HarmonicFaceError
        A file that cannot be read, or arrays that make no Surface.

    Examples
    --------
    >>> surface_from_normals(np.tile([0.0, 0.0, 1.0], (4, 5, 1)), albedo=0.7).shape
    (4, 5)
    """
    vectors = read_normal_map(normals) if isinstance(normals, (str, os.PathLike)) else np.asarray(normals)
    values = read_image(albedo) if isinstance(albedo, (str, os.PathLike)) else np.asarray(albedo)
    if values.ndim == 0:
        values = np.full(vectors.shape[:2], values)
    return Surface(vectors, values, mask, pixel_size=pixel_size)
