"""Windows: what becomes of a camera when its picture is cut, resized or decimated, or when what it sees is turned."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface.surfaces.perspective import Camera
from harmonicface.surfaces.view import View


@dataclass(frozen=True)
class Window:
    """Square pixels laid over a picture, in the picture's own pixels.

    Parameters
    ----------
    top, left
        Where the window's top left corner is, counted from that of the picture; below 0 beyond the picture.
    step
        Side of the window's pixels: above 1 they are larger than the picture's.
    shape
        Height and width of the window in its own pixels.

    Examples
    --------
    >>> Window.over((30, 40), (15, 10))  # as much as there is across, and as wide pixels down
    Window(top=-15.0, left=0.0, step=4.0, shape=(15, 10))
    """

    top: float
    left: float
    step: float
    shape: tuple[int, int]

    @classmethod
    def over(cls, picture: tuple[int, int], shape: tuple[int, int]) -> Window:
        """Return the window of a shape that shows the whole picture, and more of it where the proportions differ."""
        step = max(old / new for old, new in zip(picture, shape, strict=True))
        top, left = ((old - new * step) / 2 for old, new in zip(picture, shape, strict=True))
        return cls(top, left, step, shape)


def through(view: Camera, window: Window) -> Camera:
    """Return the camera whose picture is the window.

    Examples
    --------
    >>> view = View.fit([[0.0, 0.0, 0.0], [4.0, 4.0, 0.0]], size=4)
    >>> through(view, Window(1, 0, 1.0, (2, 3))).frame
    (0.0, 1.0, 3.0, 3.0)
    """
    height, width = window.shape
    if isinstance(view, View):
        size = view.pixel_size
        x0, y0, x1, y1 = view.frame
        right = view.shape[1] - window.left - width * window.step  # what is cut off there
        bottom = view.shape[0] - window.top - height * window.step
        frame = (x0 + window.left * size, y0 + bottom * size, x1 - right * size, y1 - window.top * size)
        return View(view.rotation, frame, window.shape)
    fx, fy, cx, cy = view.intrinsics
    focus = (fx / window.step, fy / window.step)
    centre = ((cx - window.left) / window.step, (cy - window.top) / window.step)
    return type(view)(view.rotation, view.position, focus + centre, window.shape, view.distance)


def middle(view: Camera, depth: float) -> NDArray[np.float64]:
    """Return the point in the middle of the picture at a depth, (3,), as `Camera.place` places points.

    Examples
    --------
    >>> middle(View.fit([[0.0, 0.0, 0.0], [4.0, 4.0, 0.0]]), 7.0)
    array([2., 2., 7.])
    """
    if isinstance(view, View):
        x0, y0, x1, y1 = view.frame
        return np.array([(x0 + x1) / 2, (y0 + y1) / 2, depth])
    fx, fy, cx, cy = view.intrinsics
    return np.array([(cx - view.shape[1] / 2) / fx, (view.shape[0] / 2 - cy) / fy, 1.0]) * depth


def turned(view: Camera, rotation: NDArray[np.float64], pivot: NDArray[np.float64]) -> Camera:
    """Return the camera that sees the world turned about a point, which stays where it is in the picture.

    An orthographic camera turns about the origin of the world and moves its frame, so depths are those of the turned
    world; before a pinhole the pivot keeps its depth as well.

    Parameters
    ----------
    view
        The camera before.
    rotation
        (3, 3) matrix in the camera's axes.
    pivot
        (3,) as `Camera.place` places points.
    """
    shift = rotation @ pivot - pivot
    if isinstance(view, View):
        x0, y0, x1, y1 = view.frame
        frame = (x0 + shift[0], y0 + shift[1], x1 + shift[0], y1 + shift[1])
        return View(rotation @ view.rotation, tuple(float(border) for border in frame), view.shape)  # type: ignore[arg-type]
    position = rotation @ view.position + shift
    return type(view)(rotation @ view.rotation, position, view.intrinsics, view.shape, view.distance)
