"""Known lights: which solver answers, and what lamps do not tell."""

from __future__ import annotations

import numpy as np
import pytest

from harmonicface.bench.stability.hard_photographs import bumpy_ball, lamps
from harmonicface.errors import HarmonicFaceError
from harmonicface.stereo.known.known_lights import check_span, matte, solve, spread_of

NORMALS = bumpy_ball(20)[0]


@pytest.mark.parametrize(
    "lights",
    [
        np.repeat(lamps(1), 8, axis=0),
        np.array([[np.sin(angle), 0.0, np.cos(angle)] for angle in np.linspace(-0.8, 0.8, 8)]),
    ],
    ids=["one lamp", "a plane"],
)
def test_lamps_that_do_not_span_space_are_refused(lights: np.ndarray) -> None:
    with pytest.raises(HarmonicFaceError, match="expected directions that span space, got 8 near one plane"):
        check_span(lights)
    assert spread_of(lights) < 1e-7


def test_brightness_does_not_count_for_the_span() -> None:
    lights = lamps(8)
    check_span(lights * np.logspace(-3, 3, 8)[:, None])


def test_narrow_lamps_are_taken_as_matte_and_say_how_far_gloss_would_change_it() -> None:
    lights = lamps(20, 5)
    seen = 0.6 * lights @ NORMALS.T + 0.003 * np.random.default_rng(0).normal(size=(20, len(NORMALS)))
    found, plain = solve(seen, lights, "robust", np.inf), matte(seen, lights, np.inf)
    np.testing.assert_array_equal(found.scaled, plain.scaled)
    assert (found.confidence >= plain.confidence).all()
    assert np.median(found.confidence) > 2 * np.median(plain.confidence)


@pytest.mark.parametrize("seed", [0, 1])
def test_errors_of_pixels_of_four_photographs_are_what_is_stated(seed: int) -> None:
    lights = lamps(4, seed=3)
    seen = 0.6 * lights @ NORMALS.T
    lit = (seen > 0.02).all(axis=0)
    seen = seen + 0.003 * np.random.default_rng(seed).normal(size=seen.shape)
    found = matte(seen[:, lit], lights, np.inf)
    cosines = np.einsum("pk,pk->p", found.scaled, NORMALS[lit]) / np.linalg.norm(found.scaled, axis=1)
    error = np.degrees(np.arccos(np.clip(cosines, -1, 1)))
    assert (
        error > 3 * found.confidence
    ).mean() < 0.05  # a fifth, were the noise of each pixel told by its one spare photograph alone
    assert 0.4 < np.median(error) / np.median(found.confidence) < 1.5
