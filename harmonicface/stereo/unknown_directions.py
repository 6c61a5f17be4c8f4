"""Lamps of known brightness in unknown directions: Hayakawa's factors, integrability, and lamps of length 1."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.bas_relief import SPREAD, relief_of_equal_lamps, unit_frame
from harmonicface.stereo.hayakawa import LinearFactors, linear_factors
from harmonicface.stereo.integrability import integrable_frame, integrable_rotation
from harmonicface.stereo.lamps import Lamps, bulging, judged, of_rim
from harmonicface.stereo.least_squares import scaled_normals

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]

LEAST_LAMPS = 6  # a symmetric 3 x 3 matrix has six unknowns
WORSE, SLACK = 2.0, 10.0  # the misfit of lamps beyond which the shape is taken to leave its frame open
LEAST_INNER = 30  # pixels, several for each of the nine unknowns of a frame


def unknown_directions(observations: Floats, mask: Mask, saturation: float = np.inf, seed: int = 0) -> Lamps:
    """Find normals, albedo and directions from photographs under equally bright lamps in unknown directions.

    1. `I = L B'` with a rank of 3, shadows and highlights left out (`linear_factors`).
    2. Any frame might stand between: the one in which B is integrable is right up to a bas-relief transformation
       (`integrable_frame`), and that all lamps have length 1 determines the transformation. Where the shape leaves its
       frame open, the other way round: lamps of length 1 leave a rotation, and integrability determines that.
    3. Convex or concave: things bulge toward the camera, so the rim points outward.

    Parameters
    ----------
    observations
        (n, p) linear intensities of the masked pixels, divided by each lamp's brightness; n of at least 6.
    mask
        (h, w) booleans with p of them true, row by row.
    saturation
        From there on an observation is not used.
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
    lights, scaled = _shape_first(factors, mask, seed)
    other = _lamps_first(factors, mask, seed)
    if other and _inequality(lights) > WORSE * _inequality(other[0]) + SLACK:  # three more unknowns fit a little better
        lights, scaled = other
    lights, scaled, slant = bulging(lights, scaled, mask)
    lights = lights / np.linalg.norm(lights, axis=1)[:, None]
    scaled, _ = scaled_normals(observations, lights, factors.weights)
    return Lamps(lights, judged(observations, lights, scaled, factors.weights), of_rim(slant))


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


def _shape_first(factors: LinearFactors, mask: Mask, seed: int) -> tuple[Doubles, Doubles]:
    """Return lights and scaled normals: integrable, then equal lamps."""
    frame = integrable_frame(factors.scaled, mask, seed).matrix
    lights, scaled = factors.moved(frame)
    relief, _ = relief_of_equal_lamps(lights)
    return lights @ np.linalg.inv(relief), scaled @ relief.T


def _lamps_first(factors: LinearFactors, mask: Mask, seed: int) -> tuple[Doubles, Doubles] | None:
    """Return lights and scaled normals: equal lamps, then integrable; None where lamps do not tell."""
    frame = unit_frame(factors.lights)
    if frame is None:
        return None
    lights, scaled = factors.moved(frame)
    turn = integrable_rotation(scaled, mask, seed).matrix
    return lights @ turn.T, scaled @ turn.T


def _inequality(lights: Doubles) -> float:
    """Return how unequally bright the lamps are: the Cauchy loss of the logarithms."""
    logarithms = np.log(np.linalg.norm(lights, axis=1) + 1e-300)
    return float(np.log1p(((logarithms - np.median(logarithms)) / SPREAD) ** 2).sum())
