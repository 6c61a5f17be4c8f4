"""Robust explanation: a person's pictures are fitted to what of a photograph shows her, and the rest is left out."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.grid import OnGrid, Picture, blurred, filled, grid, resized
from harmonicface.recognition.patterns import Pattern, patterns_on_grid
from harmonicface.recognition.saturation import burnt_out

ROUNDS = 8
AGREEMENT = 5.0  # standard deviation in pixels of the grid over which patterns are correlated
ALIKE = 0.3  # a correlation from which patterns are trusted; at 0 they have nothing in common
SMOOTH = 1.5  # standard deviation in pixels: what hides a face is larger than a pixel
CAUCHY = 2.385  # deviations at half weight: 95 % as efficient as least squares where nothing hides
WIDE, NARROWING = 4.0, 0.7  # the first round forgives so many times more, each further one less
NORMAL = 1.4826  # median of absolute values to standard deviation
LEAST_SCALE = 0.04  # of the root mean square intensity: about what nine images leave of a matte head
FEWEST = 60  # pixels that agree, for a scale to be taken from them alone
UNEXPLAINED = 0.25  # of the energy of what is left out counts as unexplained: distance 0.5, where nobody is known
RANK = 1e-7  # directions with a smaller part of the largest eigenvalue are left alone


@dataclass(frozen=True, eq=False)
class RobustFit:
    """How a person's pictures explain what of a photograph shows her.

    Parameters
    ----------
    coefficients
        (k,) combine the pictures; for harmonic images they are the light.
    picture
        (h, w) the combination.
    weights
        (h, w) float32, how much each pixel counted, 0 to 1; 0 outside the mask and where the photograph is burnt out.
    residual
        (h, w) photograph less picture, 0 outside the mask.
    distance
        Over what is not left out: the root of the share of its energy that is not explained, 0 to 1.
    remaining
        The share of the photograph's energy that is not left out, 0 to 1.
    left_out
        (h, w) booleans: pixels inside the mask with less than half of the full weight.
    """

    coefficients: NDArray[np.float64]
    picture: Picture
    weights: Picture
    residual: Picture
    distance: float
    remaining: float
    left_out: NDArray[np.bool_]

    @property
    def penalized(self) -> float:
        """The distance to rank people by: what is left out counts as far as anybody who is known may be, 0.5.

        Somebody who explains a few pixels well is no nearer than somebody who explains the whole face.
        """
        return float(np.sqrt(self.remaining * self.distance**2 + (1 - self.remaining) * UNEXPLAINED))


def robust_fit(photo: ArrayLike, images: ArrayLike, mask: ArrayLike | None = None, rounds: int = ROUNDS) -> RobustFit:
    r"""Fit a person's pictures to a photograph that something hides in part: glasses, a hand, burnt-out skin, a shadow.

    Least squares are reweighted in rounds. The weight of a pixel is the product of

    - the `agreement` of local patterns of photograph and fit about it, from 0 at no correlation to 1 at 0.3; it
      finds what is no face even where that covers most of it and is as bright as skin;
    - Cauchy's weight of the residual r, :math:`1 / (1 + (r / 2.385 s)^2)`, its square smoothed over neighbours, with
      the scale s from the median of absolute residuals where patterns agree; it finds edges, gloss, cast shadows.

    Burnt-out pixels do not count from the start. Black ones do: attached shadows are part of harmonic images.

    Parameters
    ----------
    photo
        (h, w) linear intensities in any unit, at least 24 pixels a side.
    images
        (k, h, w) the person's pictures at the photograph's place.
    mask
        (h, w) booleans: where both are good, all by default.
    rounds
        At least 1.

    Raises
    ------
    HarmonicFaceError
        Other shapes, NaN or infinity, pictures that are all 0, no light in what the mask shows.

    Examples
    --------
    >>> import harmonicface as hf
    >>> ada = hf.synthetic_person(0)
    >>> images = np.zeros((9, *ada.shape), np.float32)
    >>> images[:, ada.mask] = hf.harmonic_images(ada)
    >>> photo = hf.render(ada, hf.lights.directional([1, 1, 2]))
    >>> photo[:20] = 0.4  # a hat
    >>> found = robust_fit(photo, images, ada.mask)
    >>> bool(found.left_out[:18][ada.mask[:18]].mean() > 0.9), bool(found.left_out[24:][ada.mask[24:]].mean() < 0.2)
    (True, True)
    """
    scaled, pictures, seen = _checked(photo, images, mask)
    unit = float(np.abs(scaled[seen]).max()) or 1.0
    pixels = (scaled / unit).astype(np.float32)
    _validate.at_least(rounds, 1, "rounds")
    usable, light, good = _usable(pixels, seen)
    if not (light * good).any():
        raise HarmonicFaceError("photo: expected some light in it that is not burnt out, got none")
    small = np.stack(
        [
            filled(resized(image * seen, light.shape), resized(seen.astype(np.float32), light.shape))
            for image in pictures
        ]
    )
    weights = _weights(light, small.reshape(len(small), -1), good, rounds)
    coefficients = _solve(light, small.reshape(len(small), -1), weights)
    full = enlarged(weights, pixels.shape) * usable
    picture = np.tensordot(coefficients.astype(np.float32), pictures, 1)
    residual = np.where(seen, pixels - picture, 0).astype(np.float32)
    kept = seen & (full >= 0.5)
    energy, remaining, unexplained = (
        float(np.square(part, dtype=np.float64).sum()) for part in (pixels[seen], pixels[kept], residual[kept])
    )
    return RobustFit(
        unit * coefficients,
        unit * picture,
        full,
        unit * residual,
        float(np.sqrt(min(1.0, unexplained / remaining))) if remaining else 1.0,
        remaining / energy,
        seen & ~kept,
    )


def shows_light(photo: Picture, mask: NDArray[np.bool_]) -> bool:
    """Tell whether a photograph shows some light that is not burnt out, which is what `robust_fit` needs.

    Parameters
    ----------
    photo
        (h, w) float32 intensities, at least 24 pixels a side.
    mask
        (h, w) booleans: which pixels are looked at.

    Examples
    --------
    >>> everywhere = np.ones((24, 24), np.bool_)
    >>> [shows_light(np.full((24, 24), value, np.float32), everywhere) for value in (0, 1)]
    [False, False]
    >>> shows_light(np.linspace(0, 1, 576, dtype=np.float32).reshape(24, 24), everywhere)
    True
    """
    if not mask.any():
        return False
    _, light, good = _usable(photo, mask)
    return bool((light * good).any())


def agreement(photo: Pattern, other: Pattern) -> Picture:
    """Return how much two pictures' local patterns are correlated about each pixel.

    Parameters
    ----------
    photo, other
        (s, h, w) `patterns` of both, one person at one place.

    Returns
    -------
    array
        (h, w) float32 from -1 to 1, over about ten pixels; 0 where one has no pattern.

    Raises
    ------
    HarmonicFaceError
        Other shapes.

    Examples
    --------
    >>> from harmonicface.recognition.patterns import patterns
    >>> found = patterns(np.random.default_rng(0).uniform(0.1, 1, (32, 32)))
    >>> float(agreement(found, found).min().round(3)), float(agreement(found, -found).max().round(3))
    (1.0, -1.0)
    """
    if photo.ndim != 3 or photo.shape != other.shape:
        raise HarmonicFaceError(f"patterns: expected two of one shape (s, h, w), got {photo.shape} and {other.shape}")
    ours, theirs = photo.sum(axis=0), other.sum(axis=0)
    energy = blurred(ours * ours, AGREEMENT) * blurred(theirs * theirs, AGREEMENT)
    return np.asarray(blurred(ours * theirs, AGREEMENT) / np.sqrt(energy + np.float32(1e-8)))


def _usable(pixels: Picture, seen: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], Picture, Picture]:
    """Return which pixels are seen and not burnt out; the light of these on the grid, and where it is known, 0 or 1."""
    usable = seen & ~burnt_out(pixels, seen)
    shape = grid((pixels.shape[0], pixels.shape[1]))
    cover = resized(usable.astype(np.float32), shape)
    return usable, filled(resized(pixels * usable, shape), cover), (cover > 0.5).astype(np.float32)


def _weights(light: Picture, rows: Picture, good: Picture, rounds: int) -> Picture:
    """Reweight in rounds, on the grid."""
    seen = None if good.all() else good > 0
    own = patterns_on_grid(OnGrid(light, seen))
    cover = blurred(good, SMOOTH) + np.float32(1e-6)
    weights, wide = good, WIDE
    least = LEAST_SCALE * float(np.sqrt(np.square(light[good > 0]).mean()))
    for _ in range(rounds):
        fitted = np.asarray(_solve(light, rows, weights + np.float32(1e-4) * good) @ rows, np.float32).reshape(
            light.shape
        )
        alike = agreement(own, patterns_on_grid(OnGrid(np.maximum(fitted, 0), seen)))
        alike = good * np.clip(alike / np.float32(ALIKE), 0, 1)
        residual = light - fitted
        agreeing = alike > 0.5
        scale = NORMAL * np.median(np.abs(residual[agreeing if agreeing.sum() >= FEWEST else good > 0]))
        squared = np.square(np.minimum(np.abs(residual) / max(float(scale), least), 100)) * good
        wide = max(1.0, wide * NARROWING)
        weights = alike / (1 + blurred(squared.astype(np.float32), SMOOTH) / cover / np.float32(CAUCHY * wide) ** 2)
    return np.asarray(weights, np.float32)


def _solve(light: Picture, rows: Picture, weights: Picture) -> NDArray[np.float64]:
    """Return the coefficients of weighted least squares, the shortest ones."""
    weighted = rows * weights.ravel()
    normal = (weighted @ rows.T).astype(np.float64)
    return np.asarray(
        np.linalg.pinv(normal, rcond=RANK, hermitian=True) @ (weighted @ light.ravel()).astype(np.float64)
    )


def enlarged(weights: Picture, shape: tuple[int, ...]) -> Picture:
    """Return weights of the grid at the size of a photograph."""
    if weights.shape == shape:
        return weights
    return np.asarray(cv2.resize(weights, (shape[1], shape[0]), interpolation=cv2.INTER_LINEAR))


def _checked(photo: ArrayLike, images: ArrayLike, mask: ArrayLike | None) -> tuple[Floats, Picture, NDArray[np.bool_]]:
    """Return photograph and pictures in float32, and the mask."""
    given: Floats = _validate.finite(photo, "photo")
    pictures = _validate.finite(images, "images")
    if given.ndim != 2:
        raise HarmonicFaceError(f"photo: expected shape (h, w), got {_validate.describe(given)}")
    if pictures.ndim != 3 or len(pictures) == 0 or pictures.shape[1:] != given.shape:
        raise HarmonicFaceError(f"images: expected shape (k, {given.shape[0]}, {given.shape[1]}), got {pictures.shape}")
    shape = (given.shape[0], given.shape[1])
    seen = np.ones(shape, np.bool_) if mask is None else _validate.mask(mask, "mask", shape)
    if not pictures[:, seen].any():
        raise HarmonicFaceError("images: expected something in them where the mask is, got zeros")
    return given, pictures.astype(np.float32), seen
