"""What photographs tell of unknown distant lamps: their directions, the normals, and what stays open."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.stereo.depth.rim import DECIDED, outward_slant
from harmonicface.stereo.in_blocks import Pixels
from harmonicface.stereo.known import known_lights
from harmonicface.stereo.known.misfit import model_misfit
from harmonicface.stereo.known.robust import robust_normals
from harmonicface.stereo.lamps.bas_relief_cues import matrix_of
from harmonicface.stereo.result import Ambiguity

Doubles = NDArray[np.float64]
Mask = NDArray[np.bool_]
LEFT_RIGHT_UP_DOWN = np.array([-1.0, -1.0, 1.0])  # what turning a surface inside out does to normals and lights


@dataclass(frozen=True, eq=False)
class Lamps:
    """Lights and scaled normals that explain photographs, and the family of others that would too.

    Parameters
    ----------
    lights
        (n, 3) directions to the lamps times their brightness.
    pixels
        What was found of the masked pixels: albedo times normal, residual, standard error, count.
    ambiguity
        What remains open, with the parameters of the chosen member.
    """

    lights: Doubles
    pixels: Pixels
    ambiguity: Ambiguity


def solved_under(observations: Floats, lights: Doubles, method: str, saturation: float) -> Pixels:
    """Solve (n, p) observations under the lamps that were found, glossy and partly in shadow unless told otherwise."""
    if method == "robust":
        return robust_normals(observations, lights, saturation)
    return known_lights.solve(observations, lights, method, saturation)


def stated_under(observations: Floats, lights: Doubles, method: str, saturation: float) -> Pixels:
    """Solve (n, p) observations as `solved_under`, and add to the standard errors what the model's misfit does."""

    def solve(seen: Floats, lamps: Floats) -> Pixels:
        return solved_under(seen, lamps.astype(np.float64), method, saturation)

    pixels = solve(observations, lights)
    return replace(pixels, confidence=np.hypot(pixels.confidence, model_misfit(observations, lights, solve)))


def bulging(lights: Doubles, scaled: Doubles, mask: Mask) -> tuple[Doubles, Doubles, float]:
    """Turn a surface right side out: facing the camera, and its rim facing outward; return its outward slant too."""
    if scaled[:, 2].sum() < 0:
        lights, scaled = -lights, -scaled
    slant = outward_slant(scaled, mask)
    if slant < 0:
        lights, scaled = lights * LEFT_RIGHT_UP_DOWN, scaled * LEFT_RIGHT_UP_DOWN
    return lights, scaled, abs(slant)


def doubt_of(scaled: Doubles, deviations: Doubles) -> Doubles:
    """Return the standard error in degrees that those of tilt and relief give to each normal."""
    units = scaled / (np.linalg.norm(scaled, axis=1)[:, None] + 1e-300)
    total = np.zeros(len(units))
    for step in np.diag(deviations):
        moved = units @ matrix_of(step).T
        cosines = np.einsum("pk,pk->p", units, moved) / (np.linalg.norm(moved, axis=1) + 1e-300)
        total += np.arccos(np.clip(cosines, -1, 1)) ** 2
    return np.asarray(np.degrees(np.sqrt(total)))


def of_rim(slant: float, deviations: Doubles | None = None) -> Ambiguity:
    """Return what is open when only the rim told convex from concave, and the errors of the relief."""
    parameters = {"outward_slant": slant}
    if deviations is not None:
        mu, nu, stretch = (float(each) for each in deviations)
        parameters |= {"mu_std": mu, "nu_std": nu, "lambda_std": float(np.expm1(stretch))}
    if slant < DECIDED:
        reason = f"the rim points outward by a sine of {slant:.2f} only, so it may as well be the mirror image in depth"
        return Ambiguity("convex-concave", reason, parameters)
    reason = (
        f"lamps of known brightness leave a rotation, integrability the sign of depth; the rim bulges ({slant:.2f})"
    )
    return Ambiguity("none", reason, parameters)
