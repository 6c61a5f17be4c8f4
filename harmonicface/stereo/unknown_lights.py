"""Unknown lights: which solver answers; many pixels are solved under the lights that fewer, larger ones tell."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from harmonicface._validate import Floats
from harmonicface.appearance.basis import harmonic_images
from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import order_of
from harmonicface.stereo import known_lights
from harmonicface.stereo.factors import leading_factors
from harmonicface.stereo.general_unknown_light import general_light_stereo
from harmonicface.stereo.in_blocks import Pixels, Stack, solved
from harmonicface.stereo.light_model import choose_light_model
from harmonicface.stereo.result import Ambiguity, Model
from harmonicface.stereo.unknown_directions import unknown_directions
from harmonicface.stereo.unknown_lamps import unknown_lamps
from harmonicface.surfaces.surface import Surface

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
    if brightness is not None:
        found = _of_known_brightness(observations, coarse, model, brightness)
    else:
        name, reason = _model(observations, coarse, model)
        if name == "linear3":
            lamps = unknown_lamps(observations, coarse.mask, face=face, saturation=stack.saturation)
            found = Found(lamps.lights, lamps.pixels, "linear3", reason, lamps.ambiguity, {})
        else:
            found = _under_general_light(observations, coarse, name, reason, face)
    tell("lights", 1, 1)
    if side == 1:
        return found
    finer = _finer if found.model == "linear3" else _finer_linear
    return replace(found, pixels=finer(stack, found, method, observations, tell))


def _model(observations: Floats, stack: Stack, asked: str) -> tuple[str, str]:
    """Return the model asked for, or the smallest that explains the photographs, and why."""
    if asked != "auto":
        return asked, "It was asked for."
    chosen = choose_light_model(observations, stack.mask)
    return chosen.model, chosen.reason


def _of_known_brightness(observations: Floats, stack: Stack, model: str, brightness: Floats) -> Found:
    """Return what is found of lamps whose directions alone are unknown."""
    if model not in ("auto", "linear3"):
        raise HarmonicFaceError(f"intensities: expected them with distant lamps (linear3) only, got them with {model}")
    even = observations / brightness[:, None].astype(observations.dtype)
    saturated = observations >= stack.saturation
    highest = float(even.max()) * (1 + 1e-3)
    even[saturated] = highest  # each photograph's own ceiling has become another one
    lamps = unknown_directions(even, stack.mask, highest)
    lights = lamps.lights * brightness[:, None]
    reason = "the intensities of distant lamps were given"
    pixels = replace(lamps.pixels, residual=lamps.pixels.residual * np.median(brightness))
    return Found(lights, pixels, "linear3", reason, lamps.ambiguity, {})


def _under_general_light(observations: Floats, stack: Stack, model: str, reason: str, face: bool) -> Found:
    """Return what is found under any light, and the harmonic coefficients that explain the photographs best then."""
    found = general_light_stereo(observations, stack.mask, model=model, face=face)
    albedo = np.linalg.norm(found.scaled, axis=1)
    normals = np.where(albedo[:, None] > 0, found.scaled, [0.0, 0.0, 1.0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    row = Surface(normals[None], albedo[None])  # the pixels, one after the other
    images = harmonic_images(row, order_of(found.lights.shape[1]))
    lights = np.linalg.lstsq(images.T, observations.T.astype(np.float64), rcond=None)[0].T
    residual = np.sqrt(np.mean((observations - lights @ images) ** 2, axis=0))
    used = np.full(observations.shape[1], len(observations), np.int32)
    pixels = Pixels(found.scaled, residual, found.confidence, used)
    return Found(lights, pixels, found.model, reason, found.ambiguity, {})


def _finer_linear(stack: Stack, found: Found, method: str, observations: Floats, tell: Tell) -> Pixels:
    """Return all pixels by the linear map of the photographs' factors that explains the coarse ones best."""
    factors = leading_factors(observations, {"ambient4": 4, "harmonic9": 9}[found.model])
    assert factors.right is not None
    linear = np.linalg.lstsq(factors.right.T.astype(np.float64), found.pixels.scaled, rcond=None)[0]
    error = float(np.median(found.pixels.confidence))

    def solve(block: Floats) -> Pixels:
        right = factors.project(block)
        rest = block - (factors.left.astype(block.dtype) @ right)
        residual = np.sqrt(np.einsum("np,np->p", rest, rest) / len(block))
        count = block.shape[1]
        return Pixels(right.T @ linear, residual, np.full(count, error), np.full(count, len(block), np.int32))

    return solved(stack, solve, lambda done, of: tell("normals", done, of))


def _finer(stack: Stack, found: Found, method: str, observations: Floats, tell: Tell) -> Pixels:
    """Return all pixels under the lights that were found."""
    kept = [index for index in range(len(stack)) if index not in found.left_out]

    def solve(observations: Floats) -> Pixels:
        return known_lights.solve(observations[kept], found.lights[kept], method, stack.saturation)

    return solved(stack, solve, lambda done, of: tell("normals", done, of))
