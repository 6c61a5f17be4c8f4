"""Looking a map up: directions of any shape, one alone too."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from scipy.spatial.transform import Rotation

import harmonicface as hf
from harmonicface.lighting.layouts import LAYOUTS, layout_named

TOWARDS = np.random.default_rng(0).normal(size=(18, 3))
TOWARDS /= np.linalg.norm(TOWARDS, axis=1, keepdims=True)


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("colours", [(), (3,)], ids=["grey", "colour"])
@pytest.mark.parametrize("shape", [(), (1,), (2, 3), (2, 3, 3), (0,)], ids=str)
def test_directions_of_any_shape(layout: str, colours: tuple[int, ...], shape: tuple[int, ...]) -> None:
    radiance = np.random.default_rng(1).uniform(1, 2, (*layout_named(layout).shape(8), *colours))
    light = hf.EnvironmentMap(radiance, layout, Rotation.from_rotvec([0.3, 0.2, -0.5]))
    number = int(np.prod(shape))
    found = light.radiance_toward(TOWARDS[:number].reshape(*shape, 3))
    assert found.shape == shape + colours
    one_by_one = [light.radiance_toward(towards) for towards in TOWARDS[:number]]
    assert_array_equal(found.reshape(number, *colours), np.reshape(one_by_one, (number, *colours)))


@pytest.mark.parametrize("layout", LAYOUTS)
def test_one_direction_is_its_pixel(layout: str) -> None:
    chosen = layout_named(layout)
    radiance = np.random.default_rng(2).uniform(1, 2, chosen.shape(8))
    pixel = (*[3] * (radiance.ndim - 1), 4)
    found = hf.EnvironmentMap(radiance, layout).radiance_toward(chosen.directions(radiance.shape)[pixel])
    np.testing.assert_allclose(found, radiance[pixel], rtol=1e-9)
