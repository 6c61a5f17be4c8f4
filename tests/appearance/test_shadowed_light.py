"""Lamps found again by their shadows."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.appearance.nonnegative_light import fibonacci_sphere, nonnegative_light
from harmonicface.appearance.relight import relight
from harmonicface.appearance.shadowed_light import shadowed_light
from harmonicface.lighting.sources import DirectionalLights

ROWS, COLUMNS = np.mgrid[:24, :24]
HILLS = 8 * np.sin(ROWS / 3.0) * np.cos(COLUMNS / 4.0)
HEAD = hf.surface_from_depth(HILLS, np.random.default_rng(0).uniform(0.3, 0.9, (24, 24)))
GRID = fibonacci_sphere(60)
LAMPS = DirectionalLights(GRID[[14, 19, 24]], [1.0, 0.5, 0.7])


@pytest.mark.parametrize("tint", [1.0, [1.0, 0.5, 0.2]], ids=["grey", "colour"])
def test_lamps_of_the_grid_come_back(tint: object) -> None:
    lamps = LAMPS * tint  # type: ignore[operator]
    photo = hf.render(HEAD, lamps, shadows=True)
    assert (photo < hf.render(HEAD, lamps) - 1e-3).mean() > 0.1  # there are shadows
    found = shadowed_light(photo, HEAD, 60)
    assert_allclose(found.coefficients(4), lamps.coefficients(4), atol=1e-4)


def test_relighting_knows_of_shadows() -> None:
    old, new = (hf.lights.natural(seed, size=8).grey() for seed in (3, 4))
    photo, truth = (hf.render(HEAD, light, shadows=True) for light in (old, new))
    matte = nonnegative_light(photo, HEAD).light
    found, worse = (relight(photo, HEAD, new, light, shadows=True) for light in (None, matte))
    errors = [np.linalg.norm(each - truth) / np.linalg.norm(truth) for each in (found, worse)]
    assert errors[0] < errors[1] / 2


def test_darkness() -> None:
    assert not shadowed_light(np.zeros((24, 24)), HEAD, 60).strengths.any()


@pytest.mark.parametrize(
    ("photo", "surface", "directions", "message"),
    [
        (np.ones((3, 3)), HEAD, 60, "photo: expected shape"),
        (np.full((24, 24), np.nan), HEAD, 60, "photo: expected finite"),
        (np.ones((24, 24)), HEAD, 0, "count: expected an integer of at least 1"),
        (np.ones((24, 24)), hf.Surface(HEAD.normals, HEAD.albedo), 60, "surface: expected a scene or depth"),
    ],
)
def test_what_tells_of_no_light(photo: np.ndarray, surface: hf.Surface, directions: int, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        shadowed_light(photo, surface, directions)
