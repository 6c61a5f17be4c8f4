"""What photographs under unknown general light must be for a shape to be found in them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.factors import Factors
from harmonicface.stereo.light_model import MODELS, SPARE

FEWEST = 100  # pixels, for shadows and integrability to tell anything
DIMENSIONS = 3  # in which light has to vary
CLEARLY = 3.0  # times what noise would give: what counts as a variation

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]


def checked_photographs(pixels: ArrayLike, mask: ArrayLike) -> tuple[Doubles, Mask]:
    """Return (n, p) photographs in float64 and their mask, enough of both."""
    observations = _validate.floats(pixels, "pixels").astype(np.float64)
    inside = np.asarray(mask)
    if inside.ndim != 2:
        raise HarmonicFaceError(f"mask: expected shape (h, w), got {_validate.describe(inside)}")
    inside = _validate.mask(inside, "mask", (inside.shape[0], inside.shape[1]))
    if observations.ndim != 2 or observations.shape[1] != inside.sum():
        raise HarmonicFaceError(
            f"pixels: expected shape (n, {inside.sum()}) as in the mask, got {_validate.describe(observations)}"
        )
    if len(observations) < MODELS["ambient4"] + SPARE:
        raise HarmonicFaceError(
            f"pixels: expected at least {MODELS['ambient4'] + SPARE} photographs under unknown general light,"
            f" got {len(observations)}"
        )
    if observations.shape[1] < FEWEST:
        raise HarmonicFaceError(f"mask: expected at least {FEWEST} pixels, got {observations.shape[1]}")
    return _validate.finite(observations, "pixels").astype(np.float64), inside


def require_three_dimensions(factors: Factors, noise: float) -> None:
    """Refuse photographs that vary in one or two ways only."""
    found = factors.above_noise(max(CLEARLY * noise, 1e-6 * factors.residual(0)))
    if found < DIMENSIONS:
        raise HarmonicFaceError(
            f"pixels: expected photographs that vary in at least {DIMENSIONS} ways, got {found} above the noise of"
            f" {noise:.2g}: one light repeated, lights in a plane, or a planar surface do not tell normals"
        )
