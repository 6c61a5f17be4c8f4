"""From points with normals to a Surface: each point is a small disc, and the nearest layer of discs is what is seen."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from harmonicface import _validate
from harmonicface._memory import require
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.meshes import LARGEST
from harmonicface.surfaces.surface import Surface
from harmonicface.surfaces.view import View

NEIGHBOURS = 8  # the distance to so many is a disc's radius
WIDEST = 3.0  # times the median radius: a point that lies alone fills no more
NARROWEST = 0.75  # pixels: more than half a diagonal, so that every disc that faces the camera has a pixel's centre
THICKNESS = 2.0  # radii behind the nearest disc that still belong to the same layer
EDGE_ON = 1e-6  # the z of a normal below which a disc is a line that nobody sees
FRAGMENTS = 1 << 20  # pixels of discs that are looked at at once
BYTES_A_POINT = 300  # 150 measured at 3 million, beside the arrays that are given


def surface_from_points(
    points: ArrayLike,
    normals: ArrayLike,
    albedo: ArrayLike | None = None,
    size: int | tuple[int, int] = 64,
    *,
    rotation: Sequence[float] = (0.0, 0.0, 0.0),
    frame: Sequence[float] | None = None,
) -> Surface:
    """Return what an orthographic camera sees of a cloud of points with normals.

    Each point is a flat disc at a right angle to its normal (Zwicker et al. 2001, Surface splatting). Its radius is the
    distance to its eighth nearest neighbour, but at most 3 times the median of these and at least 0.75 pixels: so a
    hole is closed if it is not wider than the spacing of the points around it, and a larger one stays open. A pixel is
    inside the mask if its centre lies behind a disc; it shows the mean of the normals, depth and albedo of the discs
    there, weighted by (1 - (distance / radius)^2)^2, of the nearest layer alone: discs that lie at most two radii
    behind the nearest one and are seen from the same side. At a border the surface reaches beyond its last points by a
    radius. Discs are seen from both sides; a normal always faces the camera.

    Parameters
    ----------
    points
        (n, 3) positions in world units: x right, y up, z toward the camera; at least 2.
    normals
        (n, 3) unit vectors.
    albedo
        (n,) or (n, 3) linear reflectances of at least 0; 0.5 by default.
    size
        Height and width in pixels; one number means a square.
    rotation
        (yaw, pitch, roll) in degrees, see `rotation_matrix`.
    frame
        (x0, y0, x1, y1): what the picture shows, in world units after the rotation; by default all of the points.

    Returns
    -------
    Surface of float32 arrays, with depth in world units.

    Raises
    ------
    HarmonicFaceError
        Arrays of another shape, NaN, normals that are not unit vectors, negative albedo, points that all lie on one
        another, a view that shows none of them, more points than there is memory for.

    Examples
    --------
    >>> x, y = (grid.ravel() for grid in np.mgrid[0:1:20j, 0:1:20j])
    >>> wall = surface_from_points(np.stack([x, y, 2 + 0 * x], axis=1), np.tile([0.0, 0.0, 1.0], (400, 1)), size=8)
    >>> bool(wall.mask.all()), wall.depth[4, 4], wall.normals[4, 4]
    (True, np.float32(2.0), array([0., 0., 1.], dtype=float32))
    """
    positions, directions, reflectances = _checked(points, normals, albedo)
    require(BYTES_A_POINT * len(positions), f"a surface of {len(positions)} points")
    view = View.fit(positions, size, rotation=rotation, frame=frame)
    discs = _Discs.of(positions, directions, view)
    shape = view.shape
    nearest = np.full(shape[0] * shape[1], -np.inf)
    front = nearest.copy()  # the nearest disc that faces the camera
    for disc, pixel, depth, _ in discs.fragments(shape):
        np.maximum.at(nearest, pixel, depth)
        facing = discs.facing[disc]
        np.maximum.at(front, pixel[facing], depth[facing])
    sums = np.zeros((len(nearest), 5 + reflectances.shape[1]))  # weight, normal, depth, albedo
    for disc, pixel, depth, weight in discs.fragments(shape):
        thickness = THICKNESS * discs.radius[disc]
        from_front = front[pixel] >= nearest[pixel] - thickness
        layer = np.where(from_front, front[pixel], nearest[pixel])
        same = (depth >= layer - thickness) & (discs.facing[disc] == from_front)
        disc, pixel, weight = disc[same], pixel[same], weight[same]
        values = np.column_stack([np.ones(len(disc)), discs.normals[disc], depth[same], reflectances[disc]])
        for column in range(sums.shape[1]):
            sums[:, column] += np.bincount(pixel, weight * values[:, column], minlength=len(sums))
    return _surface(sums, view)


@dataclass(frozen=True, eq=False)
class _Discs:
    """Discs in the camera's axes: centre in pixels and depth, normal toward the camera, radius in world units."""

    centres: Floats
    normals: Floats
    facing: NDArray[np.bool_]
    radius: Floats
    pixel_size: float

    @classmethod
    def of(cls, positions: Floats, directions: Floats, view: View) -> _Discs:
        count = min(NEIGHBOURS + 1, len(positions))
        radius = cKDTree(positions).query(positions, k=[count])[0][:, 0]
        radius = np.clip(radius, NARROWEST * view.pixel_size, max(WIDEST * np.median(radius), view.pixel_size))
        normals = view.turn(directions)
        facing = normals[:, 2] >= 0
        normals[~facing] *= -1
        return cls(view.project(positions), normals, facing, radius, view.pixel_size)

    def fragments(
        self, shape: tuple[int, int]
    ) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], Floats, Floats]]:
        """Yield discs, the pixels whose centres lie behind them, depth and weight there; about FRAGMENTS at once."""
        reach = np.ceil(self.radius / self.pixel_size).astype(np.int64)
        begins = self.centres[:, :2] + reach[:, None] >= 0
        ends = self.centres[:, :2] - reach[:, None] <= np.array([shape[1], shape[0]])
        near = np.flatnonzero((begins & ends).all(axis=1) & (self.normals[:, 2] > EDGE_ON))
        for steps in np.unique(reach[near]):
            group = near[reach[near] == steps]
            across, down = (grid.ravel() for grid in np.mgrid[-steps : steps + 1, -steps : steps + 1])
            step = max(1, FRAGMENTS // len(across))
            for begin in range(0, len(group), step):
                yield self._inside(group[begin : begin + step], across, down, shape)

    def _inside(
        self, group: NDArray[np.int64], across: NDArray[np.int64], down: NDArray[np.int64], shape: tuple[int, int]
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats, Floats]:
        centre = self.centres[group]
        column = np.floor(centre[:, :1]).astype(np.int64) + across
        row = np.floor(centre[:, 1:2]).astype(np.int64) + down
        x = (column + 0.5 - centre[:, :1]) * self.pixel_size
        y = (centre[:, 1:2] - row - 0.5) * self.pixel_size
        normal = self.normals[group]
        z = -(normal[:, :1] * x + normal[:, 1:2] * y) / normal[:, 2:]
        share = (x**2 + y**2 + z**2) / self.radius[group, None] ** 2
        here = (share < 1) & (column >= 0) & (column < shape[1]) & (row >= 0) & (row < shape[0])
        disc = np.broadcast_to(group[:, None], here.shape)[here]
        pixel = (row * shape[1] + column)[here]
        return disc, pixel, (centre[:, 2:] + z)[here], (1 - share[here]) ** 2


def _checked(points: ArrayLike, normals: ArrayLike, albedo: ArrayLike | None) -> tuple[Floats, Floats, Floats]:
    """Return positions, unit normals and reflectances of (n, 1) or (n, 3)."""
    positions = _validate.vectors(points, "points").astype(np.float64, copy=False)
    if positions.ndim != 2 or len(positions) < 2:
        raise HarmonicFaceError(f"points: expected shape (n, 3) with n of at least 2, got {positions.shape}")
    if np.abs(positions).max() > LARGEST:
        raise HarmonicFaceError(f"points: expected positions within {LARGEST:g}, got {np.abs(positions).max():.3g}")
    directions = _validate.unit_normals(normals, "normals").astype(np.float64)
    if directions.shape != positions.shape:
        raise HarmonicFaceError(f"normals: expected shape {positions.shape}, got {directions.shape}")
    count = len(positions)
    reflectances = np.full(count, 0.5) if albedo is None else _validate.finite(albedo, "albedo").astype(np.float64)
    if reflectances.shape not in ((count,), (count, 3)):
        raise HarmonicFaceError(f"albedo: expected shape {(count,)} or {(count, 3)}, got {reflectances.shape}")
    if reflectances.min() < 0:
        raise HarmonicFaceError(f"albedo: expected at least 0, got {reflectances.min():.4g}")
    return positions, directions, reflectances.reshape(count, -1)


def _surface(sums: Floats, view: View) -> Surface:
    """Divide the sums by their weights."""
    normals = sums[:, 1:4]
    length = np.linalg.norm(normals, axis=1)
    inside = length > 1e-6 * sums[:, 0]
    if not inside.any():
        raise HarmonicFaceError(f"frame: expected some of the points in view, got {view.frame} which shows none")
    result = np.zeros_like(sums)
    result[inside] = sums[inside] / sums[inside, :1]
    result[inside, 1:4] = normals[inside] / length[inside, None]
    picture = result.reshape(*view.shape, -1)
    albedo = picture[..., 5:] if picture.shape[2] > 6 else picture[..., 5]
    mask = inside.reshape(view.shape)
    arrays = (picture[..., 1:4].astype(np.float32), albedo.astype(np.float32))
    return Surface(*arrays, mask, picture[..., 4].astype(np.float32), view.pixel_size)
