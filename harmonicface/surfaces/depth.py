"""From a depth map to a Surface: normals by finite differences."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.meshes import Mesh
from harmonicface.surfaces.depth_mesh import STEEPEST, grid_faces
from harmonicface.surfaces.perspective import Intrinsics, PerspectiveView, checked_intrinsics, rays
from harmonicface.surfaces.scene import Scene
from harmonicface.surfaces.surface import Surface

Mask = NDArray[np.bool_]


def surface_from_depth(
    depth: ArrayLike,
    albedo: ArrayLike = 0.5,
    pixel_size: float | None = None,
    mask: NDArray[np.bool_] | None = None,
    *,
    intrinsics: Sequence[float] | None = None,
    steepest: float | None = None,
) -> Surface:
    """Return the Surface of a depth map: of parallel rays, or with `intrinsics` of a pinhole camera.

    n is (-dz/dx, -dz/dy, 1) scaled to unit length. The slopes are central differences inside and one-sided ones at the
    border of the mask; nothing is taken from pixels outside. A pixel that has no neighbour in the mask beside it, or
    none above or below it, has no normal and is left outside.

    Where depth steps from one thing to another before or behind it, a difference across the step is no slope:
    neighbours between which the surface would rise at more than `steepest` are none to each other, so the slopes on
    both sides are one-sided and nothing is smeared over the edge.

    Of a pinhole camera the pixels are laid out in space, p = z (x', y', 1) with x' = (cx - column) / fx and
    y' = (row - cy) / fy at the pixel's centre, and n is at a right angle to the differences of p along rows and along
    columns.
    Such a Surface has a `scene`: the triangles between its pixels, not over steps, seen by a `PerspectiveView` in the
    origin, so that shadows follow the true shape; pixels that are part of no triangle are left outside. A saved one is
    loaded without a scene: its shadows are then those of parallel rays.

    Parameters
    ----------
    depth
        (h, w) heights in world units, larger nearer the camera; NaN where there is no surface. With intrinsics, z in
        the camera's axes: minus the distance along its axis, below 0 (as `read_depth_map` gives it).
    albedo
        (h, w) or (h, w, 3) linear reflectances, or one number for all.
    pixel_size
        World units a pixel, 1 by default. Not together with intrinsics, which give its mean.
    mask
        (h, w) booleans; by default every pixel that is not NaN.
    intrinsics
        (fx, fy, cx, cy) in pixels, the centre of the first one at (0.5, 0.5), see `PerspectiveView`.
    steepest
        Degrees of slope toward the line of sight, above 0 and at most 90, beyond which there is a step. By default 90
        (no steps) without intrinsics and 80 with them.

    Returns
    -------
    Surface
        Its normals have the type of the depth, float32 or float64, and are in the camera's axes.

    Raises
    ------
    HarmonicFaceError
        Arrays of another shape, infinite depth, NaN inside a given mask, depth behind the pinhole, intrinsics or angles
        out of range, or no pixel with neighbours.

    Examples
    --------
    >>> slope = np.tile(np.arange(3.0), (3, 1))  # rises to the right by one pixel a pixel
    >>> surface_from_depth(slope).normals[1, 1].round(4) + 0.0
    array([-0.7071,  0.    ,  0.7071])
    >>> wall = surface_from_depth(np.full((4, 4), -2.0), intrinsics=(8, 8, 2, 2))
    >>> wall.pixel_size, wall.normals[0, 0] + 0.0
    (0.25, array([0., 0., 1.]))
    """
    heights, inside = _checked(depth, mask)
    reflectances = _validate.floats(albedo, "albedo")
    if reflectances.ndim == 0:
        reflectances = np.full(heights.shape, reflectances, dtype=heights.dtype)
    if intrinsics is None:
        step = 1.0 if pixel_size is None else _validate.positive(pixel_size, "pixel_size")
        rise = step * _checked_rise(90.0 if steepest is None else steepest)
        right = _differences(heights, _joined(heights, inside, rise))
        down = _differences(heights.T, _joined(heights.T, inside.T, rise)).T
        normals = np.stack([-right / step, down / step, np.ones(heights.shape)], axis=2)  # y is up, rows point down
        known = _unit(normals, inside)
        return Surface(normals.astype(heights.dtype), reflectances, known, heights, step)
    if pixel_size is not None:
        raise HarmonicFaceError(f"pixel_size: expected none beside intrinsics, got {pixel_size!r}")
    rise = _checked_rise(STEEPEST if steepest is None else steepest)
    numbers = checked_intrinsics(intrinsics, (inside.shape[0], inside.shape[1]))
    return _of_a_pinhole(heights, inside, reflectances, numbers, rise)


def _of_a_pinhole(heights: Floats, inside: Mask, albedo: Floats, intrinsics: Intrinsics, rise: float) -> Surface:
    """Return the Surface of z in the axes of a pinhole camera."""
    if heights[inside].max() >= 0:
        count = int((heights[inside] >= 0).sum())
        raise HarmonicFaceError(
            f"depth: expected z below 0 before the camera (minus the distance), got {count} pixels of at least 0"
        )
    z = np.where(inside, heights, np.nan).astype(np.float64)
    # An edge that rises by dz over the width z / f of a pixel rises by d log z over 1 / f.
    nearness = -np.log(-z)
    fx, fy = intrinsics[:2]
    places = rays(intrinsics, inside.shape) * z[..., None]
    right = _differences(places, _joined(nearness, inside, rise / fx))
    down = _differences(places.swapaxes(0, 1), _joined(nearness.T, inside.T, rise / fy)).swapaxes(0, 1)
    normals = np.cross(down, right)
    known = _unit(normals, inside)
    rows, columns = np.nonzero(known)
    faces = grid_faces(known, np.stack([columns / fx, -rows / fy, nearness[known]], axis=1), rise)
    number = np.flatnonzero(known)
    used = np.unique(faces)
    if len(used) == 0:
        raise HarmonicFaceError("depth: expected three neighbouring pixels without a step between them, got none")
    seen = np.zeros(inside.shape, dtype=bool)
    seen.flat[number[used]] = True
    distance = float(-z[seen].mean())
    surface = Surface(normals.astype(heights.dtype), albedo, seen, heights, distance / float(np.sqrt(fx * fy)))
    view = PerspectiveView(np.eye(3), np.zeros(3), intrinsics, surface.shape, distance)
    colours = np.broadcast_to(surface.pixel_albedo.reshape(len(used), -1), (len(used), 3)).astype(np.float64)
    wears = np.full(len(faces), -1)
    mesh = Mesh(places[seen], np.searchsorted(used, faces), normals[seen].astype(np.float64), None, (), wears, colours)
    arrays = (surface.normals, surface.albedo, seen, surface.depth, surface.pixel_size)
    return Surface(*arrays, scene=Scene(mesh, view))


def _checked(depth: ArrayLike, mask: Mask | None) -> tuple[Floats, Mask]:
    """Return finite or NaN heights and the mask."""
    heights = _validate.floats(depth, "depth")
    if heights.ndim != 2 or heights.size == 0:
        raise HarmonicFaceError(f"depth: expected shape (h, w), got {_validate.describe(heights)}")
    shape = (heights.shape[0], heights.shape[1])
    if np.isinf(heights).any():
        raise HarmonicFaceError("depth: expected finite heights, or NaN for no surface, got infinity")
    inside = _validate.mask(~np.isnan(heights) if mask is None else mask, "mask", shape)
    _validate.finite(heights[inside], "depth")
    return heights, inside


def _checked_rise(steepest: float) -> float:
    """Return the tangent of an angle in degrees of up to 90."""
    degrees = _validate.positive(steepest, "steepest")
    if degrees > 90:
        raise HarmonicFaceError(f"steepest: expected at most 90 degrees, got {degrees:.6g}")
    return np.inf if degrees == 90 else float(np.tan(np.deg2rad(degrees)))


def _joined(heights: Floats, inside: Mask, rise: float) -> Mask:
    """Return whether each pixel and the next in its row are one surface, (h, w - 1)."""
    near = np.abs(np.diff(np.where(inside, heights, 0.0), axis=1)) <= rise
    return np.asarray(inside[:, :-1] & inside[:, 1:] & near)


def _differences(values: Floats, joined: Mask) -> Floats:
    """Return the change from column to column, NaN where a pixel is joined to neither neighbour."""
    beside = joined.reshape(*joined.shape, *[1] * (values.ndim - 2))
    padded = np.full((values.shape[0], values.shape[1] + 1, *values.shape[2:]), np.nan)
    padded[:, 1:-1] = np.where(beside, np.diff(values.astype(np.float64), axis=1), np.nan)
    from_left, to_right = padded[:, :-1], padded[:, 1:]
    both = (from_left + to_right) / 2
    return np.where(np.isnan(from_left), to_right, np.where(np.isnan(to_right), from_left, both))


def _unit(normals: Floats, inside: Mask) -> Mask:
    """Scale normals to unit length in place, 0 where there is none, and return where there is one."""
    known = inside & np.isfinite(normals).all(axis=2)
    if not known.any():
        raise HarmonicFaceError("depth: expected pixels with neighbours beside and above or below them, got none")
    normals[~known] = 0
    normals[known] /= np.linalg.norm(normals[known], axis=1, keepdims=True)
    return known
