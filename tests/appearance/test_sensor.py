"""A camera: how much burns out, how much noise there is, how many levels."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

import harmonicface as hf

RAMP = np.linspace(0.0, 7.0, 40_001)[None, :]


def clean(picture: np.ndarray, **settings: float) -> np.ndarray:
    return hf.photograph(picture, 0, **{"noise": 0.0, "saturated": 0.0, **settings})


@pytest.mark.parametrize("bits", [1, 2, 8, 16])
def test_values_are_the_levels_of_the_converter(bits: int) -> None:
    levels = clean(RAMP, bits=bits) * (2**bits - 1)
    assert_allclose(levels, np.round(levels), rtol=0, atol=2e-3)
    assert len(np.unique(np.round(levels))) == min(2**bits, RAMP.size)
    assert_allclose(levels / (2**bits - 1), RAMP / 7, rtol=0, atol=0.5 / (2**bits - 1) + 1e-6)


@pytest.mark.parametrize("share", [0.0, 0.01, 0.3])
def test_a_share_of_the_lit_pixels_burns_out(share: float) -> None:
    picture = np.concatenate([RAMP, np.zeros_like(RAMP)])  # what is dark does not count
    photo = clean(picture, saturated=share, bits=16)
    assert_allclose((photo[0] == 1).mean(), share, atol=1e-3)
    assert not photo[1].any()


def test_noise_has_the_deviation_it_is_said_to_have() -> None:
    flat = np.full((200, 200), 2.0)
    flat[0, 0] = 4.0  # full scale, so that the rest is in the middle of it
    photo = hf.photograph(flat, 1, noise=0.05, saturated=0.0, bits=16)
    rest = photo.ravel()[1:]
    assert_allclose(rest.mean(), 0.5, atol=5 * 0.05 / 200)
    assert_allclose(rest.std(), 0.05, rtol=0.02)
    neighbours = np.corrcoef(rest[:-1], rest[1:])[0, 1]
    assert abs(neighbours) < 5 / 200


def test_the_same_seed_is_the_same_photograph() -> None:
    picture = hf.render(hf.synthetic_person(0, size=16), hf.lights.directional([1, 1, 1]))
    first, second = hf.photograph(picture, 5), hf.photograph(picture, np.random.default_rng(5))
    assert_array_equal(first, second)
    assert (first.dtype, first.shape) == (np.float32, picture.shape)
    assert not np.array_equal(first, hf.photograph(picture, 6))
    generator = np.random.default_rng(5)
    assert not np.array_equal(hf.photograph(picture, generator), hf.photograph(picture, generator))


@settings(deadline=None, max_examples=25)
@given(st.floats(1e-6, 1e6))
def test_exposure_undoes_brightness(factor: float) -> None:
    picture = np.random.default_rng(0).uniform(0, 1, (9, 9))
    assert_allclose(clean(factor * picture), clean(picture), rtol=0, atol=1.01 / 255)


def test_colours_share_one_exposure() -> None:
    photo = clean(np.stack([RAMP, RAMP / 2, RAMP / 4], axis=-1), bits=16)
    assert_allclose(photo[..., 1], photo[..., 0] / 2, rtol=0, atol=2e-5)
    assert_allclose(photo[..., 2], photo[..., 0] / 4, rtol=0, atol=2e-5)


@pytest.mark.parametrize("noise", [0.01, 0.3])
def test_nothing_leaves_the_range(noise: float) -> None:
    photo = hf.photograph(RAMP, 0, noise=noise)
    assert (photo.min(), photo.max()) == (0.0, 1.0)


@pytest.mark.parametrize(
    ("picture", "message"),
    [
        ([[0.0, 0.0]], "picture: expected a picture of at least 0 with some light in it, got values from 0 to 0"),
        ([[-1.0, 2.0]], "picture: expected a picture of at least 0 .*, got values from -1 to 2"),
        ([[np.nan, 1.0]], "picture: expected finite numbers"),
        ([1.0], "picture: expected an image"),
    ],
)
def test_pictures_that_no_camera_sees(picture: list, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        hf.photograph(picture, 0)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"noise": -0.1}, "camera: expected noise >= 0, .*, got noise=-0.1"),
        ({"noise": np.inf}, "camera: expected noise >= 0"),
        ({"noise": np.nan}, "camera: expected noise >= 0"),
        ({"saturated": 1.0}, "camera: expected .* got noise=0.01, saturated=1.0"),
        ({"saturated": -0.1}, "saturated: expected a number from 0 to 1, got -0.1"),
        ({"bits": 0}, "bits: expected an integer of at least 1, got int 0"),
        ({"bits": 17}, "camera: expected .* bits=17"),
        ({"bits": 2.5}, "bits: expected an integer of at least 1, got float 2.5"),
        ({"rng": "x"}, "rng: expected an integer of at least 0, got str 'x'"),
    ],
)
def test_settings_that_no_camera_has(setting: dict, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        hf.photograph(**{"picture": [[1.0]], "rng": 0, **setting})
