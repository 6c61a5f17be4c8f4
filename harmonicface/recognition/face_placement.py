"""Face placement: where a face is in a photograph that was cropped in an unknown way, without landmarks."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import binary_erosion

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.lights import directional
from harmonicface.people.prior import FacePrior
from harmonicface.stereo.motion import Matrix, then

Picture = NDArray[np.float32]

SMALLEST = 16  # pixels a side
SCALES = np.geomspace(0.75, 4 / 3, 17)  # of the photograph's height over the prior's, 3.7 % apart
ROWS = 48  # at which patterns are compared
USUAL_SCALE, USUAL_SHIFT = 0.15, 0.1  # deviations from the frame as it is: natural logarithm, share of the height
CAUTION = 0.1  # correlation that a deviation of one costs
PADDING = 0.25  # of the height: how far the face may reach beyond the picture
FINE, WIDER = 2.0 / 96, 2.0  # of the height; the second Gaussian over the first
NEIGHBOURHOOD = 3.0  # over the first
DARK, FAINT = 0.03, 0.1
RIM = 6 / 96  # of the height: the outline of a head belongs to what is behind it
FACES = 12  # drawn from the prior; under each light their patterns are averaged
LAMPS = ((0, 0, 1), (-0.8, 0, 0.6), (0.8, 0, 0.6), (0, 0.8, 0.6), (0, -0.5, 0.8), (-0.6, 0.6, 0.6), (0.6, 0.6, 0.6))
AMBIENT = 0.5  # of the constant harmonic, beside a lamp of strength 1
ROWS_OF_LIGHT = 4  # principal directions of those averages: what light does to the pattern
LEAST_ENERGY = 0.3  # of the photograph's mean: windows that hold little do not correlate by chance


@dataclass(frozen=True, eq=False)
class FacePlacement:
    """Where the prior's face is in a photograph.

    Parameters
    ----------
    motion
        (2, 3), from pixel coordinates (x to the right, y down) of the prior to those of the photograph: a scale and a
        shift.
    correlation
        Of the photograph's pattern there with those of the prior's faces under the light that suits best, 0 to 1.
    """

    motion: Matrix
    correlation: float


def place_face(photo: ArrayLike, prior: FacePrior) -> FacePlacement:
    """Find a face by scale and shift, by the pattern that all faces share: brows, eyes, nostrils, mouth.

    The pattern is the detail of the logarithm over its local energy. What light still does to it is eliminated: the
    patterns of the prior's faces under seven lamps are spanned by four rows, and a window counts by its share in that
    span. It is searched for at 17 scales and all shifts; the more unusual a crop, the better it has to fit.

    Of 30 synthetic people under natural light, cropped as the prior, 0.7 and 1.0 pixels of 96 rows were missed across
    and up, root mean square, and 2.7 % of the scale. Photographs of one person of Yale B agree to a pixel.

    Parameters
    ----------
    photo
        (h, w) linear intensities of a face, cropped about as the prior's: 0.75 to 1.33 times as large.
    prior
        Whose mean face is searched for.

    Raises
    ------
    HarmonicFaceError
        Another shape, fewer than 16 pixels a side, NaN, a photograph without contrast.

    Examples
    --------
    >>> from harmonicface.people.prior import synthetic_prior
    >>> from harmonicface.people.synthetic import synthetic_person
    >>> face = synthetic_person(5, (192, 168)).albedo
    >>> place_face(face, synthetic_prior((48, 42), 20)).motion.shape
    (2, 3)
    """
    pixels = checked_photo(photo)
    templates, inside = _templates(prior)
    rows, columns = inside.shape
    best, found = -np.inf, FacePlacement(np.eye(2, 3), 0.0)
    for scale in SCALES:
        height, width = round(rows * scale), round(rows * scale * pixels.shape[1] / pixels.shape[0])
        pattern = _pattern(resized(pixels, (height, width)), rows)
        correlation, top, left = _correlations(pattern, templates, inside)
        right, down = left + (columns - width) / 2, top + (rows - height) / 2
        unusual = (np.log(scale) / USUAL_SCALE) ** 2 + (np.hypot(right, down) / (USUAL_SHIFT * rows)) ** 2
        score = correlation - CAUTION * unusual
        row, column = np.unravel_index(score.argmax(), score.shape)
        if score[row, column] > best:
            best = float(score[row, column])
            growth = np.array([pixels.shape[1] / width, pixels.shape[0] / height])
            corner = (np.array([left[0, column], top[row, 0]]) + 0.5) * growth - 0.5
            found = FacePlacement(np.column_stack([np.diag(growth), corner]), float(correlation[row, column]))
    shrink = np.array([columns / prior.shape[1], rows / prior.shape[0]])  # from the prior's pixels to those compared
    to_compared = np.column_stack([np.diag(shrink), (shrink - 1) / 2])
    return FacePlacement(then(to_compared, found.motion), found.correlation)


def checked_photo(photo: ArrayLike) -> Picture:
    """Return a grey photograph over its largest magnitude.

    Raises
    ------
    HarmonicFaceError
        Another shape, fewer than 16 pixels a side, NaN, no contrast.
    """
    pixels = _validate.finite(photo, "photo")
    if pixels.ndim != 2 or min(pixels.shape) < SMALLEST:
        expected = f"shape (h, w), at least {SMALLEST} x {SMALLEST}"
        raise HarmonicFaceError(f"photo: expected {expected}, got {_validate.describe(pixels)}")
    if pixels.min() == pixels.max():
        raise HarmonicFaceError(f"photo: expected contrast, got {pixels.flat[0]:.4g} everywhere")
    return np.asarray(pixels / np.abs(pixels).max(), np.float32)


def _correlations(pattern: Picture, templates: Picture, inside: Picture) -> tuple[Picture, Picture, Picture]:
    """Return how much of each window is in the span of the templates, and its first rows and columns."""
    pad = round(PADDING * len(inside))
    around = cv2.copyMakeBorder(pattern, pad, pad, pad, pad, cv2.BORDER_CONSTANT, value=0)
    squares = sum(np.square(cv2.matchTemplate(around, template, cv2.TM_CCORR)) for template in templates)
    energy = np.maximum(cv2.matchTemplate(around * around, inside, cv2.TM_CCORR), 0)
    usual = LEAST_ENERGY * float((pattern * pattern).mean()) * float(inside.sum())
    correlation = np.sqrt(squares / (energy + np.float32(usual + 1e-6)))
    top = np.arange(correlation.shape[0], dtype=np.float32)[:, None] - pad
    left = np.arange(correlation.shape[1], dtype=np.float32)[None] - pad
    return correlation, top, left


@lru_cache(maxsize=2)
def _templates(prior: FacePrior) -> tuple[Picture, Picture]:
    """Return orthonormal rows (4, h, w) that span the pattern that faces share under any light, and where faces are."""
    rng = np.random.default_rng(0)
    rows = min(ROWS, prior.shape[0])
    size = (rows, round(rows * prior.shape[1] / prior.shape[0]))
    lamps = np.stack([directional(lamp).coefficients(2) for lamp in LAMPS])
    lamps[:, 0] += AMBIENT
    sums = np.zeros((len(lamps), *size), np.float32)
    for _ in range(FACES):
        images = prior.images(rng.standard_normal(len(prior.modes)))
        for total, light in zip(sums, lamps, strict=True):
            face = np.zeros(prior.shape, np.float32)
            face[prior.mask] = np.maximum(light @ images, 0)
            total += _pattern(resized(filled(face, prior.mask), size), rows)
    inner = binary_erosion(prior.mask, iterations=max(1, round(RIM * prior.shape[0])))
    inside = (resized(inner.astype(np.float32), size) > 0.5).astype(np.float32)
    if not inside.any():
        raise HarmonicFaceError(f"prior: expected a face with an inside, got a mask of {prior.mask.sum()} pixels")
    inner_sums = sums * inside
    inner_sums -= inside * (inner_sums.sum(axis=(1, 2)) / inside.sum())[:, None, None]
    _, _, spans = np.linalg.svd(inner_sums.reshape(len(sums), -1), full_matrices=False)
    return np.ascontiguousarray(spans[:ROWS_OF_LIGHT].reshape(-1, *size), np.float32), inside


def filled(picture: Picture, mask: NDArray[np.bool_]) -> Picture:
    """Return a picture (h, w) or (h, w, k) with what is outside its mask filled from the nearest pixels inside."""
    holes = np.asarray(~mask, np.uint8)
    if not holes.any():
        return picture
    _, labels = cv2.distanceTransformWithLabels(holes, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL)
    nearest = np.zeros(int(labels.max()) + 1, np.intp)
    nearest[labels[mask]] = np.flatnonzero(mask)
    flat = picture.reshape(mask.size, -1)
    return np.asarray(flat[nearest[labels.ravel()]].reshape(picture.shape))


def _pattern(picture: Picture, rows: int) -> Picture:
    """Return fine detail of the logarithm over its local energy; sizes follow the rows of the template."""
    fine = max(FINE * rows, 0.5)
    bright = float(np.percentile(picture, 99)) or float(picture.max()) or 1.0
    log = np.log(np.maximum(picture, 0) / np.float32(bright) + np.float32(DARK))
    detail = _blurred(log, fine) - _blurred(log, WIDER * fine)
    energy = np.sqrt(_blurred(detail * detail, NEIGHBOURHOOD * fine))
    return np.asarray(np.tanh(detail / (energy + np.float32(FAINT * energy.mean() + 1e-6))), np.float32)


def _blurred(picture: Picture, deviation: float) -> Picture:
    return np.asarray(cv2.GaussianBlur(picture, (0, 0), deviation, borderType=cv2.BORDER_REPLICATE))


def resized(picture: Picture, size: tuple[int, int]) -> Picture:
    """Return a picture at another size, averaged where it gets smaller."""
    smaller = size[0] < picture.shape[0]
    how = cv2.INTER_AREA if smaller else cv2.INTER_LINEAR
    return np.asarray(cv2.resize(picture, size[::-1], interpolation=how))
