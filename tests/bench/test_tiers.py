"""The lights of each tier are what its line says."""

from __future__ import annotations

import numpy as np
import pytest

import harmonicface as hf
from harmonicface.bench.tiers import TIERS, gallery_lights
from harmonicface.lighting.light import SumOfLights
from harmonicface.lighting.sources import AmbientLight, DirectionalLights

BY_NAME = {tier.name: tier for tier in TIERS}


def degrees_off_axis(light: DirectionalLights) -> np.ndarray:
    return np.degrees(np.arccos(np.clip(light.directions[:, 2], -1, 1)))


def test_the_tiers_from_easy_to_hard() -> None:
    assert list(BY_NAME) == ["frontal", "side", "several", "natural", "noise", "extreme"]
    assert [tier.noise for tier in TIERS] == [0.01, 0.01, 0.01, 0.01, 0.05, 0.01]


@pytest.mark.parametrize(
    ("name", "least", "most"), [("frontal", 0, 25), ("side", 25, 77), ("noise", 25, 77), ("extreme", 77, 110)]
)
def test_one_lamp_between_two_angles_in_any_direction(name: str, least: float, most: float) -> None:
    rng = np.random.default_rng(0)
    lamps = [BY_NAME[name].light(rng) for _ in range(300)]
    assert all(isinstance(lamp, DirectionalLights) and lamp.strengths.tolist() == [1.0] for lamp in lamps)
    angles = np.concatenate([degrees_off_axis(lamp) for lamp in lamps])
    assert angles.min() >= least
    assert angles.max() <= most
    assert np.ptp(angles) > 0.9 * (most - least)
    towards = np.concatenate([lamp.directions for lamp in lamps])
    quadrants = (towards[:, 0] > 0) + 2 * (towards[:, 1] > 0)
    assert (np.bincount(quadrants, minlength=4) > 40).all()


def test_several_broad_lamps_and_ambient_light() -> None:
    rng = np.random.default_rng(0)
    counts = set()
    for _ in range(60):
        light = BY_NAME["several"].light(rng)
        assert isinstance(light, SumOfLights)
        lamps, ambient = light.parts
        assert isinstance(lamps, DirectionalLights)
        assert isinstance(ambient, AmbientLight)
        assert 0.05 <= float(ambient.strength) <= 0.2
        counts.add(len(lamps.directions))
        for disc in np.split(lamps.directions, len(lamps.directions) // 100):
            centre = disc.mean(axis=0) / np.linalg.norm(disc.mean(axis=0))
            radius = np.degrees(np.arccos(np.clip(disc @ centre, -1, 1))).max()
            assert 9 < radius < 21
            assert np.degrees(np.arccos(centre[2])) < 81
    assert counts == {200, 300, 400}


def test_natural_light_is_an_environment_of_thousands_of_directions() -> None:
    light = BY_NAME["natural"].light(np.random.default_rng(0))
    assert isinstance(light, hf.EnvironmentMap)
    assert light.radiance.size == 2048


def test_the_gallery_sees_seven_frontal_lamps() -> None:
    lights = gallery_lights()
    angles = [degrees_off_axis(light)[0] for light in lights if isinstance(light, DirectionalLights)]
    np.testing.assert_allclose(angles, [0, *[12] * 6], atol=1e-5)
    assert len({tuple(light.directions[0].round(6)) for light in lights if isinstance(light, DirectionalLights)}) == 7
