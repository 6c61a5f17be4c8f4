"""Local patterns: what of a photograph the light hardly changes, compared block by block at small shifts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.blocks import REACH, correlations, known_blocks, unit_blocks
from harmonicface.recognition.grid import NEIGHBOURHOOD, OnGrid, blurred, on_grid

SCALES = (0.35, 0.5, 0.7)  # standard deviations in pixels of the grid
WIDER = 1.5  # the second Gaussian over the first
DARK = 0.008  # of the bright parts: about two grey levels of 255, below which a logarithm shows noise
BRIGHT = 99  # percentile
FAINT = 0.1  # of the mean energy is added, so that smooth regions stay quiet
SHARPNESS = 0.01  # of correlations: by how much they differ by chance from shift to shift
FIRM = 0.25  # what the blocks count for without their freedom
SURROUND = 2.0  # standard deviation in pixels of what a pattern stands out from
LEAST_ENERGY = 1e-4  # in logarithms: a hundredth of a percent of contrast, between rounding and a grey level

Pattern = NDArray[np.float32]


def patterns(photo: ArrayLike, mask: ArrayLike | None = None) -> Pattern:
    r"""Return the local patterns of a photograph: fine detail of its logarithm over the local energy of such detail.

    At a scale s, with Gaussians G and the photograph I over its bright parts,

    .. math:: x = \log(I + c), \quad D = G_s x - G_{1.5 s} x, \quad e = \sqrt{G_3 D^2}, \quad
        t = \tanh(D / (e + e_0)), \quad f = t - G_2 t

    Light multiplies a matte surface's albedo by something smooth, which the logarithm makes a sum and the difference
    of Gaussians takes away; the energy takes away how strongly the detail shows (as Tan & Triggs, Enhanced local
    texture feature sets for face recognition under difficult lighting conditions, 2010, at finer scales). The last
    step whitens: what neighbours share says least about a person, and most about shadows, noise and compression.

    Parameters
    ----------
    photo
        (h, w) linear intensities in any unit, at least 24 pixels a side.
    mask
        (h, w) booleans, false where the photograph is bad.

    Returns
    -------
    array
        (3, h', w') float32 from -1 to 1 at three scales, on the photograph's `grid`; 0 where nothing is known:
        outside the mask, in constant regions, everywhere in a dark or burnt-out photograph.

    Raises
    ------
    HarmonicFaceError
        Another shape, too few pixels, NaN or infinity, another mask.

    Examples
    --------
    >>> patterns(np.random.default_rng(0).uniform(0.1, 1, (192, 168))).shape
    (3, 96, 84)
    >>> float(np.abs(patterns(np.ones((32, 32)))).max())
    0.0
    """
    return patterns_on_grid(on_grid(photo, mask))


def patterns_on_grid(picture: OnGrid) -> Pattern:
    """Return the local patterns of a picture that is on its grid already, (3, h, w)."""
    light = np.maximum(picture.light, 0)
    bright = _bright(light if picture.seen is None else light[picture.seen])
    log = cv2.log(light / np.float32(bright) + np.float32(DARK))
    found = np.stack([_at_scale(log, scale, picture.seen) for scale in SCALES])
    return found if picture.seen is None else found * picture.seen


@dataclass(frozen=True, eq=False)
class Template:
    """What of a person's looks the light hardly changes; made by `Template.of`.

    Parameters
    ----------
    values
        (h, w) float16: the mean over her photographs of their patterns, summed over the scales. 2 bytes a pixel of
        the grid, 16 KiB for 96 x 84.
    """

    values: NDArray[np.float16]

    @classmethod
    def of(cls, found: Sequence[Pattern]) -> Template:
        """Take the mean of the patterns of one or more photographs, moved by whole pixels so that they agree.

        Parameters
        ----------
        found
            Patterns (3, h, w) of one shape; the first stays where it is.

        Raises
        ------
        HarmonicFaceError
            None, or unequal shapes.

        Examples
        --------
        >>> face = np.random.default_rng(0).uniform(0.1, 1, (48, 48))
        >>> template = Template.of([patterns(face), patterns(np.roll(face, 2, axis=1))])
        >>> found = similarity(patterns(np.roll(face, 1, axis=0)), [template])
        >>> found.shifts.tolist()
        [[0, 1]]
        """
        if len(found) == 0:
            raise HarmonicFaceError("patterns: expected those of at least one photograph, got none")
        shapes = {np.shape(one) for one in found}
        if len(shapes) > 1:
            raise HarmonicFaceError(f"patterns: expected one shape, got {sorted(shapes)}")
        sums = [one.sum(axis=0) for one in found]
        moved = [sums[0], *(_moved(one, sums[0]) for one in sums[1:])]
        return cls(np.mean(moved, axis=0).astype(np.float16))

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the grid."""
        return self.values.shape[0], self.values.shape[1]

    @cached_property
    def blocks(self) -> NDArray[np.float32]:
        """The blocks at mean 0 and length 1, (b, 144); 0 where nothing is known."""
        return unit_blocks(self.values.astype(np.float32))

    @property
    def nbytes(self) -> int:
        """Memory of the template and its blocks."""
        return self.values.nbytes + self.blocks.nbytes


