"""Lamps of which nothing is known: Hayakawa's factors, integrability, and the bas-relief ambiguity by pooled cues."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.stereo.bas_relief_cues import Cue, equal_albedo, equal_lamps, highlights, matrix_of, pooled, usual
from harmonicface.stereo.face_frame import MeanFace, find_mean_face
from harmonicface.stereo.hayakawa import equalized, linear_factors
from harmonicface.stereo.in_blocks import Pixels
from harmonicface.stereo.integrability import integrable_frame
from harmonicface.stereo.lamps import Lamps, bulging, solved_under
from harmonicface.stereo.matte_refinement import Refined, refined
from harmonicface.stereo.result import Ambiguity
from harmonicface.stereo.rim import DECIDED
from harmonicface.stereo.unknown_directions import checked_inside

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]

RESOLVED = 5.0  # degrees: the error that tilt and relief leave in the median normal, below which they count as told
ALIKE = 1.25  # of the angle to the mean face that it takes at best: within, integrability is to be trusted more
FACE_ERROR = (0.1, 0.1, 0.15)  # of tilt and relief: how far people are from the mean face
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
       lamps that can be made equally bright, the usual relief of things. If it is a face and that does not look like
       one, the frame is taken in which it looks most like the mean face, which is symmetric (`MeanFace.frame`).
    5. Convex or concave: things bulge toward the camera, so the rim points outward.
    6. The lamps being known, all pixels are solved under them by the method asked for.

    Parameters
    ----------
    observations
        (n, p) linear intensities of the masked pixels, n of at least 3.
    mask
        (h, w) booleans with p of them true, row by row.
    face
        True if the photographs show an upright face from the front.
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
    found = _by_integrability(equal, better, brightness, mask, seed)
    if face:
        found = _by_mean_face(found, better, find_mean_face(equal, mask))
    lights = found.lights * brightness[:, None]
    unit = np.median(np.linalg.norm(lights, axis=1))
    lights = lights / unit
    pixels = solved_under(observations, lights, method, saturation)
    doubt = _doubt(pixels.scaled.astype(np.float64), found.cue.deviations)
    confidence = np.hypot(pixels.confidence, doubt)
    return Lamps(
        lights,
        Pixels(pixels.scaled, pixels.residual, confidence, pixels.used),
        _ambiguity(found, float(np.median(doubt))),
    )


@dataclass(frozen=True, eq=False)
class _Upright:
    """Lights and scaled normals in the frame that was chosen, by what, and how sure that is."""

    lights: Doubles
    scaled: Doubles
    cue: Cue
    slant: float
    gap: float


def _by_integrability(equal: Floats, start: Refined, brightness: Doubles, mask: Mask, seed: int) -> _Upright:
    """Return the integrable frame with the tilt and relief on which all cues agree best."""
    frame = integrable_frame(start.scaled, mask, seed)
    lights, scaled = start.lights @ np.linalg.inv(frame.matrix), start.scaled @ frame.matrix.T
    lights, scaled, slant = bulging(lights, scaled, mask)
    cues = [usual(), equal_albedo(scaled, mask, seed)]
    if lamps := equal_lamps(lights * brightness[:, None]):
        cues.append(lamps)
    cues.append(highlights(equal, lights, scaled, pooled(cues).relief, seed))
    chosen = pooled(cues)
    relief = matrix_of(chosen.relief)
    return _Upright(lights @ np.linalg.inv(relief), scaled @ relief.T, chosen, slant, frame.gap)


def _by_mean_face(found: _Upright, start: Refined, mean: MeanFace) -> _Upright:
    """Return what integrability found where it looks like a face; otherwise the frame that does most."""
    frame = mean.frame(start.scaled)
    scaled = start.scaled @ frame.T
    if mean.angle(found.scaled) <= ALIKE * mean.angle(scaled):
        cue = Cue(f"{found.cue.name}, and look like a face", found.cue.relief, found.cue.deviations)
        return _Upright(found.lights, found.scaled, cue, found.slant, found.gap)
    cue = Cue("the mean face", np.zeros(3), np.array(FACE_ERROR))
    return _Upright(start.lights @ np.linalg.inv(frame), scaled, cue, found.slant, found.gap)


def _doubt(scaled: Doubles, deviations: Doubles) -> Doubles:
    """Return the standard error in degrees that those of tilt and relief give to each normal."""
    units = scaled / (np.linalg.norm(scaled, axis=1)[:, None] + 1e-300)
    total = np.zeros(len(units))
    for step in np.diag(deviations):
        moved = units @ matrix_of(step).T
        cosines = np.einsum("pk,pk->p", units, moved) / (np.linalg.norm(moved, axis=1) + 1e-300)
        total += np.arccos(np.clip(cosines, -1, 1)) ** 2
    return np.asarray(np.degrees(np.sqrt(total)))


def _ambiguity(found: _Upright, doubt: float) -> Ambiguity:
    """Name what is open after the cues have been pooled."""
    mu, nu, stretch = found.cue.deviations
    parameters = {"mu": 0.0, "nu": 0.0, "lambda": 1.0}
    parameters |= {"mu_std": float(mu), "nu_std": float(nu), "lambda_std": float(np.expm1(stretch))}
    parameters |= {"outward_slant": found.slant, "frame_gap": found.gap}
    told = f"tilt and relief are from {found.cue.name}, to {doubt:.1f} degrees"
    if found.gap < OPEN:
        reason = "the surface is too plain for integrability to tell its frame (a cylinder, or nearly flat)"
        return Ambiguity("linear", reason, parameters)
    if doubt > RESOLVED:
        return Ambiguity("bas-relief", told, parameters)
    if found.slant < DECIDED:
        reason = (
            f"{told}; the rim points outward by a sine of {found.slant:.2f} only: it may be its mirror image in depth"
        )
        return Ambiguity("convex-concave", reason, parameters)
    return Ambiguity("none", told, parameters)
