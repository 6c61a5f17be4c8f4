"""Misfit by halves of the lamps: none of a surface that is what the model says, about the error of one that is not."""

from __future__ import annotations

import numpy as np
import pytest

from harmonicface._validate import Floats
from harmonicface.bench.stability.hard_photographs import bumpy_ball, lamps
from harmonicface.stereo.in_blocks import Pixels
from harmonicface.stereo.known.known_lights import plain, solve
from harmonicface.stereo.known.misfit import model_misfit

NORMALS = bumpy_ball(24)[0]
LAMPS = lamps(24, 30)
EXACT = 0.6 * LAMPS @ NORMALS.T


def least_squares(observations: Floats, lights: Floats) -> Pixels:
    return plain(observations, lights, np.inf)


def errors(found: Pixels) -> Floats:
    lengths = np.linalg.norm(found.scaled, axis=1)
    return np.degrees(np.arccos(np.clip(np.einsum("pk,pk->p", found.scaled, NORMALS) / lengths, -1, 1)))


def test_noise_is_no_misfit() -> None:
    noisy = EXACT + 0.01 * np.random.default_rng(0).normal(size=EXACT.shape)
    stated = np.median(least_squares(noisy, LAMPS).confidence)
    assert model_misfit(noisy, LAMPS, least_squares) < stated


@pytest.mark.parametrize("method", ["least_squares", "matte"])
def test_gloss_is_a_misfit_of_about_the_error_it_makes(method: str) -> None:
    halves = LAMPS + np.array([0, 0, 1])
    halves /= np.linalg.norm(halves, axis=1, keepdims=True)
    glossy = EXACT + 0.3 * np.maximum(halves @ NORMALS.T, 0) ** 8

    def solver(observations: Floats, lights: Floats) -> Pixels:
        return solve(observations, lights, method, np.inf)

    found = solver(glossy, LAMPS)
    error, misfit = np.median(errors(found)), model_misfit(glossy, LAMPS, solver)
    assert error > 3 * np.median(found.confidence)  # what the residuals alone say
    assert error / 3 < misfit < 3 * error


def test_nothing_is_said_of_few_lamps_or_black_pixels() -> None:
    assert model_misfit(EXACT[:7] ** 2, LAMPS[:7], least_squares) == 0
    assert model_misfit(0 * EXACT, LAMPS, least_squares) == 0


def test_halves_that_do_not_span_space_are_passed_over() -> None:
    sides = np.radians(np.linspace(-40, 40, 6))
    row = np.stack([np.sin(sides), 0 * sides, np.cos(sides)], axis=1)
    column = row[:, [1, 0, 2]]
    lights = np.concatenate([row - np.array([0, 0.5, 0]), row + np.array([0, 0.5, 0]), column])
    lights /= np.linalg.norm(lights, axis=1, keepdims=True)

    def solver(observations: Floats, some: Floats) -> Pixels:
        return solve(observations, some, "matte", np.inf)

    assert np.isfinite(model_misfit(lights @ NORMALS.T, lights, solver))
    near = np.concatenate([row, row + np.array([0, 0.08, 0])])
    near /= np.linalg.norm(near, axis=1, keepdims=True)
    assert np.isfinite(model_misfit(near @ NORMALS.T, near, solver))
