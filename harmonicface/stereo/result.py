"""What photometric stereo found, what it could not determine, and how far it can be trusted."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.surfaces.surface import Surface

AmbiguityName = Literal["none", "convex-concave", "bas-relief", "lorentz", "linear"]
Model = Literal["linear3", "ambient4", "harmonic9"]


@dataclass(frozen=True, eq=False)
class Ambiguity:
    """The family of surfaces that would explain the photographs as well as the one that was chosen.

    Parameters
    ----------
    name
        `"none"`: the surface is determined. `"convex-concave"`: it or its mirror image in depth, lit from the mirrored
        side. `"bas-relief"`: any flattening and tilting (Belhumeur, Kriegman & Yuille 1999). `"lorentz"`: the
        six-parameter group that keeps `|albedo normal| = albedo` (Basri & Jacobs 2001). `"linear"`: any invertible
        3 x 3 matrix (Hayakawa 1994).
    reason
        One sentence: what would determine it, or what did.
    parameters
        Of the member that was chosen, by name (for the bas-relief family `mu`, `nu`, `lambda`, and where known how far
        each may be off as `..._std`); empty where there is no family.
    """

    name: AmbiguityName
    reason: str
    parameters: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class StereoResult:
    """A Surface from photographs, its lights, and what stands behind both.

    Parameters
    ----------
    surface
        Normals, albedo and, where it was integrated, depth; float32.
    lights
        (n, 3) directions *to* the lights times their brightness, or (n, 4) or (n, 9) harmonic coefficients of
        radiance, as `model` says. Rows of photographs that were left out are NaN.
    model
        How light was described: `"linear3"` distant lamps, `"ambient4"` with constant ambient light, `"harmonic9"` any
        distant light to second order.
    model_reason
        One sentence: who asked for it, or why the smaller models do not explain the photographs.
    residual
        (h, w) float32, root mean square of photograph minus model over what was used; 0 outside the mask.
    confidence
        (h, w) float32, the standard error of the normal in degrees, from the residual and the lights that reach the
        pixel; infinity where the photographs do not determine it, 0 outside the mask.
    used
        (h, w) int32, how many photographs each pixel was solved from; 0 outside the mask.
    ambiguity
        What remains undetermined.
    left_out
        Photographs that do not belong to the others, by index, each with its reason.
    singular_values
        (k,) leading singular values of the (n, p) photographs, largest first.
    rank
        How many of them stand above the noise.
    gap
        The last singular value of the model over the next one: near 1 the model's size is not told by the data.
    condition
        The largest singular value of the model over its smallest: how much noise is magnified at the worst.
    """

    surface: Surface
    lights: Floats
    model: Model
    model_reason: str
    residual: NDArray[np.float32]
    confidence: NDArray[np.float32]
    used: NDArray[np.int32]
    ambiguity: Ambiguity
    left_out: dict[int, str]
    singular_values: Floats
    rank: int
    gap: float
    condition: float
