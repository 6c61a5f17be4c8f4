"""From a mesh to a Surface: what a camera sees of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from harmonicface import _memory, _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.meshes import Mesh
from harmonicface.surfaces.perspective import Camera, PerspectiveView
from harmonicface.surfaces.samples import sample
from harmonicface.surfaces.scene import Scene
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.view import MOST_PIXELS, View

SUPERSAMPLE = 4
FINEST_DEPTH = 1e-3  # of a pixel: steps in depth that must not get lost
BYTES_A_SAMPLE = 200  # of a finer pixel while the mesh is sampled, 197 measured
FINEST = 1024  # pixels a side of the raster beyond which pixels are not divided any further


def surface_from_mesh(
    mesh: Mesh,
    size: int | tuple[int, int] = 64,
    *,
    rotation: Sequence[float] = (0.0, 0.0, 0.0),
    frame: Sequence[float] | None = None,
    intrinsics: Sequence[float] | None = None,
    distance: float | None = None,
    supersample: int | None = None,
) -> Surface:
    """Return what a camera sees of a mesh: an orthographic one, or with `intrinsics` a pinhole.

    Each pixel is divided into `supersample` x `supersample`; it is inside the mask if at least half of them see the
    mesh, and its albedo, depth and normal (scaled to unit length) are their means. A texture is averaged to the density
    of these finer pixels first. Triangles are seen from both sides, whichever way they wind, and a normal always faces
    the camera: seen from behind it is turned round; where smooth shading bends it out of sight on a triangle that is
    seen, it is laid down sideways; where a mesh has none, the triangle's own takes its place (see `sample`).

    Parameters
    ----------
    mesh
        A mesh with at least one face.
    size
        Height and width in pixels; one number means a square.
    rotation
        (yaw, pitch, roll) in degrees, see `rotation_matrix`.
    frame
        (x0, y0, x1, y1): what the picture shows, in world units after the rotation; by default all of the mesh. Not
        together with intrinsics.
    intrinsics
        (fx, fy, cx, cy) of a pinhole camera in pixels of this size, see `PerspectiveView`.
    distance
        World units from the pinhole to the middle of the mesh's bounding box after the rotation; by default the least
        at which the whole mesh is in the picture. Only together with intrinsics.
    supersample
        Divisions of a pixel along each side; by default 4, or fewer where the finer raster would exceed 1024 pixels.
        A finer raster of more than 16,384 pixels a side, or beyond the memory, is refused.

    Returns
    -------
    Surface of float32 arrays, with depth in world units and the mesh as its `scene`. Its albedo is (h, w), or
    (h, w, 3) if the mesh has colour. Far from the origin, where float32 could not tell a thousandth of a pixel apart,
    depth is float64. Before a pinhole, normals and depth are in the camera's axes (depth is z, below 0, not the length
    of the ray), and the pixel size is that at the mean depth.

    Raises
    ------
    HarmonicFaceError
        View arguments of another form, a frame together with intrinsics, or a view in which nothing is seen.

    Examples
    --------
    >>> from harmonicface.io.meshes import Mesh
    >>> square = Mesh(
    ...     vertices=np.array([[0.0, 0, 2], [1, 0, 2], [1, 1, 2], [0, 1, 2]]), faces=np.array([[0, 1, 2], [0, 2, 3]]),
    ...     normals=np.tile([0.0, 0.0, 1.0], (4, 1)), uv=None, textures=(), face_texture=np.array([-1, -1]),
    ...     vertex_albedo=np.full((4, 3), 0.5))
    >>> seen = surface_from_mesh(square, size=2)
    >>> seen.albedo, seen.depth, seen.pixel_size
    (array([[0.5, 0.5], [0.5, 0.5]], dtype=float32), array([[2., 2.], [2., 2.]], dtype=float32), 0.5)
    """
    view = _view(mesh, size, rotation, frame, intrinsics, distance)
    divisions = _divisions(supersample, view.shape)
    height, width = (side * divisions for side in view.shape)
    _memory.require(BYTES_A_SAMPLE * height * width, f"a raster of {height} x {width} pixels (size times supersample)")
    samples = sample(mesh, view.finer(divisions))
    seen = samples.mask
    counts = _block_sums(seen.astype(np.float64), divisions)
    inside = 2 * counts >= divisions**2
    normals = _block_sums(samples.normals, divisions)
    length = np.linalg.norm(normals, axis=2)
    inside &= length > 1e-6 * counts  # opposite sideways normals within one pixel leave no direction
    if not inside.any():
        raise HarmonicFaceError(_nothing_seen(view))
    albedo = _block_sums(samples.albedo, divisions)
    depth = _block_sums(np.where(seen, samples.raster.depth, 0.0), divisions)
    normals[inside] /= length[inside, None]
    albedo[inside] /= counts[inside].reshape(-1, *[1] * (albedo.ndim - 2))
    depth[inside] /= counts[inside]
    pixel_size = float(view.pixel_size_at(depth[inside].mean()))
    step = np.spacing(np.abs(depth[inside]).max().astype(np.float32))
    return Surface(
        normals.astype(np.float32),
        albedo.astype(np.float32),
        inside,
        depth if step > FINEST_DEPTH * pixel_size else depth.astype(np.float32),
        pixel_size,
        scene=Scene(mesh, view),
    )


def _view(
    mesh: Mesh,
    size: int | tuple[int, int],
    rotation: Sequence[float],
    frame: Sequence[float] | None,
    intrinsics: Sequence[float] | None,
    distance: float | None,
) -> Camera:
    """Return the camera that the arguments describe."""
    used = np.zeros(len(mesh.vertices), dtype=bool)
    used[mesh.faces] = True
    points = mesh.vertices[used]
    if intrinsics is None:
        if distance is not None:
            raise HarmonicFaceError(f"distance: expected intrinsics beside it, got {distance!r} without any")
        return View.fit(points, size, rotation=rotation, frame=frame)
    if frame is not None:
        raise HarmonicFaceError(f"frame: expected none beside intrinsics, got {tuple(frame)!r}")
    return PerspectiveView.fit(points, size, rotation=rotation, intrinsics=intrinsics, distance=distance)


def _nothing_seen(view: Camera) -> str:
    if isinstance(view, View):
        return f"frame: expected a part of the mesh in view, got {view.frame} which shows nothing"
    return (
        f"intrinsics: expected a part of the mesh in view, got {view.intrinsics} from a distance of"
        f" {view.distance:.6g}, which shows nothing"
    )


def _divisions(supersample: int | None, shape: tuple[int, int]) -> int:
    if supersample is None:
        return int(np.clip(FINEST // max(shape), 1, SUPERSAMPLE))
    if isinstance(supersample, bool) or not isinstance(supersample, (int, np.integer)) or supersample < 1:
        raise HarmonicFaceError(
            f"supersample: expected an integer of at least 1, got {_validate.describe(supersample)}"
        )
    if max(shape) * int(supersample) > MOST_PIXELS:
        raise HarmonicFaceError(
            f"supersample: expected at most {MOST_PIXELS} finer pixels a side, got {max(shape)} times {supersample:.6g}"
        )
    return int(supersample)


def _block_sums(array: Floats, divisions: int) -> Floats:
    """Return the sums over blocks of pixels, (h, w, ...)."""
    height, width = array.shape[0] // divisions, array.shape[1] // divisions
    blocks = array.reshape(height, divisions, width, divisions, *array.shape[2:])
    return np.asarray(blocks.sum(axis=(1, 3)))
