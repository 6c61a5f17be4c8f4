"""Unknown lights: which solver answers; many pixels are solved under the lights that fewer, larger ones tell."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from harmonicface._validate import Floats
from harmonicface.stereo import known_lights
from harmonicface.stereo.in_blocks import Pixels, Stack, solved
from harmonicface.stereo.result import Ambiguity, Model
from harmonicface.stereo.unknown_directions import unknown_directions
from harmonicface.stereo.unknown_lamps import unknown_lamps

MOST_PIXELS = 150_000  # that tell the lights: more change them by less than the model's own misfit

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


def find_lights(
    stack: Stack, model: str, method: str, face: bool, brightness: Floats | None, tell: Tell = lambda *_: None
) -> Found:
    """Find lights and normals from the photographs alone.

    Parameters
    ----------
    stack
        The photographs.
    model
        "auto", "linear3", "ambient4" or "harmonic9".
    method
        Of solving pixels under lamps once they are known.
    face
        Whether it is a face from the front.
    brightness
        (n,) of lamps in unknown directions; None where nothing is known.
    tell
        Is told what is being done.

    Raises
    ------
    HarmonicFaceError
        What the solvers refuse.
    """
    coarse, side = stack.reduced(MOST_PIXELS)
    observations = np.concatenate(list(coarse.blocks()), axis=1)
    tell("lights", 0, 1)
    found = _solve(observations, coarse, model, face, brightness)
    tell("lights", 1, 1)
    return found if side == 1 else replace(found, pixels=_finer(stack, found, method, tell))


def _solve(observations: Floats, stack: Stack, model: str, face: bool, brightness: Floats | None) -> Found:
    """Return what the solver of a model finds."""
    if brightness is None:
        lamps = unknown_lamps(observations, stack.mask, face=face, saturation=stack.saturation)
        return Found(lamps.lights, lamps.pixels, "linear3", _asked(model), lamps.ambiguity, {})
    even = observations / brightness[:, None].astype(observations.dtype)
    saturated = observations >= stack.saturation
    highest = float(even.max()) * (1 + 1e-3)
    even[saturated] = highest  # each photograph's own ceiling has become another one
    lamps = unknown_directions(even, stack.mask, highest)
    lights = lamps.lights * brightness[:, None]
    reason = "the intensities of distant lamps were given"
    return Found(lights, lamps.pixels, "linear3", reason, lamps.ambiguity, {})


def _asked(model: str) -> str:
    return "distant lamps are what is tried first" if model == "auto" else "asked for"


def _finer(stack: Stack, found: Found, method: str, tell: Tell) -> Pixels:
    """Return all pixels under the lights that were found."""
    kept = [index for index in range(len(stack)) if index not in found.left_out]

    def solve(observations: Floats) -> Pixels:
        return known_lights.solve(observations[kept], found.lights[kept], method, stack.saturation)

    return solved(stack, solve, lambda done, of: tell("normals", done, of))
