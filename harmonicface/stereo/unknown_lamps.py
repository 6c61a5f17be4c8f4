"""Lamps of which nothing is known: Hayakawa's factors, integrability, and the bas-relief ambiguity by pooled cues."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.stereo.bas_relief_cues import Cue, equal_albedo, equal_lamps, highlights, matrix_of, pooled, usual
from harmonicface.stereo.hayakawa import equalized, linear_factors
from harmonicface.stereo.in_blocks import Pixels
from harmonicface.stereo.integrability import integrable_frame
from harmonicface.stereo.lamps import Lamps, bulging, solved_under
from harmonicface.stereo.matte_refinement import refined
from harmonicface.stereo.result import Ambiguity
from harmonicface.stereo.rim import DECIDED
from harmonicface.stereo.unknown_directions import checked_inside

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]

RESOLVED = 5.0  # degrees: the error that tilt and relief leave in the median normal, below which they count as told
OPEN = 1.0  # of the frame's gap: below, the curl tells less than its own noise


def unknown_lamps(
    observations: Floats,
    mask: Mask,
    *,
    face: bool = False,
    saturation: float = np.inf,
    method: str = "robust",
    seed: int = 0,
) -> Lamps:
    """Find normals, albedo and lamps from photographs under distant lamps of unknown direction and brightness.

    1. Each photograph is divided by its ninth decile, about its lamp's brightness (`equalized`).
    2. `I = L B'` with a rank of 3, shadows and highlights left out (`linear_factors`), and both factors refined
       together (`refined`).
    3. The frame in which B is integrable is right up to a bas-relief transformation (`integrable_frame`).
    4. That is chosen by all cues there are, weighted by their standard errors: equal albedo of neighbours, highlights,
       lamps that can be made equally bright, the usual relief of things; for faces symmetry and a mean face too.
    5. Convex or concave: things bulge toward the camera, so the rim points outward.
    6. The lamps being known, all pixels are solved under them by the method asked for.

    Parameters
    ----------
    observations
        (n, p) linear intensities of the masked pixels, n of at least 3.
    mask
        (h, w) booleans with p of them true, row by row.
    face
        True if the photographs show an upright face from the front that fills the mask's width.
    saturation
        From there on an observation is not used.
    method
        "robust" or "least_squares", of the last step.
    seed
        Of the searches' samples and starts.

    Returns
    -------
    Lamps
        Brightness is relative: the median lamp has 1. The ambiguity's parameters are the standard errors of `mu` and
        `nu` (of the tilt, in depth per pixel) and `lambda` (of the factor on depth); those of the normals contain them.

    Raises
    ------
    HarmonicFaceError
        Fewer than three photographs, photographs that do not span three dimensions, one that is black, a mask without
        inner pixels.
    """
    checked_inside(observations, mask)
    equal, brightness = equalized(observations)
    factors = linear_factors(equal, saturation / brightness[:, None])
    better = refined(equal, factors.lights, factors.scaled, factors.weights)
    frame = integrable_frame(better.scaled, mask, seed)
    lights, scaled = better.lights @ np.linalg.inv(frame.matrix), better.scaled @ frame.matrix.T
    lights, scaled, slant = bulging(lights, scaled, mask)
    cues = _cues(equal, lights, scaled, brightness, mask, face, seed)
    chosen = pooled(cues)
    relief = matrix_of(chosen.relief)
    lights, scaled = (lights @ np.linalg.inv(relief)) * brightness[:, None], scaled @ relief.T
    unit = np.median(np.linalg.norm(lights, axis=1))
    lights = lights / unit
    found = solved_under(observations, lights, method, saturation)
    doubt = _doubt(found.scaled.astype(np.float64), chosen.deviations)
    confidence = np.hypot(found.confidence, doubt)
    ambiguity = _ambiguity(chosen, float(np.median(doubt)), slant, frame.gap)
    return Lamps(lights, Pixels(found.scaled, found.residual, confidence, found.used), ambiguity)


def _cues(
    equal: Floats, lights: Doubles, scaled: Doubles, brightness: Doubles, mask: Mask, face: bool, seed: int
) -> list[Cue]:
    """Return all evidence on tilt and relief of an upright frame."""
    cues = [usual(), equal_albedo(scaled, mask, seed)]
    if lamps := equal_lamps(lights * brightness[:, None]):
        cues.append(lamps)
    cues.append(highlights(equal, lights, scaled, pooled(cues).relief, seed))
    return cues


def _doubt(scaled: Doubles, deviations: Doubles) -> Doubles:
    """Return the standard error in degrees that those of tilt and relief give to each normal."""
    units = scaled / (np.linalg.norm(scaled, axis=1)[:, None] + 1e-300)
    total = np.zeros(len(units))
    for step in np.diag(deviations):
        moved = units @ matrix_of(step).T
        cosines = np.einsum("pk,pk->p", units, moved) / (np.linalg.norm(moved, axis=1) + 1e-300)
        total += np.arccos(np.clip(cosines, -1, 1)) ** 2
    return np.asarray(np.degrees(np.sqrt(total)))


def _ambiguity(chosen: Cue, doubt: float, slant: float, gap: float) -> Ambiguity:
    """Name what is open after the cues have been pooled."""
    mu, nu, stretch = chosen.deviations
    parameters = {"mu": 0.0, "nu": 0.0, "lambda": 1.0}
    parameters |= {"mu_std": float(mu), "nu_std": float(nu), "lambda_std": float(np.expm1(stretch))}
    parameters |= {"outward_slant": slant, "frame_gap": gap}
    told = f"tilt and relief are from {chosen.name}, to {doubt:.1f} degrees"
    if gap < OPEN:
        reason = "the surface is too plain for integrability to tell its frame (a cylinder, or nearly flat)"
        return Ambiguity("linear", reason, parameters)
    if doubt > RESOLVED:
        return Ambiguity("bas-relief", told, parameters)
    if slant < DECIDED:
        reason = f"{told}; the rim points outward by a sine of {slant:.2f} only: it may be its mirror image in depth"
        return Ambiguity("convex-concave", reason, parameters)
    return Ambiguity("none", told, parameters)
