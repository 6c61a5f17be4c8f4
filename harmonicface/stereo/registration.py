"""Registration: undo how a person moved between photographs that were taken under different lights."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import gaussian_filter
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.motion import STILL, Matrix, displacement, resample, then, undone

SMALLEST = 16  # pixels a side, below which there is no detail to register by
DARK = 0.05  # of a photograph's bright parts: what is darker holds noise, which a logarithm would blow up
BRIGHT = 99  # percentile
COARSE, FINE = 1.5, 0.7  # pixels: detail that survives a change of light, for the first guess and for the last digit
OCTAVE = 1.6  # wider Gaussian over narrower one: nearly the Laplacian of a Gaussian (Marr & Hildreth 1980)
ROUNDS = 2  # a third one changes hundredths of a pixel
STEPS = cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-5
LEAST = 0.5  # pixels: what shading alone, moving with the light, can look like
LEAST_CORRELATION = 0.1  # unrelated pictures reach 0.03, faces lit from 65 degrees on all sides 0.3


@dataclass(frozen=True, eq=False)
class Registration:
    """Photographs of one person, registered to one of them.

    Parameters
    ----------
    photographs
        (n, h, w) float32, each resampled so that its pixels show the same points of the person as the reference's.
    motions
        (n, 2, 3) float64: `motions[i]` takes pixel coordinates (x to the right, y down) of the reference to those
        of photograph i, a rotation and a shift. The reference's own is the identity.
    known
        (n, h, w) booleans, false where a photograph does not reach and its border was repeated.
    reference
        The index of the photograph that stayed as it was.
    correlations
        (n,) how well the fine detail of each photograph agrees with that of all others, at most 1.
    """

    photographs: NDArray[np.float32]
    motions: Matrix
    known: NDArray[np.bool_]
    reference: int
    correlations: NDArray[np.float64]


def register(photographs: ArrayLike, reference: int | None = None, *, least: float = LEAST) -> Registration:
    """Register photographs of a still person under different lights to one of them, to a fraction of a pixel.

    Light changes shading, and what shading does to an image moves as the light moves; fine detail of the skin stays.
    So what is compared is the logarithm of the photographs, in which brightness is additive, between two Gaussians
    of a fine scale. Each photograph is first registered to the one it resembles most, along a maximum spanning tree
    of peak correlations, so that lights far from each other are never compared directly: the peak of the
    cross-correlation gives the shift, `cv2.findTransformECC` (Evangelidis & Psarakis 2008) rotation and fractions.
    Then each one is registered twice at a finer scale to the mean of all others, which no single light biases. What
    then seems to move less than `least` is left as it is: on smooth skin without texture the light alone does as much.

    Parameters
    ----------
    photographs
        (n, h, w) linear grey intensities of any scale, n of at least 2, h and w of at least 16 pixels.
    reference
        Index of the photograph that stays as it is. By default the one among the others: its mean distance to them
        is the shortest, so that a single outlier is moved rather than everybody else.
    least
        Pixels, at least 0: motions that displace the corners by no more than that in the mean count as none.

    Returns
    -------
    Registration

    Raises
    ------
    HarmonicFaceError
        Another shape, fewer than two photographs, NaN, negative intensities, a photograph without contrast, a
        reference that is none of them, a negative `least`, a photograph that shows something else than the others.

    Examples
    --------
    >>> from scipy.ndimage import gaussian_filter
    >>> skin = gaussian_filter(np.random.default_rng(0).uniform(0.2, 1, (64, 64)), 1)
    >>> found = register([skin, np.roll(skin, (1, 3), axis=(0, 1)), skin])
    >>> (found.reference, (found.motions[1].round(1) + 0.0).tolist())
    (0, [[1.0, 0.0, 3.0], [0.0, 1.0, 1.0]])
    """
    stack = _checked(photographs)
    count = len(stack)
    dead_zone = 0.0 if least == 0 else _validate.positive(least, "least")
    if reference is not None and not 0 <= _validate.at_least(reference, 0, "reference") < count:
        raise HarmonicFaceError(f"reference: expected an index below {count}, got {reference}")
    motions = _along_tree([_detail(photo, COARSE) for photo in stack])
    motions, correlations = _to_the_others([_detail(photo, FINE) for photo in stack], motions)
    for index, correlation in enumerate(correlations):
        if not correlation > LEAST_CORRELATION:
            raise HarmonicFaceError(
                f"photographs: expected one person, holding nearly still, got photograph {index}, whose detail"
                f" correlates {correlation:.2f} with that of the others (at least {LEAST_CORRELATION:g})"
            )
    if reference is None:
        reference = _central(motions, stack.shape)
    back = undone(motions[reference])
    motions = [then(back, motion) for motion in motions]
    motions = [STILL if displacement(motion, stack.shape) <= dead_zone else motion for motion in motions]
    motions[reference] = STILL
    seen = [resample(photo, motion) for photo, motion in zip(stack, motions, strict=True)]
    return Registration(
        np.stack([photo for photo, _ in seen]),
        np.stack(motions),
        np.stack([known for _, known in seen]),
        int(reference),
        correlations,
    )


def _detail(photo: Floats, scale: float) -> NDArray[np.float32]:
    """Return what of the logarithm of a photograph lies between two Gaussians, at variance 1."""
    bright = np.percentile(photo, BRIGHT) or photo.max()
    log = np.log(photo / bright + DARK)
    detail = gaussian_filter(log, scale) - gaussian_filter(log, OCTAVE * scale)
    return np.asarray(detail / detail.std(), np.float32)


def _along_tree(details: list[NDArray[np.float32]]) -> list[Matrix]:
    """Register each picture to its most similar neighbour in a spanning tree, and so to the tree's root."""
    count = len(details)
    similarity, shifts = np.zeros((count, count)), np.zeros((count, count, 2))
    spectra = [np.fft.rfft2(detail) for detail in details]
    for i in range(count):
        for j in range(i):
            shifts[i, j], peak = _peak(spectra[i], spectra[j], details[i].shape)
            shifts[j, i], similarity[i, j], similarity[j, i] = -shifts[i, j], peak, peak
    tree = minimum_spanning_tree(1.5 - np.minimum(similarity, 1))  # a weight of 0 would be no edge
    root = int(similarity.sum(axis=0).argmax())
    order, parents = breadth_first_order(tree, root, directed=False)
    motions = [STILL] * count
    for index in order[1:]:
        parent = parents[index]
        start = np.column_stack([np.eye(2), shifts[index, parent]])
        step, _ = _refined(details[parent], details[index], start)
        motions[index] = then(motions[parent], step)
    return motions


