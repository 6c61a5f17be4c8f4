"""PerspectiveView: a pinhole camera in front of a shape, from world units to pixels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces.view import SMALLEST_PIXEL, View, checked_shape, rotation_matrix

FARTHEST_AXIS = 100.0  # sizes of the picture between the picture and where the axis meets its plane
SHORTEST_FOCUS = 1e-3  # pixels: all of them within a thousandth of 180 degrees

Intrinsics = tuple[float, float, float, float]


@dataclass(frozen=True, eq=False)
class PerspectiveView:
    """A pinhole camera that looks along -z from where it stands: what is farther away is smaller.

    In the camera's axes, with x right, y up, z backward and the pinhole at the origin, a point falls on

    column = cx - fx x / z,    row = cy + fy y / z    (z < 0 in front of the camera)

    Build one with `PerspectiveView.fit`; the fields are what it found.

    Parameters
    ----------
    rotation
        (3, 3) matrix that turns the world before it is looked at.
    position
        (3,) where the pinhole is, in world units after the rotation.
    intrinsics
        (fx, fy, cx, cy) in pixels: focal lengths, and where the axis meets the picture, counted from its top left
        corner, so that the first pixel's centre is (0.5, 0.5). A calibration that puts that centre at (0, 0), as
        OpenCV's does, needs 0.5 added to cx and cy.
    shape
        Height and width of the picture in pixels.
    distance
        World units from the pinhole to the middle of what is looked at; `pixel_size` is measured there.

    Examples
    --------
    >>> points = np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]])
    >>> view = PerspectiveView.fit(points, size=4, intrinsics=(8.0, 8.0, 2.0, 2.0), distance=4.0)
    >>> view.project(np.array([[-1.0, 1.0, 0.0], [-1.0, 1.0, -4.0]]))  # twice as far: half as far from the centre
    array([[ 0.,  0., -4.],
           [ 1.,  1., -8.]])
    """

    rotation: NDArray[np.float64]
    position: NDArray[np.float64]
    intrinsics: Intrinsics
    shape: tuple[int, int]
    distance: float

    @classmethod
    def fit(
        cls,
        points: ArrayLike,
        size: int | tuple[int, int] = 64,
        *,
        intrinsics: Sequence[float],
        distance: float | None = None,
        rotation: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> PerspectiveView:
        """Return the camera that looks at the middle of the points' bounding box from a distance.

        Parameters
        ----------
        points
            (n, 3) points in world units: x right, y up, z toward the camera.
        size
            Height and width of the picture in pixels; one number means a square picture.
        intrinsics
            (fx, fy, cx, cy) in pixels of this size; both focal lengths above 0.
        distance
            World units from the pinhole to the middle of the box of the rotated points. By default the least distance
            at which all points are in the picture.
        rotation
            (yaw, pitch, roll) in degrees, see `rotation_matrix`.

        Raises
        ------
        HarmonicFaceError
            Points, rotation, intrinsics, size or distance of another form; no distance although the axis meets the
            picture's border or passes beside it, so that no distance shows everything.
        """
        shape = checked_shape(size)
        numbers = checked_intrinsics(intrinsics, shape)
        turn = rotation_matrix(rotation)
        turned = _validate.vectors(points, "points") @ turn.T
        if turned.size == 0:
            raise HarmonicFaceError("points: expected at least one, got none")
        middle = (turned.min(axis=0) + turned.max(axis=0)) / 2
        if distance is None:
            distance = _showing_all(turned - middle, numbers, shape)
        away = _validate.positive(distance, "distance")
        if away < SMALLEST_PIXEL:
            raise HarmonicFaceError(f"distance: expected at least {SMALLEST_PIXEL:g} world units, got {away:.3g}")
        return cls(turn, middle + np.array([0.0, 0.0, away]), numbers, shape, away)

    @property
    def pixel_size(self) -> float:
        """World units a pixel at the distance of what is looked at, the geometric mean of both sides."""
        return float(self.pixel_size_at(-self.distance))

    def pixel_size_at(self, depth: ArrayLike) -> Floats:
        """Return world units a pixel at depths of any shape: -z over the (geometric mean) focal length."""
        return np.asarray(-np.asarray(depth, dtype=np.float64) / np.sqrt(self.intrinsics[0] * self.intrinsics[1]))

    def turn(self, vectors: ArrayLike) -> NDArray[np.float64]:
        """Return directions in the axes of the camera, (..., 3)."""
        return np.asarray(_validate.vectors(vectors, "vectors") @ self.rotation.T)

    def place(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return points in the axes of the camera, (..., 3): the pinhole is the origin, z < 0 lies before it."""
        return np.asarray(self.turn(points) - self.position)

    def project(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return pixel coordinates and depth (z in the camera's axes) of points, (n, 3).

        Raises
        ------
        HarmonicFaceError
            A point that is not before the camera.
        """
        placed = self.place(points)
        behind = int((placed[:, 2] >= 0).sum())
        if behind:
            raise HarmonicFaceError(f"points: expected all before the camera, got {behind} beside or behind it")
        return np.column_stack([self.pixels(placed), placed[:, 2]])

    def pixels(self, placed: Floats) -> Floats:
        """Return column and row, (n, 2), of points in the camera's axes that lie before it."""
        fx, fy, cx, cy = self.intrinsics
        return np.stack([cx - fx * placed[:, 0] / placed[:, 2], cy + fy * placed[:, 1] / placed[:, 2]], axis=1)

    def toward(self) -> NDArray[np.float64]:
        """Return what leads from a point that a pixel sees to the camera, (h, w, 3), with z = 1."""
        return rays(self.intrinsics, self.shape)

    def finer(self, divisions: int) -> PerspectiveView:
        """Return the camera that shows the same with each pixel divided along both sides."""
        fx, fy, cx, cy = (divisions * number for number in self.intrinsics)
        shape = self.shape[0] * divisions, self.shape[1] * divisions
        return PerspectiveView(self.rotation, self.position, (fx, fy, cx, cy), shape, self.distance)


Camera = View | PerspectiveView


def rays(intrinsics: Intrinsics, shape: tuple[int, int]) -> NDArray[np.float64]:
    """Return what leads from a point seen by each pixel's centre to the pinhole, (h, w, 3), scaled to z = 1.

    Parameters
    ----------
    intrinsics
        (fx, fy, cx, cy) in pixels, see `PerspectiveView`.
    shape
        Height and width in pixels.

    Examples
    --------
    >>> rays((10.0, 10.0, 1.0, 0.5), (1, 2))  # left of the axis the camera is to the right
    array([[[ 0.05, 0.  , 1.  ],
            [-0.05, 0.  , 1.  ]]])
    """
    fx, fy, cx, cy = intrinsics
    result = np.ones((*shape, 3))
    result[..., 0] = (cx - 0.5 - np.arange(shape[1])) / fx
    result[..., 1] = ((0.5 + np.arange(shape[0]) - cy) / fy)[:, None]
    return result + 0.0


def checked_intrinsics(intrinsics: Sequence[float], shape: tuple[int, int]) -> Intrinsics:
    """Return (fx, fy, cx, cy) as floats, of a camera that may have taken a picture of this height and width.

    Raises
    ------
    HarmonicFaceError
        Anything but four finite numbers with fx and fy at least 1e-3 pixels, and the axis within 100 sizes of the
        picture.

    Examples
    --------
    >>> checked_intrinsics([100, 100, 32, 32], (64, 64))
    (100.0, 100.0, 32.0, 32.0)
    """
    numbers = _validate.finite(intrinsics, "intrinsics")
    if numbers.shape != (4,):
        got = _validate.describe(numbers)
        raise HarmonicFaceError(f"intrinsics: expected (fx, fy, cx, cy) in pixels, got {got}")
    fx, fy, cx, cy = (float(number) for number in numbers)
    if not (fx > 0 and fy > 0):
        raise HarmonicFaceError(f"intrinsics: expected focal lengths above 0, got fx = {fx:.6g}, fy = {fy:.6g}")
    if min(fx, fy) < SHORTEST_FOCUS:
        raise HarmonicFaceError(
            f"intrinsics: expected focal lengths of at least {SHORTEST_FOCUS:g} pixels, got {fx:.6g} and {fy:.6g}"
        )
    if max(abs(cx) / shape[1], abs(cy) / shape[0]) > FARTHEST_AXIS:
        raise HarmonicFaceError(
            f"intrinsics: expected (cx, cy) within {FARTHEST_AXIS:g} sizes of the picture of {shape[1]} x {shape[0]} "
            f"pixels, got ({cx:.6g}, {cy:.6g})"
        )
    return fx, fy, cx, cy


def _showing_all(points: Floats, intrinsics: Intrinsics, shape: tuple[int, int]) -> float:
    """Return the least distance from the origin at which all points fall into the picture."""
    fx, fy, cx, cy = intrinsics
    if not (0 < cx < shape[1] and 0 < cy < shape[0]):
        raise HarmonicFaceError(
            f"distance: expected one, since the axis at ({cx:.6g}, {cy:.6g}) is not within the {shape[1]} x {shape[0]}"
            " pixels and no distance shows everything; got None"
        )
    x, y, z = points.T
    across = np.maximum(-x * fx / cx, x * fx / (shape[1] - cx))
    along = np.maximum(y * fy / cy, -y * fy / (shape[0] - cy))
    distance = float((z + np.maximum(across, along)).max())
    if distance <= 0:
        raise HarmonicFaceError("points: expected some extent, got points that fall on one another")
    return distance
