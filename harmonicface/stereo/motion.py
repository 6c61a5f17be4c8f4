"""Motion: where the pixels of one photograph are in another, and how to look at it from there."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError

Matrix = NDArray[np.float64]
STILL: Matrix = np.eye(2, 3)


def resample(image: ArrayLike, motion: ArrayLike) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    r"""Return an image as seen from where a motion leads, and which pixels of it the image shows.

    .. math:: I'(x, y) = I(M (x, y, 1)^T)

    by OpenCV's cubic interpolation, clipped to the range of the image, which cubics overshoot. It is exact at whole
    and half pixels; in between a ramp comes out up to 0.05 pixels off, at a tenth of the time of splines. Beyond the
    image's border its nearest pixel is repeated; there `known` is false.

    Parameters
    ----------
    image
        (h, w) finite numbers.
    motion
        (2, 3) matrix M from pixel coordinates (x to the right, y down, pixel centres at whole numbers) of the result
        to those of the image.

    Returns
    -------
    image
        (h, w) float32.
    known
        (h, w) booleans.

    Raises
    ------
    HarmonicFaceError
        Another shape, NaN or infinity, a matrix without an inverse.

    Examples
    --------
    >>> seen, known = resample([[1.0, 2.0, 3.0, 4.0]], [[1, 0, 1], [0, 1, 0]])
    >>> seen, known
    (array([[2., 3., 4., 4.]], dtype=float32), array([[ True,  True,  True, False]]))
    """
    pixels = _validate.finite(image, "image")
    if pixels.ndim != 2 or pixels.size == 0:
        raise HarmonicFaceError(f"image: expected shape (h, w), got {_validate.describe(pixels)}")
    matrix = checked_motion(motion)
    return seen_through(np.asarray(pixels, np.float32), matrix), _inside(matrix, pixels.shape)


def seen_through(pixels: NDArray[np.float32], motion: Matrix) -> NDArray[np.float32]:
    """Return the same picture for an image and a motion that are known to be good."""
    seen = cv2.warpAffine(
        pixels,
        motion,
        (pixels.shape[1], pixels.shape[0]),
        flags=cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    )
    return np.asarray(np.clip(seen, pixels.min(), pixels.max(), out=seen))


def checked_motion(motion: ArrayLike) -> Matrix:
    """Return a motion as a (2, 3) float64 matrix that has an inverse.

    Raises
    ------
    HarmonicFaceError
        Another shape, NaN or infinity, no inverse.
    """
    matrix = _validate.finite(motion, "motion").astype(np.float64)
    if matrix.shape != (2, 3):
        raise HarmonicFaceError(f"motion: expected a matrix of shape (2, 3), got {_validate.describe(matrix)}")
    if abs(np.linalg.det(matrix[:, :2])) < 1e-6:
        raise HarmonicFaceError(f"motion: expected one that can be undone, got {matrix.round(4).tolist()}")
    return matrix


def then(first: Matrix, second: Matrix) -> Matrix:
    """Return the motion that applies the first and then the second."""
    return np.asarray((np.vstack([second, [0, 0, 1]]) @ np.vstack([first, [0, 0, 1]]))[:2])


def undone(motion: Matrix) -> Matrix:
    """Return the motion back."""
    return np.asarray(np.linalg.inv(np.vstack([motion, [0, 0, 1]]))[:2])


def displacement(motion: Matrix, shape: tuple[int, ...]) -> float:
    """Return how far a motion moves the corners of an image in the mean, in pixels."""
    height, width = shape[-2:]
    corners = np.array([[x, y, 1.0] for x in (0, width - 1) for y in (0, height - 1)])
    return float(np.linalg.norm(corners @ motion.T - corners[:, :2], axis=1).mean())


def _inside(motion: Matrix, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Return where a motion stays within half a pixel of the centres of an image's pixels."""
    height, width = shape
    rows, columns = np.arange(height)[:, None], np.arange(width)[None]
    x, y = (row[0] * columns + row[1] * rows + row[2] for row in motion)
    return np.asarray((x >= -0.5) & (x <= width - 0.5) & (y >= -0.5) & (y <= height - 0.5))
