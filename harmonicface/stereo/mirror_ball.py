"""Mirror ball: the direction of a lamp from its highlight in a chrome ball beside what is photographed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import binary_dilation, label

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError

SMALLEST = 8.0  # pixels of radius: a pixel of error in the highlight is 2 / radius in the direction
ROUND = 0.95  # of the area that a mask and its circle cover together, in both
BROADEST = 0.1  # of the ball that a lamp's highlight may cover
RIVAL = 0.5  # of the highlight's light, in another one
INSIDE = 0.985  # of the radius: the rim's pixels show the background too
BORDER = 2  # pixels around a highlight
CONTRAST = 1.5  # of the highlight over the ball's median

Circle = tuple[float, float, float]


def mirror_ball_lights(
    photographs: ArrayLike, circle: Sequence[float] | None = None, mask: ArrayLike | None = None
) -> NDArray[np.float64]:
    r"""Return the direction to the lamp of each photograph, from its highlight on a mirror ball.

    A mirror sends the ray from the camera at n on the ball to

    .. math:: l = 2 (n \cdot v) n - v, \quad v = (0, 0, 1), \quad n = (x, y, \sqrt{1 - x^2 - y^2})

    with x and y from the ball's middle in units of its radius. Equal areas of the picture are equal solid angles, so
    the direction is the mean of l over the highlight, weighted by its brightness above the ball's median. The camera is
    taken to look at the ball from afar, along -z, and the lamp to be far away.

    Parameters
    ----------
    photographs
        (n, h, w) linear grey intensities, at least 0. A saturated highlight is fine.
    circle
        (x, y, radius) of the ball in pixels: its middle from the picture's upper left corner, x to the right, y down.
    mask
        (h, w) booleans, true on the ball; in place of the circle.

    Returns
    -------
    array
        (n, 3) unit vectors, x right, y up, z toward the camera.

    Raises
    ------
    HarmonicFaceError
        Neither circle nor mask, or both; a mask that is no disc; a ball of less than 8 pixels of radius, or beyond the
        picture; a photograph without a highlight, with a broad one, or with two.

    Examples
    --------
    >>> photo = np.zeros((101, 101))
    >>> photo[50, 65] = 1.0  # 15 of 50 pixels to the right of the middle
    >>> mirror_ball_lights(photo[None], circle=(50.5, 50.5, 50)).round(4)
    array([[0.5724, 0.    , 0.82  ]])
    """
    stack = _validate.finite(photographs, "photographs")
    if stack.ndim != 3 or stack.size == 0:
        raise HarmonicFaceError(f"photographs: expected shape (n, h, w), got {_validate.describe(stack)}")
    shape = (stack.shape[1], stack.shape[2])
    if (circle is None) == (mask is None):
        raise HarmonicFaceError(f"ball: expected a circle or a mask, got {'neither' if circle is None else 'both'}")
    middle = circle_of(mask, shape) if circle is None else checked_circle(circle, shape)
    across, up = _on_the_ball(middle, shape)
    inside = np.hypot(across, up) < INSIDE
    toward = np.sqrt(np.maximum(1 - across**2 - up**2, 0))
    reflected = np.stack([2 * toward * across, 2 * toward * up, 2 * toward**2 - 1], axis=-1)
    return np.stack([_direction(photo, inside, reflected, index) for index, photo in enumerate(stack)])


def circle_of(mask: ArrayLike | None, shape: tuple[int, int]) -> Circle:
    """Return (x, y, radius) of the disc that a mask shows: its centroid, and the circle of its area.

    Raises
    ------
    HarmonicFaceError
        Another shape, an empty mask, one that is no disc.

    Examples
    --------
    >>> rows, columns = np.mgrid[:40, :50] + 0.5
    >>> x, y, radius = circle_of(np.hypot(columns - 20, rows - 15) < 12, (40, 50))
    >>> round(x, 2), round(y, 2), round(radius)
    (20.0, 15.0, 12)
    """
    ball = _validate.mask(np.asarray(mask), "mask", shape)
    rows, columns = np.nonzero(ball)
    found = float(columns.mean() + 0.5), float(rows.mean() + 0.5), float(np.sqrt(ball.sum() / np.pi))
    disc = np.hypot(*_on_the_ball(found, shape)) < 1
    share = (disc & ball).sum() / (disc | ball).sum()
    if share < ROUND:
        raise HarmonicFaceError(f"mask: expected the disc of a ball, got one that shares {share:.0%} with its circle")
    return checked_circle(found, shape)


def checked_circle(circle: Sequence[float], shape: tuple[int, int]) -> Circle:
    """Return (x, y, radius) of a ball in a picture.

    Raises
    ------
    HarmonicFaceError
        Anything but three finite numbers, a small radius, a ball that is not within the picture.
    """
    numbers = _validate.finite(circle, "ball")
    if numbers.shape != (3,):
        raise HarmonicFaceError(f"ball: expected (x, y, radius) in pixels, got {_validate.describe(numbers)}")
    x, y, radius = (float(number) for number in numbers)
    if radius < SMALLEST:
        raise HarmonicFaceError(f"ball: expected a radius of at least {SMALLEST:g} pixels, got {radius:.4g}")
    if min(x - radius, y - radius) < -1 or x + radius > shape[1] + 1 or y + radius > shape[0] + 1:
        raise HarmonicFaceError(
            f"ball: expected it within the {shape[1]} x {shape[0]} pixels of the picture,"
            f" got its middle at ({x:.4g}, {y:.4g}) and a radius of {radius:.4g}"
        )
    return x, y, radius


def _on_the_ball(circle: Circle, shape: tuple[int, int]) -> tuple[Floats, Floats]:
    """Return x to the right and y up of each pixel, in units of the radius."""
    x, y, radius = circle
    rows, columns = np.mgrid[: shape[0], : shape[1]] + 0.5
    return (columns - x) / radius, (y - rows) / radius


def _direction(photo: Floats, inside: NDArray[np.bool_], reflected: Floats, index: int) -> NDArray[np.float64]:
    """Return the mean direction that the brightest spot reflects."""
    usual, bright = float(np.median(photo[inside])), float(photo[inside].max())
    if bright <= CONTRAST * usual or bright == 0:
        raise HarmonicFaceError(
            f"ball: expected a lamp's highlight in photograph {index}, got {bright:.3g} beside {usual:.3g} elsewhere"
        )
    light = np.where(inside, photo - usual, 0.0)
    parts, count = label(light > (bright - usual) / 2, np.ones((3, 3)))
    sums = np.bincount(parts.ravel(), light.ravel())[1:]
    order = np.argsort(sums)[::-1]
    if count > 1 and sums[order[1]] > RIVAL * sums[order[0]]:
        raise HarmonicFaceError(f"ball: expected one highlight in photograph {index}, got {count} of like brightness")
    spot = parts == order[0] + 1
    if spot.sum() > BROADEST * inside.sum():
        raise HarmonicFaceError(
            f"ball: expected a small highlight in photograph {index}, got one on {spot.sum() / inside.sum():.0%} of it"
        )
    spot = binary_dilation(spot, np.ones((3, 3)), BORDER) & inside  # with the pixels that it fills in part
    mean = light[spot] @ reflected[spot]
    return np.asarray(mean / np.linalg.norm(mean))
