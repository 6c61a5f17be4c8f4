"""Lamps of known brightness in unknown directions: Hayakawa's factors, integrability, and lamps of length 1."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.bas_relief import SPREAD, unit_frame
from harmonicface.stereo.bas_relief_cues import equal_albedo, highlights, known_lamps, matrix_of, pooled
from harmonicface.stereo.hayakawa import linear_factors
from harmonicface.stereo.integrability import integrable_frame, integrable_rotation
from harmonicface.stereo.lamps import Lamps, bulging, of_rim, solved_under
from harmonicface.stereo.matte_refinement import Refined, refined

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]

LEAST_LAMPS = 6  # a symmetric 3 x 3 matrix has six unknowns
WORSE, SLACK = 2.0, 10.0  # the misfit of lamps beyond which the shape is taken to leave its frame open
LEAST_INNER = 30  # pixels, several for each of the nine unknowns of a frame


def unknown_directions(
    observations: Floats, mask: Mask, saturation: float = np.inf, *, method: str = "robust", seed: int = 0
) -> Lamps:
    """Find normals, albedo and directions from photographs under equally bright lamps in unknown directions.

    1. `I = L B'` with a rank of 3, shadows and highlights left out (`linear_factors`), and both factors refined
       together (`refined`).
    2. Any frame might stand between: the one in which B is integrable is right up to a bas-relief transformation
       (`integrable_frame`), and that all lamps have length 1 determines the transformation; equal albedo of neighbours
       and highlights add what they can (`pooled`). Where the shape leaves its
       frame open, the other way round: lamps of length 1 leave a rotation, and integrability determines that.
    3. Convex or concave: things bulge toward the camera, so the rim points outward.
    4. The lamps being known, all pixels are solved under them by the method asked for.

    Parameters
    ----------
    observations
        (n, p) linear intensities of the masked pixels, divided by each lamp's brightness; n of at least 6.
    mask
        (h, w) booleans with p of them true, row by row.
    saturation
        From there on an observation is not used.
    method
        "robust" or "least_squares", of the last step.
    seed
        Of the searches' starts.

    Returns
    -------
    Lamps

    Raises
    ------
    HarmonicFaceError
        Fewer than six photographs, photographs that do not span three dimensions, a mask without inner pixels.
    """
    if len(observations) < LEAST_LAMPS:
        raise HarmonicFaceError(
            f"images: expected at least {LEAST_LAMPS} under lamps of unknown directions, got {len(observations)}"
        )
    checked_inside(observations, mask)
    factors = linear_factors(observations, saturation)
    start = refined(observations, factors.lights, factors.scaled, factors.weights)
    lights, slant = _shape_first(observations, start, mask, seed)
    other = _lamps_first(start, mask, seed)
    if other and _inequality(lights) > WORSE * _inequality(other[0]) + SLACK:  # three more unknowns fit a little better
        lights, slant = other
    lights = lights / np.linalg.norm(lights, axis=1)[:, None]
    return Lamps(lights, solved_under(observations, lights, method, saturation), of_rim(slant))


def checked_inside(observations: Floats, mask: Mask) -> None:
    """Refuse a mask that is not the observations', or none of whose pixels has its four neighbours in it."""
    if mask.ndim != 2 or observations.shape[1] != mask.sum():
        raise HarmonicFaceError(f"mask: expected {observations.shape[1]} pixels, got {int(mask.sum())}")
    inner = mask[1:-1, 1:-1] & mask[1:-1, 2:] & mask[1:-1, :-2] & mask[2:, 1:-1] & mask[:-2, 1:-1]
    if inner.sum() < LEAST_INNER:
        raise HarmonicFaceError(
            f"mask: expected at least {LEAST_INNER} pixels with four neighbours in it, whose slopes tell the surface's"
            f" frame under unknown lights, got {int(inner.sum())}"
        )


def _shape_first(observations: Floats, start: Refined, mask: Mask, seed: int) -> tuple[Doubles, float]:
    """Return lights and the rim's slant: integrable, then equal lamps, albedo and highlights pooled."""
    frame = integrable_frame(start.scaled, mask, seed).matrix
    lights, scaled = start.lights @ np.linalg.inv(frame), start.scaled @ frame.T
    lights, scaled, slant = bulging(lights, scaled, mask)
    cues = [known_lamps(lights), equal_albedo(scaled, mask, seed)]
    cues.append(highlights(observations, lights, scaled, pooled(cues).relief, seed))
    return lights @ np.linalg.inv(matrix_of(pooled(cues).relief)), slant


def _lamps_first(start: Refined, mask: Mask, seed: int) -> tuple[Doubles, float] | None:
    """Return lights and the rim's slant: equal lamps, then integrable; None where lamps do not tell."""
    frame = unit_frame(start.lights)
    if frame is None:
        return None
    lights, scaled = start.lights @ np.linalg.inv(frame), start.scaled @ frame.T
    turn = integrable_rotation(scaled, mask, seed).matrix
    lights, _, slant = bulging(lights @ turn.T, scaled @ turn.T, mask)
    return lights, slant


def _inequality(lights: Doubles) -> float:
    """Return how unequally bright the lamps are: the Cauchy loss of the logarithms."""
    logarithms = np.log(np.linalg.norm(lights, axis=1) + 1e-300)
    return float(np.log1p(((logarithms - np.median(logarithms)) / SPREAD) ** 2).sum())
