"""Lamps of known brightness in unknown directions: Hayakawa's factors, integrability, and lamps of length 1."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.in_blocks import Pixels
from harmonicface.stereo.lamps.bas_relief import SPREAD, unit_frame
from harmonicface.stereo.lamps.bas_relief_cues import equal_albedo, highlights, known_lamps, matrix_of, pooled
from harmonicface.stereo.lamps.hayakawa import check_span, lights_of, linear_factors, middle_ranks
from harmonicface.stereo.lamps.integrability import integrable_frame, integrable_rotation
from harmonicface.stereo.lamps.lamps import Lamps, bulging, doubt_of, of_rim, solved_under, stated_under
from harmonicface.stereo.lamps.matte_refinement import Refined, refined
from harmonicface.stereo.lamps.plane_of_lamps import check_plane

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]

LEAST_LAMPS = 6  # a symmetric 3 x 3 matrix has six unknowns
WORSE, SLACK = 2.0, 10.0  # the misfit of lamps beyond which the shape is taken to leave its frame open
SAMPLE, ROUNDS = 6000, 8  # pixels and steps of the last refinement of the lamps
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
    4. Normals and albedo of some pixels are freed from gloss (`robust_normals`), and the lamps refined under them:
       `min sum w log(1 + (I - l . b)^2 / s^2)` over unit l, by reweighting.
    5. The lamps being known, all pixels are solved under them by the method asked for.

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

    Examples
    --------
    >>> y, x = np.mgrid[1:-1:30j, -1:1:30j]
    >>> mask = x**2 + y**2 < 0.9
    >>> across = 1.2 * x + 0.6 * np.cos(3 * x + 1) * np.cos(4 * y)
    >>> up = 1.2 * y - 0.8 * np.sin(3 * x + 1) * np.sin(4 * y)
    >>> normals = np.stack([across, up, np.ones_like(x)], axis=2)[mask]  # of a hill with bumps
    >>> normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    >>> towards = np.random.default_rng(0).normal((0, 0, 2), 0.7, (12, 3))
    >>> towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    >>> found = unknown_directions(np.maximum(towards @ normals.T, 0), mask)
    >>> apart = np.degrees(np.arccos((found.lights * towards).sum(axis=1) / np.linalg.norm(found.lights, axis=1)))
    >>> bool(apart.max() < 3), found.ambiguity.name
    (True, 'none')
    """
    if len(observations) < LEAST_LAMPS:
        raise HarmonicFaceError(
            f"images: expected at least {LEAST_LAMPS} under lamps of unknown directions, got {len(observations)}"
        )
    checked_inside(observations, mask)
    factors = linear_factors(observations, saturation)
    start = refined(observations, factors.lights, factors.scaled, factors.weights)
    check_span(start.lights, start.scaled)
    check_plane(observations, start, factors.weights)
    lights, slant, deviations = _shape_first(observations, start, mask, seed)
    other = _lamps_first(start, mask, seed)
    if other and _inequality(lights) > WORSE * _inequality(other[0]) + SLACK:  # three more unknowns fit a little better
        lights, slant = other
    lengths = np.linalg.norm(lights, axis=1)
    if not (np.isfinite(lengths) & (lengths > 0)).all():
        raise HarmonicFaceError(
            "intensities: expected those of the lamps, got some with which no directions explain the photographs"
        )
    lights = lights / lengths[:, None]
    if method == "robust":
        lights = _under_their_normals(observations, lights, saturation)
    found = stated_under(observations, lights, method, saturation)
    confidence = np.hypot(found.confidence, doubt_of(found.scaled.astype(np.float64), deviations))
    return Lamps(lights, Pixels(found.scaled, found.residual, confidence, found.used), of_rim(slant, deviations))


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


def _shape_first(observations: Floats, start: Refined, mask: Mask, seed: int) -> tuple[Doubles, float, Doubles]:
    """Return lights, slant of the rim, errors of the relief: integrable, then all cues on the relief pooled."""
    frame = integrable_frame(start.scaled, mask, seed).matrix
    lights, scaled = start.lights @ np.linalg.inv(frame), start.scaled @ frame.T
    lights, scaled, slant = bulging(lights, scaled, mask)
    cues = [known_lamps(lights), equal_albedo(scaled, mask, seed)]
    cues.append(highlights(observations, lights, scaled, pooled(cues).relief, seed))
    chosen = pooled(cues)
    return lights @ np.linalg.inv(matrix_of(chosen.relief)), slant, chosen.deviations


def _lamps_first(start: Refined, mask: Mask, seed: int) -> tuple[Doubles, float] | None:
    """Return lights and the rim's slant: equal lamps, then integrable; None where lamps do not tell."""
    frame = unit_frame(start.lights)
    if frame is None:
        return None
    lights, scaled = start.lights @ np.linalg.inv(frame), start.scaled @ frame.T
    turn = integrable_rotation(scaled, mask, seed).matrix
    lights, _, slant = bulging(lights @ turn.T, scaled @ turn.T, mask)
    return lights, slant


def _under_their_normals(observations: Floats, lights: Doubles, saturation: float) -> Doubles:
    """Return the unit lamps that explain best, under a Cauchy loss, what normals freed from gloss predict."""
    chosen = np.linspace(0, observations.shape[1] - 1, min(SAMPLE, observations.shape[1])).astype(int)
    seen = observations[:, chosen].astype(np.float64)
    normals = solved_under(seen, lights, "robust", saturation).scaled.astype(np.float64)
    weights = middle_ranks(seen) * (seen < saturation)
    for _ in range(ROUNDS):
        rest = seen - lights @ normals.T
        scale = max(1.4826 * float(np.median(np.abs(rest[weights > 0]))), 1e-6 * float(seen.max()))
        lights = lights_of(seen, normals, weights / (1 + (rest / scale) ** 2))
        lights = lights / np.linalg.norm(lights, axis=1)[:, None]
    return lights


def _inequality(lights: Doubles) -> float:
    """Return how unequally bright the lamps are: the Cauchy loss of the logarithms."""
    logarithms = np.log(np.linalg.norm(lights, axis=1) + 1e-300)
    return float(np.log1p(((logarithms - np.median(logarithms)) / SPREAD) ** 2).sum())
