"""Detection: where the faces are in an ordinary photograph, and the crop of one as recognizers want it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray
from skimage.data import lbp_frontal_face_cascade_filename
from skimage.feature import Cascade

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.io.colour import luminance
from harmonicface.people.crop import FRAME
from harmonicface.surfaces.view import checked_shape

LEAST_SIDE = 24  # pixels of the cascade's window, and of a photograph
SMALLEST = 1 / 4  # of the photograph's shorter side
WORKING = 48  # pixels of the smallest box where it is looked for; the cascade steps by a 24th of a box in any size
GROWTH = 1.1  # from one size of boxes to the next
SAME = 0.4  # intersection over union of boxes that are one face
LEAST_SUPPORT = 6  # windows; fewer are often clutter
AROUND = 0.3  # of the longer side: how much darkness goes around a photograph, for faces that fill it
LOCAL = 0.08  # of the shorter side: light changes more slowly than this, faces do not
DARK = 0.01  # of the bright parts, below which a logarithm shows noise
FAINT = 0.2  # of the mean contrast

# The middle of a box and its side, against where everybody's eyes and mouth are: the median over ICT heads and built-in
# people under lamps up to 50 degrees from the camera. It scatters by 2 % of the side across and up, by 6 % in size.
SIDE = 180.0  # mm
MIDDLE = -20.4  # mm, above the middle between the eyeballs


@dataclass(frozen=True)
class FaceBox:
    """A square around a face, from above the brows to the chin and from ear to ear.

    In the millimetres of the built-in people (`FRAME`: the eyes at (-31.3, -0.9) and (31.3, -0.9), the lips at
    (0, -69.6)) its side is 180 mm, and its middle is at (0, -20.4).

    Parameters
    ----------
    left, top
        Of its upper left corner, in pixels from that of the photograph; both may be outside it.
    side
        In pixels.
    support
        How many windows of the cascade saw the face: 6 to 150, the more the clearer it is.
    """

    left: float
    top: float
    side: float
    support: int


def detect_faces(photo: ArrayLike, smallest: float | None = None) -> list[FaceBox]:
    """Find faces that look at the camera, best first.

    The cascade of local binary patterns that comes with scikit-image (after Viola & Jones, Rapid object detection using
    a boosted cascade of simple features, 2001, and Liao et al., Learning multi-scale block local binary patterns for
    face recognition, 2007) looks at the photograph, at a version of it in which the local contrast is everywhere the
    same, and at the mirror images of both, all in a frame of darkness, for faces that fill the photograph. Windows that
    overlap are one face.

    Parameters
    ----------
    photo
        (h, w) or (h, w, 3) linear intensities in any unit, at least 24 pixels a side.
    smallest
        Least side of a box in pixels of the photograph, at least 1; by default a quarter of the shorter side. The time
        grows with the inverse of its square.

    Returns
    -------
    list of FaceBox
        Those with most support first; empty where there is no face.

    Raises
    ------
    HarmonicFaceError
        Another shape, too few pixels, NaN or infinity, a size that is no number of at least 1.

    Examples
    --------
    >>> detect_faces(np.ones((48, 64)))
    []
    """
    pixels = _grey(photo)
    least = SMALLEST * min(pixels.shape) if smallest is None else _validate.positive(smallest, "smallest")
    if least < 1:
        raise HarmonicFaceError(f"smallest: expected at least 1 pixel, got {smallest}")
    if least > min(pixels.shape):
        return []
    scale = WORKING / least
    rows, columns = (max(LEAST_SIDE, round(scale * side)) for side in pixels.shape)
    shrinks = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    small = cv2.resize(pixels, (columns, rows), interpolation=shrinks)
    edge = round(AROUND * max(small.shape))
    boxes = _found(np.pad(small, edge))
    return [
        FaceBox((box.left - edge) / scale, (box.top - edge) / scale, box.side / scale, box.support) for box in boxes
    ]


def crop_face(photo: ArrayLike, box: FaceBox, size: int | tuple[int, int] = 64) -> NDArray[np.float32]:
    """Return a face as the built-in people are seen: the eyes and the mouth at the same places of every picture.

    The picture shows `FRAME`, 126 x 144 mm with the eyes 35 mm below its top, or more of the surroundings where its
    proportions are others, as `View.fit` does.

    Parameters
    ----------
    photo
        (h, w) or (h, w, 3) linear intensities.
    box
        Where the face is.
    size
        Height and width of the picture in pixels; one number means a square.

    Returns
    -------
    array
        float32 of this size; what is beyond the photograph repeats its border.

    Raises
    ------
    HarmonicFaceError
        Another shape, NaN or infinity, a box without extent or beside the photograph, a size of another form.

    Examples
    --------
    >>> crop_face(np.eye(96), FaceBox(8, 8, 80, 9), (48, 42)).shape
    (48, 42)
    """
    pixels = np.asarray(_validate.image(photo, "photo"), np.float32)
    height, width = checked_shape(size)
    unit = _validate.positive(box.side, "side") / SIDE  # pixels a millimetre
    left, bottom, right, top = FRAME
    step = unit * max((right - left) / width, (top - bottom) / height)  # pixels of the photograph a pixel
    x = box.left + box.side / 2
    y = box.top + box.side / 2 + unit * (MIDDLE - (bottom + top) / 2)
    if not (0 <= x <= pixels.shape[1] and 0 <= y <= pixels.shape[0]):
        raise HarmonicFaceError(f"box: expected a face inside the photograph of {pixels.shape[:2]}, got {box}")
    finer = max(1, math.ceil(step))  # squares of pixels are averaged, so that detail does not alias
    rows, columns = height * finer, width * finer
    step /= finer
    # the centre of the first pixel is at 0 here, and at one half in a box
    motion = np.array([[step, 0, x - step * (columns - 1) / 2 - 0.5], [0, step, y - step * (rows - 1) / 2 - 0.5]])
    seen = cv2.warpAffine(
        pixels,
        motion,
        (columns, rows),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    )
    return np.asarray(cv2.resize(seen, (width, height), interpolation=cv2.INTER_AREA))


def _found(photo: NDArray[np.float32]) -> list[FaceBox]:
    """Return the faces of a photograph at the working size."""
    bright = float(np.percentile(photo, 99)) or float(photo.max())
    if photo.min() == photo.max() or bright <= 0:
        return []
    relative = np.clip(photo / bright, 0, 1)
    windows = []
    for shown in (np.sqrt(relative), _even(relative)):
        windows.append(_windows(shown))
        mirrored = _windows(shown[:, ::-1])
        mirrored[:, 0] = shown.shape[1] - mirrored[:, 0] - mirrored[:, 2]
        windows.append(mirrored)
    return _merged(np.concatenate(windows))


def _even(relative: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return a photograph with the same local contrast everywhere, about a half."""
    log = np.log(relative + np.float32(DARK))
    scale = LOCAL * min(log.shape)
    detail = cv2.GaussianBlur(log, (0, 0), 1) - cv2.GaussianBlur(log, (0, 0), 2 * scale)
    contrast = np.sqrt(cv2.GaussianBlur(detail * detail, (0, 0), 3 * scale))
    return np.asarray(0.5 + 0.5 * np.tanh(detail / (contrast + FAINT * contrast.mean() + 1e-6)), np.float32)


