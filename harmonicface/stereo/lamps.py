"""What photographs tell of unknown distant lamps: their directions, the normals, and what stays open."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.stereo import known_lights
from harmonicface.stereo.in_blocks import Pixels
from harmonicface.stereo.result import Ambiguity
from harmonicface.stereo.rim import DECIDED, outward_slant
from harmonicface.stereo.robust import robust_normals

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


def bulging(lights: Doubles, scaled: Doubles, mask: Mask) -> tuple[Doubles, Doubles, float]:
    """Turn a surface right side out: facing the camera, and its rim facing outward; return its outward slant too."""
    if scaled[:, 2].sum() < 0:
        lights, scaled = -lights, -scaled
    slant = outward_slant(scaled, mask)
    if slant < 0:
        lights, scaled = lights * LEFT_RIGHT_UP_DOWN, scaled * LEFT_RIGHT_UP_DOWN
    return lights, scaled, abs(slant)


def of_rim(slant: float) -> Ambiguity:
    """Return what is open when only the rim told convex from concave."""
    parameters = {"outward_slant": slant}
    if slant < DECIDED:
        reason = f"the rim points outward by a sine of {slant:.2f} only, so it may as well be the mirror image in depth"
        return Ambiguity("convex-concave", reason, parameters)
    reason = (
        f"lamps of known brightness leave a rotation, integrability the sign of depth; the rim bulges ({slant:.2f})"
    )
    return Ambiguity("none", reason, parameters)
