"""Light directions: what stands for a light gives its irradiance."""

from __future__ import annotations

import numpy as np
import pytest

from harmonicface.appearance.light_directions import MOST_LAMPS, parts_of
from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting import lights
from harmonicface.lighting.environment import EnvironmentMap
from harmonicface.lighting.light import HarmonicLight, Light
from harmonicface.lighting.sources import DirectionalLights


def normals(count=40, seed=0):
    vectors = np.random.default_rng(seed).normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def summed(part, towards):
    """The irradiance by a part's directions, up to a factor, for each of its sets: (sets, n, c)."""
    cosines = np.maximum(np.einsum("ni,sri->snr", towards, part.directions), 0)
    return np.einsum("snr,src->snc", cosines, part.weights)


def spotted(rows=40, sun=1e4):
    """A map with texture and a sun that outshines all of it."""
    radiance = np.random.default_rng(0).random((rows, 2 * rows, 3))
    radiance[rows // 4, rows] = sun
    return EnvironmentMap(radiance)


SPREAD = {
    "ambient": lights.ambient(0.7),
    "tinted": lights.ambient([0.7, 0.5, 0.2]),
    "window": lights.area([1, 2, 3], 20.0),
    "sun": lights.area([0, 0, 1], 0.27),
    "sky": lights.sky(),
    "everywhere": lights.area([0, 1, 0], 180.0),
    "natural": lights.natural(0),
    "map": spotted(),
    "grey map": spotted().grey(),
    "turned map": spotted().rotated(np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])),
    "cube": EnvironmentMap(np.random.default_rng(0).random((6, 8, 8)), "cube"),
    "many lamps": DirectionalLights(normals(100), np.random.default_rng(0).random(100)),
}


@pytest.mark.parametrize("name", SPREAD)
def test_directions_stand_for_the_light(name):
    light, towards = SPREAD[name], normals()
    (part,) = parts_of(light)
    assert np.linalg.norm(part.directions, axis=2) == pytest.approx(1)
    exact = light.irradiance(towards).reshape(40, -1)
    assert part.irradiance(towards).reshape(40, -1) == pytest.approx(exact, abs=2e-3 * exact.max())
    found = summed(part, towards)
    shape = exact.sum(axis=1, keepdims=True) if part.weights.shape[2] == 1 else exact
    factor = shape.sum() / found.mean(axis=0).sum()
    assert found.mean(axis=0) * factor == pytest.approx(shape, abs=5e-3 * shape.max())  # no bias
    assert (found * factor).std(axis=0).max() < 0.03 * shape.max()  # and little that one pixel has and the next has not


def test_a_sun_takes_many_directions_but_not_all():
    light = spotted(sun=1e6)
    (part,) = parts_of(light, 512)
    sun = light.directions[10, 40]
    share = (part.directions @ sun > 1 - 1e-9).mean(axis=1)
    assert share.min() > 0.4
    assert share.max() < 0.95
    assert (part.weights > 0).all()


def test_a_black_map_is_dark():
    (part,) = parts_of(EnvironmentMap(np.zeros((4, 8))))
    assert part.irradiance(normals()).tolist() == [0] * 40
    assert not part.weights.any()


def test_lamps_and_harmonics_stay_what_they_are():
    lamp, harmonic = lights.directional([1, 1, 1]), HarmonicLight([1.0, 0, 0, 0])
    few = DirectionalLights(normals(MOST_LAMPS), np.ones(MOST_LAMPS))
    together = lamp + (harmonic + few) + lights.ambient(1)
    parts = list(parts_of(together))
    assert parts[:3] == [lamp, harmonic, few]
    assert len(parts) == 4


def test_the_number_of_directions_is_the_one_asked_for():
    for light in (lights.ambient(1), lights.sky(), lights.natural(0)):
        (part,) = parts_of(light, 90)
        assert part.directions.shape[1:] == (90, 3)
        assert part.weights.shape[:2] == part.directions.shape[:2]


def test_huge_and_tiny_strengths_overflow_nowhere():
    for factor in (1e28, 1e-30):
        (part,) = parts_of(factor * lights.natural(0))
        assert np.isfinite(part.weights.astype(np.float32)).all()
        assert (part.weights.astype(np.float32) > 0).all()


def test_other_kinds_of_light_are_refused():
    class Torch(Light):
        channels = 1

        def irradiance(self, normals):
            return np.zeros(len(normals))

        def coefficients(self, order=2):
            return np.zeros((order + 1) ** 2)

        def rotated(self, rotation):
            return self

        def __mul__(self, factor):
            return self

    with pytest.raises(HarmonicFaceError, match="light: expected one of the package's lights, got Torch"):
        list(parts_of(Torch()))
