"""Given lights: photographs that do not belong are left out, the brightness of lamps found; then pixels are solved."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.as_light import LightLike
from harmonicface.stereo.in_blocks import Pixels, Stack, solved
from harmonicface.stereo.known import known_lights
from harmonicface.stereo.known.bad_images import find_bad_images
from harmonicface.stereo.known.general_light import general_light_normals, light_coefficients
from harmonicface.stereo.known.handedness import check_axes
from harmonicface.stereo.known.known_lights import check_span
from harmonicface.stereo.known.misfit import model_misfit
from harmonicface.stereo.known.semi_calibrated import semi_calibrated
from harmonicface.stereo.result import Ambiguity, Model

ASKED = 50_000  # pixels that tell which photographs do not belong, and how bright lamps are
ORDERS: dict[str, int] = {"auto": 2, "ambient4": 1, "harmonic9": 2}

Tell = Callable[[str, int, int], None]


@dataclass(frozen=True, eq=False)
class Found:
    """Lights, what was found of the pixels under them, and what remains open.

    Parameters
    ----------
    lights
        (n, 3), (n, 4) or (n, 9) as in `StereoResult`.
    pixels
        What was found of the masked pixels.
    model, model_reason, ambiguity, left_out
        See `StereoResult`.
    """

    lights: Floats
    pixels: Pixels
    model: Model
    model_reason: str
    ambiguity: Ambiguity
    left_out: dict[int, str]


def under_lamps(stack: Stack, lights: Floats, method: str, semi: bool, tell: Tell = lambda *_: None) -> Found:
    """Find normals under known distant lamps.

    Parameters
    ----------
    stack
        The photographs.
    lights
        (n, 3) directions times brightness.
    method
        "robust" leaves photographs out that do not belong; the others take all.
    semi
        Whether the brightness of the lamps is to be found.
    tell
        Is told what is being done.

    Raises
    ------
    HarmonicFaceError
        Lamps that do not span space, or hardly; lamps in other axes.
    """
    check_span(lights)
    reason, left_out = "the directions of distant lamps were given", dict[int, str]()
    coarse, _ = stack.reduced(ASKED)
    observations = np.concatenate(list(coarse.blocks()), axis=1)
    if semi:
        found = semi_calibrated(observations, lights, observations < stack.saturation)
        lights = lights * found.values[:, None]
        error = 100 * float(np.median(found.error))
        reason += f", their brightness was found, to {error:.2g} %"
    if method == "robust":
        tell("photographs that do not belong", 0, 1)
        left_out = find_bad_images(observations, lights, stack.saturation).left_out
        tell("photographs that do not belong", 1, 1)
    kept = np.array([index for index in range(len(stack)) if index not in left_out])

    def solve_under(seen: Floats, lamps: Floats) -> Pixels:
        return known_lights.solve(seen, lamps, method, stack.saturation)

    def solve(seen: Floats) -> Pixels:
        return solve_under(seen[kept] if left_out else seen, lights[kept])

    pixels = solved(stack, solve, lambda done, of: tell("normals", done, of))
    check_axes(pixels.scaled, stack.mask)
    misfit = np.float32(model_misfit(observations[kept], lights[kept], solve_under))
    pixels = replace(pixels, confidence=np.hypot(pixels.confidence, misfit))
    told = lights.copy()
    told[list(left_out)] = np.nan
    return Found(told, pixels, "linear3", reason, Ambiguity("none", "the lights are known"), left_out)


def under_general_light(
    stack: Stack, lights: ArrayLike | Sequence[LightLike], model: str, tell: Tell = lambda *_: None
) -> Found:
    """Find normals under known light of any kind, by its harmonics to order 1 or 2.

    Raises
    ------
    HarmonicFaceError
        Lights of another count, coefficients of too low an order, the model of distant lamps.
    """
    if model == "linear3":
        raise HarmonicFaceError("model: expected ambient4 or harmonic9 with lights that are no directions, got linear3")
    order = ORDERS[model]
    if isinstance(lights, np.ndarray) and lights.ndim == 2 and lights.shape[1] == 4:
        order = 1
    rows = light_coefficients(lights, order)
    if len(rows) != len(stack):
        raise HarmonicFaceError(f"lights: expected one for each of {len(stack)} images, got {len(rows)}")
    solve = partial(general_light_normals, lights=rows, order=order, saturation=stack.saturation)
    pixels = solved(stack, solve, lambda done, of: tell("normals", done, of))
    name: Model = "ambient4" if order == 1 else "harmonic9"
    reason = f"the lights were given; their harmonics to order {order} are used"
    return Found(rows, pixels, name, reason, Ambiguity("none", "the lights are known"), {})
