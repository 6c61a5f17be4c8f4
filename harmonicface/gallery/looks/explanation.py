"""Explanation: what of a photograph a person accounts for, what was left out, and why she is named or nobody is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.gallery.frame import Frame
from harmonicface.gallery.looks.whereabouts import Whereabouts
from harmonicface.lighting.light import HarmonicLight
from harmonicface.recognition.grid import NEIGHBOURHOOD, Picture, blurred, grid
from harmonicface.recognition.patterns import patterns
from harmonicface.recognition.placement import Placement
from harmonicface.recognition.robust import ALIKE, RobustFit, agreement, enlarged, robust_fit, shows_light
from harmonicface.recognition.subspace import Subspace
from harmonicface.stereo.motion import Matrix, displacement, seen_through, then, undone

FEWEST_PICTURES = 3  # fewer cannot be combined to another light
ELSEWHERE = 1.0  # pixels, in the mean over the corners: nearer pictures are not resampled, which blurs
LEAST = 1e-3  # of the largest intensity: darker parts tell no light


@dataclass(frozen=True, eq=False)
class Explanation:
    """What the first candidate accounts for in a photograph.

    Parameters
    ----------
    reconstruction
        (h, w) the photograph as her picture, under the light that explains what was not left out.
    residual
        (h, w) photograph less reconstruction, 0 outside the gallery's mask.
    weights
        (h, w) 0 to 1, how much each pixel counted for the reconstruction.
    left_out
        (h, w) booleans: pixels inside the mask that count less than half. Something hides them, or light does there
        what her pictures do not show: a cast shadow, gloss, burnt-out skin.
    light
        The light of the reconstruction; None when she was enrolled from photographs whose lights are unknown.
    reason
        In one sentence, why she is named or nobody is.
    """

    reconstruction: Picture
    residual: Picture
    weights: Picture
    left_out: NDArray[np.bool_]
    light: HarmonicLight | None
    reason: str


@dataclass(frozen=True, eq=False)
class Evidence:
    """What an explanation is made from, when it is asked for.

    Parameters
    ----------
    frame
        The gallery's.
    pixels, good
        (p,) of the photograph, and which of them are good.
    subspace
        Of the first candidate.
    where
        Where she was found; None for models that look for her only where she was enrolled.
    geometry
        Whether her pictures are harmonic images.
    ambient
        Whether the first of these is for ambient light.
    reason
        In one sentence.
    """

    frame: Frame
    pixels: Floats
    good: NDArray[np.bool_]
    subspace: Subspace
    where: Whereabouts | None
    geometry: bool
    ambient: bool
    reason: str

    def explanation(self, placement: Placement | None = None) -> Explanation:
        """Explain the photograph.

        Parameters
        ----------
        placement
            How the photograph shows her, to fractions of a pixel, if that is known. It counts where it is elsewhere
            than where she was named, by more than a pixel.

        Raises
        ------
        HarmonicFaceError
            Fewer than 24 pixels a side.
        """
        photo = self.frame.picture(self.pixels).astype(np.float32)
        seen = self.frame.mask.copy()
        seen[self.frame.mask] = self.good
        rows = np.stack([self.frame.picture(row) for row in self.subspace.rows])
        if self.where is not None:
            back = undone(_motion(self.where, placement))
            rows = np.stack([seen_through(np.asarray(row, np.float32), back) for row in rows])
        seen &= rows.any(axis=0)
        if not shows_light(photo, seen):
            nothing = np.zeros_like(photo)
            return Explanation(nothing, photo, nothing, self.frame.mask.copy(), None, self.reason)
        fit = robust_fit(photo, rows, seen) if len(rows) >= FEWEST_PICTURES else smoothly_lit(photo, rows, seen)
        light = None
        if self.geometry:
            coefficients = fit.coefficients @ self.subspace.to_coefficients
            light = HarmonicLight(coefficients if self.ambient else np.concatenate([[0.0], coefficients]))
        left_out = self.frame.mask & (fit.weights < 0.5)
        return Explanation(fit.picture, photo - fit.picture, fit.weights, left_out, light, self.reason)


def _motion(where: Whereabouts, placement: Placement | None) -> Matrix:
    """Return the motion from her frame to the photograph by which her pictures are moved."""
    shape = where.frame.shape
    if placement is None:
        return where.motion
    motion = placement.motion(shape)
    return motion if displacement(then(undone(where.motion), motion), shape) > ELSEWHERE else where.motion


def smoothly_lit(photo: Picture, rows: Picture, mask: NDArray[np.bool_]) -> RobustFit:
    """Return a person's one picture under a light that changes smoothly from place to place.

    One picture cannot be combined to another light. Where patterns agree, its quotient with the photograph, smoothed,
    stands for light.

    Parameters
    ----------
    photo
        (h, w).
    rows
        (k, h, w), of which the strongest is taken.
    mask
        (h, w) booleans.
    """
    picture = np.maximum(rows[0] * np.sign(rows[0].sum()), 0).astype(np.float32)
    height = grid((photo.shape[0], photo.shape[1]))[0]
    alike = agreement(*(patterns(one, mask) for one in (photo, picture)))
    weights = np.clip(enlarged(alike, photo.shape) / np.float32(ALIKE), 0, 1) * mask
    smooth = NEIGHBOURHOOD * photo.shape[0] / height
    below = blurred(picture * mask, smooth) + np.float32(LEAST * float(picture.max()))
    shown = (picture * blurred(np.asarray(photo * mask, np.float32), smooth) / below * mask).astype(np.float32)
    residual = (photo - shown) * mask
    kept = weights >= 0.5
    energy, remaining, rest = (
        float(np.square(part, dtype=np.float64).sum()) for part in (photo[mask], photo[kept], residual[kept])
    )
    distance = float(np.sqrt(min(1.0, rest / remaining))) if remaining else 1.0
    return RobustFit(np.ones(1), shown, weights, residual, distance, remaining / energy, mask & ~kept)


def named(name: str, value: float | None, threshold: float, by_score: bool) -> str:
    """Say why somebody is named; value is None where there is nobody else to compare with.

    Examples
    --------
    >>> named("ada", 12.34, 5, by_score=True)
    'ada is named: 12.3 deviations more alike than strangers, where 5 are needed'
    """
    if value is None:
        return f"{name} is named: alike by what strangers usually reach, as nobody else is enrolled"
    if by_score:
        return f"{name} is named: {value:.3g} deviations more alike than strangers, where {threshold:.3g} are needed"
    how = f"at most {threshold:.3g} is needed" if value <= threshold else "the next person is clearly farther"
    return f"{name} is named: at a distance of {value:.3g}, where {how}"


def unknown(name: str, value: float | None, threshold: float, by_score: bool, why: str) -> str:
    """Say why nobody is named; value is None where there is nobody else to compare with.

    Examples
    --------
    >>> unknown("ada", 2.5, 5, True, "nobody is more alike than strangers are")
    'unknown: nobody is more alike than strangers are (first is ada, at 2.5 deviations, where 5 are needed)'
    """
    if value is None:
        return f"unknown: {why}"
    measure = f"{value:.3g} deviations" if by_score else f"a distance of {value:.3g}"
    return f"unknown: {why} (first is {name}, at {measure}, where {threshold:.3g} {'are' if by_score else 'is'} needed)"
