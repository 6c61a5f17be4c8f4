"""Render and compare: a person's pictures are lit as the photograph is, and both are compared in fine detail."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import digamma, polygamma

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.blocks import REACH, correlations, unit_blocks
from harmonicface.recognition.grid import NEIGHBOURHOOD, OnGrid, Picture, blurred, filled, grid, on_grid, resized
from harmonicface.recognition.patterns import FAINT, Pattern, patterns_on_grid
from harmonicface.recognition.subspace import Subspace

NARROW, WIDE = 0.7, 1.4  # standard deviations in pixels: detail that shading does not have, and that noise leaves
EDGE = 0.9  # of a pixel's surroundings must be seen
LEAST_SHARE = 1e-12  # of the detail: who explains less, explains nothing
RANK = 1e-6  # eigenvalues below this part of the largest belong to pictures that depend on the others


@dataclass(frozen=True, eq=False)
class Pictures:
    """The pictures that span a person's, on the grid; made by `Pictures.of`.

    Parameters
    ----------
    light
        (k, h, w) float32, orthonormal.
    detail
        (k, h w) float32: what of them lies between two Gaussians.
    """

    light: Picture
    detail: Picture

    @classmethod
    def of(cls, images: ArrayLike, mask: NDArray[np.bool_] | None = None) -> Pictures:
        """Put pictures on the grid.

        Parameters
        ----------
        images
            (k, h, w) pictures of a person, of either sign.
        mask
            (h, w) booleans: the pixels that are compared, all by default.

        Raises
        ------
        HarmonicFaceError
            Another shape, NaN, too few pixels, pictures that are all 0.

        Examples
        --------
        >>> pictures = Pictures.of(np.random.default_rng(0).uniform(0, 1, (9, 192, 168)))
        >>> pictures.light.shape, pictures.detail.shape
        ((9, 96, 84), (9, 8064))
        """
        stack = np.asarray(_validate.finite(images, "images"), np.float32)
        if stack.ndim != 3 or len(stack) == 0:
            raise HarmonicFaceError(f"images: expected shape (k, h, w), got {_validate.describe(stack)}")
        size = grid((stack.shape[1], stack.shape[2]))
        light = np.stack([resized(image, size) for image in stack])
        if mask is not None and not mask.all():
            cover = resized(mask.astype(np.float32), size)
            light = np.stack([filled(resized(image * mask, size), cover) for image in stack])
        light = Subspace.of(light.reshape(len(light), -1)).rows.reshape(-1, *size)
        return cls(light, np.stack([_detail(image).ravel() for image in light]))

    @property
    def nbytes(self) -> int:
        """Memory of both."""
        return self.light.nbytes + self.detail.nbytes


@dataclass(frozen=True, eq=False)
class Explanation:
    """How a person's pictures explain a photograph, where they do it best.

    Parameters
    ----------
    share
        Of the energy of the photograph's detail, each part divided by the local energy, that her pictures explain.
    surprise
        The logarithm of the F statistic of that regression in its own deviations, up to a constant: with k pictures,
        a stranger explains by chance a share like a chi square of k degrees, whose logarithm has the deviation
        sqrt(psi'(k / 2)) whatever the noise and however many pixels count.
    distance
        The sine of the angle between the photograph itself and the span of her pictures there, 0 to 1.
    picture
        (h, w) her picture under the light that explains the photograph's detail best, at the place of the photograph.
    shift
        Pixels of the grid to the right and down by which the photograph shows her displaced.
    """

    share: float
    surprise: float
    distance: float
    picture: Picture
    shift: tuple[int, int]


class Photograph:
    """A photograph, taken apart once so as to be compared with many people.

    Parameters
    ----------
    photo
        (h, w) linear intensities in any unit, at least 24 pixels a side.
    mask
        (h, w) booleans, false where it is bad.

    Examples
    --------
    >>> faces = np.random.default_rng(0).uniform(0.1, 1, (2, 48, 48))
    >>> photo = Photograph(faces[0] ** 2)
    >>> found = [photo.explained(Pictures.of(face[None])).share.__round__(1) for face in faces]
    >>> found[0] > 0.5, found[1]
    (True, 0.0)
    """

    def __init__(self, photo: ArrayLike, mask: ArrayLike | None = None) -> None:
        self._picture = on_grid(photo, mask)
        self.patterns: Pattern = patterns_on_grid(self._picture)
        self._moved: dict[tuple[int, int], tuple[Picture, Picture, float]] = {}

    @cached_property
    def _bordered_detail(self) -> tuple[Picture, Picture]:
        """What lies between two Gaussians, and what it weighs, with room for shifts."""
        detail = _detail(self._picture.light)
        energy = blurred(detail * detail, NEIGHBOURHOOD)
        mean = float(energy.mean())
        weights = np.zeros_like(energy) if mean == 0 else np.float32(1) / (energy + np.float32(FAINT * mean))
        weights = np.asarray(weights, np.float32)
        if self._picture.seen is not None:
            weights *= blurred(self._picture.seen.astype(np.float32), WIDE) > EDGE
        return _bordered(detail), _bordered(weights)

    @cached_property
    def _light(self) -> Picture:
        """The photograph on the grid, with room for shifts."""
        return _widened(self._picture.light)

    def explained(self, pictures: Pictures, shifts: tuple[tuple[int, int], ...] = ((0, 0),)) -> Explanation:
        r"""Find the light under which a person's pictures show the photograph's detail best.

        With D the pictures' detail, d the photograph's and W the inverse local energy of d, so that a dark region
        counts as much as a bright one and a shadow's edge no more than skin,

        .. math:: \min_c (d - D^T c)^T W (d - D^T c)

        Parameters
        ----------
        pictures
            Hers, on the same grid.
        shifts
            Where to look, each up to 4 pixels to the right and down; the best is taken.

        Raises
        ------
        HarmonicFaceError
            Pictures on another grid.
        """
        if pictures.light.shape[1:] != self.patterns.shape[1:]:
            raise HarmonicFaceError(
                f"pictures: expected the photo's grid {self.patterns.shape[1:]}, got {pictures.light.shape[1:]}"
            )
        fits = [(*self._fit(pictures, shift), shift) for shift in dict.fromkeys(shifts)]
        share, coefficients, shift = max(fits, key=lambda fit: fit[0])
        shown = (coefficients @ pictures.light.reshape(len(coefficients), -1)).reshape(pictures.light.shape[1:])
        distance = self._distance(pictures, shift)
        return Explanation(share, _surprise(share, len(coefficients)), distance, _placed(shown, shift), shift)

    def likeness(self, shown: list[Picture]) -> NDArray[np.float32]:
        """Return how much pictures at the photograph's place resemble it: (n,) similarities of local patterns."""
        blocks = [unit_blocks(patterns_on_grid(OnGrid(one, self._picture.seen)).sum(axis=0)) for one in shown]
        free, _ = correlations(self.patterns.sum(axis=0), blocks, 1)
        return np.asarray(free.reshape(len(shown), -1).max(axis=1))

    def _fit(self, pictures: Pictures, shift: tuple[int, int]) -> tuple[float, NDArray[np.float32]]:
        """Return the share that is explained at a shift, and the coefficients."""
        weights, target, energy = self._at(shift)
        if energy == 0:
            return 0.0, np.zeros(len(pictures.detail), np.float32)
        moments = (pictures.detail @ target).astype(np.float64)
        normal = ((pictures.detail * weights) @ pictures.detail.T).astype(np.float64)
        coefficients = np.linalg.pinv(normal, rcond=RANK, hermitian=True) @ moments
        return min(float(coefficients @ moments) / energy, 1.0), coefficients.astype(np.float32)

    def _distance(self, pictures: Pictures, shift: tuple[int, int]) -> float:
        """Return the sine of the angle between the photograph and the span of the pictures at a shift."""
        right, down = shift
        height, width = self.patterns.shape[1:]
        light = self._light[REACH + down : REACH + down + height, REACH + right : REACH + right + width].ravel()
        rows = pictures.light.reshape(len(pictures.light), -1)
        if self._picture.seen is not None:
            seen = self._at(shift)[0] > 0  # the mask is also that of the detail
            light, rows = light[seen], rows[:, seen]
        length = float(np.linalg.norm(light))
        if length == 0 or not rows.any():
            return 1.0
        if self._picture.seen is not None:
            rows = Subspace.of(rows).rows
        return float(np.sqrt(max(0.0, 1 - float(np.square(rows @ (light / length)).sum()))))

    def _at(self, shift: tuple[int, int]) -> tuple[Picture, Picture, float]:
        """Return weights, weighted detail and its energy as seen from a person who is displaced."""
        if shift not in self._moved:
            right, down = shift
            height, width = self.patterns.shape[1:]
            window = np.s_[REACH + down : REACH + down + height, REACH + right : REACH + right + width]
            detail, weights = (part[window].ravel() for part in self._bordered_detail)
            target = weights * detail
            self._moved[shift] = weights, target, float(target @ detail)
        return self._moved[shift]


def _detail(light: Picture) -> Picture:
    """Return what of a picture lies between two Gaussians."""
    return blurred(light, NARROW) - blurred(light, WIDE)


def _surprise(share: float, count: int) -> float:
    """Return log(share / (1 - share)) in deviations of what chance gives so many pictures."""
    part = min(max(share, LEAST_SHARE), 1 - LEAST_SHARE)
    centred = np.log(part / (1 - part)) - digamma(count / 2) - np.log(2)
    return float(centred / np.sqrt(polygamma(1, count / 2)))


def _bordered(picture: Picture) -> Picture:
    """Return a picture with room for shifts, 0 outside."""
    return np.asarray(cv2.copyMakeBorder(picture, REACH, REACH, REACH, REACH, cv2.BORDER_CONSTANT, value=0))


def _widened(picture: Picture) -> Picture:
    """Return a picture with room for shifts, its border repeated."""
    return np.asarray(cv2.copyMakeBorder(picture, REACH, REACH, REACH, REACH, cv2.BORDER_REPLICATE))


def _placed(picture: Picture, shift: tuple[int, int]) -> Picture:
    """Return a picture moved to the right and down; its border is repeated."""
    right, down = shift
    height, width = picture.shape
    larger = _widened(picture)
    return np.ascontiguousarray(larger[REACH - down : REACH - down + height, REACH - right : REACH - right + width])
