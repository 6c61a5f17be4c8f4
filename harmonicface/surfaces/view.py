"""View: an orthographic camera in front of a shape, from world units to pixels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError

Frame = tuple[float, float, float, float]
SMALLEST_FRAME = 1e-9  # of its distance from the origin
SMALLEST_PIXEL = 1e-60  # world units; far below it the squares of areas are 0
MOST_PIXELS = 1 << 14  # a side


@dataclass(frozen=True, eq=False)
class View:
    """An orthographic camera that looks along -z: how points of the world fall on a grid of square pixels.

    Build one with `View.fit`; the fields are what it found.

    Parameters
    ----------
    rotation
        (3, 3) matrix that turns the world before it is looked at.
    frame
        (x0, y0, x1, y1): left, bottom, right and top border of the picture in world units after the rotation.
    shape
        Height and width of the picture in pixels.

    Examples
    --------
    >>> import numpy as np
    >>> view = View.fit(np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]]), size=4)
    >>> view.pixel_size
    0.5
    >>> view.project(np.array([[-1.0, 1.0, 3.0], [0.0, 0.0, 3.0]]))  # top left corner, centre; y points down
    array([[0., 0., 3.],
           [2., 2., 3.]])
    """

    rotation: NDArray[np.float64]
    frame: Frame
    shape: tuple[int, int]

    @classmethod
    def fit(
        cls,
        points: ArrayLike,
        size: int | tuple[int, int] = 64,
        *,
        rotation: Sequence[float] = (0.0, 0.0, 0.0),
        frame: Sequence[float] | None = None,
    ) -> View:
        """Return the view of a frame, or of all the points, with square pixels.

        Parameters
        ----------
        points
            (n, 3) points in world units: x right, y up, z toward the camera.
        size
            Height and width of the picture in pixels; one number means a square picture.
        rotation
            (yaw, pitch, roll) in degrees, see `rotation_matrix`.
        frame
            (x0, y0, x1, y1) in world units after the rotation: what the picture shows. By default the bounding box
            of the rotated points. Where its proportions are not those of the picture, the picture shows more than
            the frame, centred on it: pixels are always square.

        Raises
        ------
        HarmonicFaceError
            Points, rotation, frame or size of another form; an empty frame; points that all lie on one another.
        """
        shape = checked_shape(size)
        turn = rotation_matrix(rotation)
        turned = _validate.vectors(points, "points") @ turn.T
        x0, y0, x1, y1 = _bounding_box(turned) if frame is None else _checked_frame(frame)
        pixel_size = max((x1 - x0) / shape[1], (y1 - y0) / shape[0])
        if pixel_size < SMALLEST_PIXEL:
            what = "points" if frame is None else "frame"
            raise HarmonicFaceError(
                f"{what}: expected pixels of at least {SMALLEST_PIXEL:g} world units, got {pixel_size:.3g}"
            )
        half_width, half_height = pixel_size * shape[1] / 2, pixel_size * shape[0] / 2
        x, y = (x0 + x1) / 2, (y0 + y1) / 2
        return cls(turn, (x - half_width, y - half_height, x + half_width, y + half_height), shape)

    @property
    def pixel_size(self) -> float:
        """World units a pixel."""
        return (self.frame[3] - self.frame[1]) / self.shape[0]

    def project(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return pixel coordinates and depth of points, (n, 3).

        x counts pixels from the left border, y from the top border downward, and the centre of the first pixel is
        at (0.5, 0.5); z is the depth in world units, larger nearer the camera.
        """
        turned = self.turn(points)
        x0, _, _, top = self.frame
        columns = (turned[:, 0] - x0) / self.pixel_size
        rows = (top - turned[:, 1]) / self.pixel_size
        return np.stack([columns, rows, turned[:, 2]], axis=1)

    def turn(self, vectors: ArrayLike) -> NDArray[np.float64]:
        """Return directions (or points) in the axes of the camera, still in world units, (..., 3)."""
        return np.asarray(_validate.vectors(vectors, "vectors") @ self.rotation.T)

    def place(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return points in the axes of the camera, (..., 3); its z is the depth of a Surface."""
        return self.turn(points)

    def toward(self) -> NDArray[np.float64]:
        """Return what leads from a point that a pixel sees to the camera, (h, w, 3), with z = 1: here (0, 0, 1)."""
        return np.broadcast_to(np.array([0.0, 0.0, 1.0]), (*self.shape, 3))

    def pixel_size_at(self, depth: ArrayLike) -> Floats:
        """Return world units a pixel at depths of any shape: here the same everywhere."""
        return np.full(np.shape(depth), self.pixel_size)

    def finer(self, divisions: int) -> View:
        """Return the view that shows the same with each pixel divided along both sides."""
        return View(self.rotation, self.frame, (self.shape[0] * divisions, self.shape[1] * divisions))


def rotation_matrix(rotation: Sequence[float]) -> NDArray[np.float64]:
    """Return the matrix of (yaw, pitch, roll) in degrees, each by the right-hand rule about the camera's axes.

    R = R_z(roll) R_x(pitch) R_y(yaw): yaw comes first. For a face that looks at the camera, positive yaw turns it
    toward the picture's right, positive pitch turns it down, and positive roll leans it counterclockwise.

    Parameters
    ----------
    rotation
        Three finite angles in degrees.

    Returns
    -------
    (3, 3) float64, to be multiplied on the left of column vectors.

    Raises
    ------
    HarmonicFaceError
        Anything but three finite numbers.

    Examples
    --------
    >>> import numpy as np
    >>> nose = np.array([0.0, 0.0, 1.0])
    >>> (rotation_matrix((90.0, 0.0, 0.0)) @ nose).round(6) + 0.0
    array([1., 0., 0.])
    """
    angles = _numbers(rotation, 3, "rotation", "(yaw, pitch, roll) in degrees")
    return np.asarray(Rotation.from_euler("yxz", angles, degrees=True).as_matrix(), dtype=np.float64)


def checked_shape(size: int | tuple[int, int]) -> tuple[int, int]:
    """Return (height, width) of a size that is one number or two."""
    sides: tuple[Any, ...] = (size, size) if isinstance(size, (int, np.integer)) else _as_tuple(size)
    whole = all(isinstance(side, (int, np.integer)) and not isinstance(side, bool) for side in sides)
    if len(sides) != 2 or not whole or min(sides) < 1:
        raise HarmonicFaceError(f"size: expected pixels, one number or (height, width), got {size!r}")
    if max(sides) > MOST_PIXELS:
        raise HarmonicFaceError(f"size: expected at most {MOST_PIXELS} pixels a side, got {max(sides):.6g}")
    return int(sides[0]), int(sides[1])


def _as_tuple(value: object) -> tuple[Any, ...]:
    return tuple(value) if isinstance(value, (tuple, list, np.ndarray)) else ()


def _numbers(values: ArrayLike, count: int, name: str, form: str) -> Floats:
    """Return `count` finite numbers."""
    array = _validate.finite(values, name)
    if array.shape != (count,):
        raise HarmonicFaceError(f"{name}: expected {form}, got {_validate.describe(array)}")
    return array


def _checked_frame(frame: Sequence[float]) -> Frame:
    x0, y0, x1, y1 = (float(v) for v in _numbers(frame, 4, "frame", "(x0, y0, x1, y1) in world units"))
    if not (x0 < x1 and y0 < y1):
        raise HarmonicFaceError(f"frame: expected x0 < x1 and y0 < y1, got {(x0, y0, x1, y1)}")
    if max(x1 - x0, y1 - y0) < SMALLEST_FRAME * max(abs(x0), abs(x1), abs(y0), abs(y1)):
        raise HarmonicFaceError(f"frame: expected borders that rounding keeps apart, got {(x0, y0, x1, y1)}")
    return x0, y0, x1, y1


def _bounding_box(points: Floats) -> Frame:
    """Return the box around points; a box without extent cannot be looked at."""
    if len(points) == 0:
        raise HarmonicFaceError("points: expected at least one, got none")
    x0, y0 = (float(v) for v in points[:, :2].min(axis=0))
    x1, y1 = (float(v) for v in points[:, :2].max(axis=0))
    if x0 == x1 and y0 == y1:
        raise HarmonicFaceError("points: expected some extent across the view, got points that fall on one another")
    return x0, y0, x1, y1