@dataclass(frozen=True, eq=False)
class Similarities:
    """How much a photograph resembles each of n people.

    Parameters
    ----------
    scores
        (n,) float32 up to 1: the mean correlation of blocks, over all common shifts together. Strangers reach 0.15 to
        0.25, because blocks are free by a pixel.
    shifts
        (n, 2) pixels of the grid to the right and down by which the photograph shows the person displaced.
    blocks
        Of how many blocks the photograph has a pattern: 0 for darkness, a wall, a burnt-out picture.
    """

    scores: NDArray[np.float32]
    shifts: NDArray[np.int64]
    blocks: int


def similarity(query: Pattern, templates: Sequence[Template], reach: int = REACH) -> Similarities:
    r"""Compare the patterns of a photograph with people's templates.

    Each of the 12 x 12 blocks is correlated at all shifts up to `reach`, and again free by one pixel about them; the
    means c and f over blocks are taken at each common shift u. The score takes all shifts together,

    .. math:: \tfrac34 \, \tau \log \sum_u e^{f_u / \tau} + \tfrac14 \, \tau \log \sum_u e^{c_u / \tau}

    as the likelihood of a photograph does whose shift is not known: it varies less among strangers than the largest
    correlation, which it approaches where one shift stands out. The shift is where blocks agree most without freedom.

    Parameters
    ----------
    query
        (3, h, w) `patterns` of the photograph.
    templates
        At least one, of the same (h, w).
    reach
        Largest common shift in pixels of the grid, at least 0.

    Raises
    ------
    HarmonicFaceError
        Nobody, or other shapes.

    Examples
    --------
    >>> faces = np.random.default_rng(0).uniform(0.1, 1, (2, 48, 48))
    >>> people = [Template.of([patterns(face)]) for face in faces]
    >>> int(similarity(patterns(faces[1] ** 0.5), people).scores.argmax())
    1
    """
    _validate.at_least(reach, 0, "reach")
    if len(templates) == 0:
        raise HarmonicFaceError("templates: expected at least one, got none")
    for template in templates:
        if template.shape != query.shape[1:]:
            raise HarmonicFaceError(f"templates: expected the query's shape {query.shape[1:]}, got {template.shape}")
    flat = query.sum(axis=0)
    free, still = correlations(flat, [template.blocks for template in templates], reach)
    best = still.reshape(len(templates), -1).argmax(axis=1)
    down, right = np.divmod(best, 2 * reach + 1)
    scores = together(free, still)
    return Similarities(scores, np.column_stack([right, down]) - reach, int(known_blocks(flat).sum()))


def together(free: Pattern, still: Pattern) -> NDArray[np.float32]:
    """Return one score for each of n people from correlations at all shifts, (n, ...), with blocks free and not.

    At most 1; 0 where nothing is known. `similarity` says how.

    Examples
    --------
    >>> together(np.array([[0.5, 0.1]]), np.array([[0.3, 0.1]])).round(3)
    array([0.45], dtype=float32)
    """
    parts = [_over_shifts(one.reshape(len(one), -1)) for one in (free, still)]
    return np.asarray((1 - FIRM) * parts[0] + FIRM * parts[1], np.float32)


def _over_shifts(values: Pattern) -> NDArray[np.float32]:
    """Return the logarithm of the sum of exponentials of each row, at most 1; 0 where the row is."""
    most = values.max(axis=1)
    sums = np.exp((values - most[:, None]) / SHARPNESS).sum(axis=1)
    return np.where(values.any(axis=1), np.minimum(most + SHARPNESS * np.log(sums), 1), 0)


def _at_scale(log: Pattern, scale: float, seen: NDArray[np.bool_] | None) -> Pattern:
    """Return the pattern of a logarithm at one scale; the mean energy is that of what is seen."""
    detail = blurred(log, scale) - blurred(log, WIDER * scale)
    energy = np.sqrt(blurred(detail * detail, NEIGHBOURHOOD))
    mean = float((energy if seen is None or not seen.any() else energy[seen]).mean())
    squashed = np.tanh(detail / (energy + np.float32(FAINT * mean + LEAST_ENERGY)))
    squashed[energy < LEAST_ENERGY] = 0
    found = np.clip(squashed - blurred(squashed, SURROUND), -1, 1)
    found[energy < LEAST_ENERGY] = 0
    return np.asarray(found)


def _bright(pixels: Floats) -> float:
    """Return how bright the bright parts are; 1 where there is no light at all."""
    if pixels.size == 0:
        return 1.0
    place = (pixels.size - 1) * BRIGHT // 100
    return float(np.partition(pixels, place, axis=None)[place]) or float(pixels.max()) or 1.0


def _moved(picture: Pattern, reference: Pattern) -> Pattern:
    """Return a pattern moved by whole pixels to where it correlates best with another; 0 comes in from outside."""
    shape = tuple(size + REACH for size in picture.shape)
    spectrum = np.fft.rfft2(reference, shape) * np.fft.rfft2(picture, shape).conj()
    correlation = np.fft.irfft2(spectrum, shape)
    around = np.arange(-REACH, REACH + 1)
    down, right = (int(i) - REACH for i in divmod(correlation[np.ix_(around, around)].argmax(), len(around)))
    moved = np.zeros_like(picture)
    height, width = picture.shape
    moved[max(down, 0) : height + min(down, 0), max(right, 0) : width + min(right, 0)] = picture[
        max(-down, 0) : height + min(-down, 0), max(-right, 0) : width + min(-right, 0)
    ]
    return moved