def _windows(shown: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return left, top and side of every window that passes the cascade, (n, 3)."""
    side = min(shown.shape)
    found = _cascade().detect_multi_scale(
        np.ascontiguousarray(shown),
        scale_factor=GROWTH,
        step_ratio=1,
        min_size=(WORKING, WORKING),
        max_size=(side, side),
        min_neighbor_number=0,
        intersection_score_threshold=2,  # none are merged
    )
    return np.array([(one["c"], one["r"], one["width"]) for one in found], float).reshape(-1, 3)


def _merged(windows: NDArray[np.float64]) -> list[FaceBox]:
    """Return the means of windows that overlap, beginning where most of them do."""
    left, top, side = windows.T
    across, down = (
        np.maximum(0, np.minimum.outer(start + side, start + side) - np.maximum.outer(start, start))
        for start in (left, top)
    )
    shared = across * down
    same = shared > SAME * (np.add.outer(side**2, side**2) - shared)
    remaining = np.ones(len(windows), np.bool_)
    boxes = []
    while remaining.any():
        counts = (same & remaining).sum(axis=1) * remaining
        members = same[counts.argmax()] & remaining
        remaining &= ~members
        if members.sum() < LEAST_SUPPORT:
            break
        x, y, length = (float(value) for value in windows[members].mean(axis=0))
        boxes.append(FaceBox(x, y, length, int(members.sum())))
    return boxes


@cache
def _cascade() -> Cascade:
    return Cascade(lbp_frontal_face_cascade_filename())


def _grey(photo: ArrayLike) -> NDArray[np.float32]:
    pixels: Floats = _validate.image(photo, "photo")
    if min(pixels.shape[:2]) < LEAST_SIDE:
        raise HarmonicFaceError(f"photo: expected at least {LEAST_SIDE} pixels a side, got {pixels.shape[:2]}")
    return np.asarray(pixels if pixels.ndim == 2 else luminance(pixels), np.float32)