def _to_the_others(
    details: list[NDArray[np.float32]], motions: list[Matrix]
) -> tuple[list[Matrix], NDArray[np.float64]]:
    """Register each picture to the mean of all others; return how well it then agrees with them."""
    correlations = np.zeros(len(details))
    for _ in range(ROUNDS):
        seen = np.stack([resample(detail, motion)[0] for detail, motion in zip(details, motions, strict=True)])
        total = seen.sum(axis=0)
        refined = [
            _refined(total - own, detail, motion) for own, detail, motion in zip(seen, details, motions, strict=True)
        ]
        motions, correlations = [motion for motion, _ in refined], np.array([found for _, found in refined])
    return motions, correlations


def _peak(
    first: NDArray[np.complex128], second: NDArray[np.complex128], shape: tuple[int, ...]
) -> tuple[Floats, float]:
    """Return the shift (x, y) of the first picture against the second where they correlate most, and how much."""
    correlation = np.fft.irfft2(first * second.conj(), shape)
    peak = np.unravel_index(correlation.argmax(), shape)
    down, right = (index if index <= size // 2 else index - size for index, size in zip(peak, shape, strict=True))
    return np.array([right, down], float), float(correlation[peak]) / correlation.size


def _refined(template: NDArray[np.float32], picture: NDArray[np.float32], start: Matrix) -> tuple[Matrix, float]:
    """Return the rotation and shift by which a picture agrees best with a template, and their correlation."""
    try:
        correlation, motion = cv2.findTransformECC(
            template, picture, start.astype(np.float32), cv2.MOTION_EUCLIDEAN, STEPS, None, 1
        )
    except cv2.error:  # it found no overlap or no way up: the start is as good as it gets
        seen, known = resample(picture, start)
        correlation, motion = _correlation(seen[known], template[known]), start
    return np.asarray(motion, np.float64), float(correlation)


def _correlation(first: Floats, second: Floats) -> float:
    """Return the normalized correlation, 0 where there is nothing to correlate."""
    if first.size < 2 or first.std() == 0 or second.std() == 0:
        return 0.0
    return float(np.corrcoef(first, second)[0, 1])


def _central(motions: list[Matrix], shape: tuple[int, ...]) -> int:
    """Return the index of the photograph with the shortest mean distance to the others."""
    distances = [np.mean([displacement(then(undone(own), other), shape) for other in motions]) for own in motions]
    return int(np.argmin(distances))


def _checked(photographs: ArrayLike) -> Floats:
    stack = _validate.finite(photographs, "photographs")
    if stack.ndim != 3 or stack.size == 0:
        raise HarmonicFaceError(f"photographs: expected shape (n, h, w), got {_validate.describe(stack)}")
    if len(stack) < 2:
        raise HarmonicFaceError(f"photographs: expected at least 2 to register to each other, got {len(stack)}")
    if min(stack.shape[1:]) < SMALLEST:
        raise HarmonicFaceError(
            f"photographs: expected at least {SMALLEST} pixels a side, got {stack.shape[1]} x {stack.shape[2]}"
        )
    if stack.min() < 0:
        raise HarmonicFaceError(f"photographs: expected intensities of at least 0, got {stack.min():.4g}")
    for index, photo in enumerate(stack):
        if photo.min() == photo.max():
            raise HarmonicFaceError(
                f"photographs: expected contrast, got photograph {index} with {photo.max():.4g} everywhere"
            )
    return stack.astype(np.float64)
