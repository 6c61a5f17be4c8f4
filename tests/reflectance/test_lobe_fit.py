"""Shininess and roughness from pictures of a sphere: sure under a lamp, honest under a cloudy sky."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.basis import real_harmonics
from harmonicface.reflectance.lobe_fit import LobeFit, fit_roughness, fit_shininess
from harmonicface.reflectance.microfacet import microfacet_filter, microfacet_lobe
from harmonicface.reflectance.phong import phong_filter, phong_lobe
from harmonicface.reflectance.spectra import apply_filter, directional_spectrum, uniform_spectrum

ORDER = 12
CASES = [
    pytest.param(fit_shininess, phong_filter, phong_lobe, 50.0, id="shininess"),
    pytest.param(fit_roughness, microfacet_filter, microfacet_lobe, 0.1, id="roughness"),
]


def cloudy_sky(order: int) -> np.ndarray:
    """The overcast sky of the lighting engineers, (1 + 2 cos) / 3 above the horizon, as bright as a unit lamp."""
    nodes, weights = np.polynomial.legendre.leggauss(order + 8)
    heights, shares = (nodes + 1) / 2, weights / 2
    polar = np.stack([np.sqrt(1 - heights**2), 0 * heights, heights], axis=-1)
    light = np.zeros((order + 1) ** 2)
    zonal = np.arange(order + 1) * np.arange(1, order + 2)
    light[zonal] = 2 * np.pi * real_harmonics(polar, order)[zonal] @ (shares * (1 + 2 * heights) / 3)
    return light * uniform_spectrum(0)[0] / light[0]


@pytest.mark.parametrize(("fit", "filter_", "lobe", "width"), CASES)
def test_two_percent_under_a_lamp_from_noisy_pictures(fit, filter_, lobe, width: float) -> None:
    # a picture of the lobe itself, of all degrees, on 60 x 120 directions, with noise of 1 % of its brightest pixel
    heights, weights = np.polynomial.legendre.leggauss(60)
    azimuths = np.arange(120) * np.pi / 60
    across = np.sqrt(1 - heights**2)[:, None]
    parts = across * np.cos(azimuths), across * np.sin(azimuths), heights[:, None]
    directions = np.stack(np.broadcast_arrays(*parts), axis=-1).reshape(-1, 3)
    shares = np.repeat(weights * np.pi / 60, 120)
    lamp = np.array([2.0, 1.0, 2.0]) / 3
    picture = lobe(directions @ lamp, width)
    harmonics = real_harmonics(directions, ORDER)
    random = np.random.default_rng(0)
    for _ in range(10):
        noisy = picture + 0.01 * picture.max() * random.normal(size=len(picture))
        answer = fit(harmonics @ (shares * noisy), directional_spectrum(lamp, ORDER))
        assert abs(answer.value / width - 1) < 0.02
        assert answer.std / width < 0.02 and answer.gain < 0.3


@pytest.mark.parametrize("strength", [1.0, None])
@pytest.mark.parametrize("light", [directional_spectrum([1, 2, 2], ORDER), cloudy_sky(ORDER)], ids=["lamp", "cloudy"])
@pytest.mark.parametrize(("fit", "filter_", "lobe", "width"), CASES)
def test_the_interval_covers_the_actual_value(fit, filter_, lobe, width: float, light, strength) -> None:
    reflected = apply_filter(filter_(width, ORDER), light)
    noise = 0.01 * reflected[0]
    random = np.random.default_rng(7)
    runs = 120
    answers = [fit(reflected + noise * random.normal(size=light.shape), light, noise, strength) for _ in range(runs)]
    inside = sum(answer.low <= width <= answer.high for answer in answers)
    assert inside >= 0.95 * runs - 3 * math.sqrt(runs * 0.95 * 0.05)  # three standard deviations below 95 %
    actual = np.sqrt(np.mean([math.log(answer.value / width) ** 2 for answer in answers]))
    reported = np.median([answer.std / answer.value for answer in answers])
    assert 0.7 < reported / actual < 1.4


@pytest.mark.parametrize(("fit", "filter_", "lobe", "width"), CASES)
def test_a_cloudy_sky_is_worse_than_a_lamp_by_much(fit, filter_, lobe, width: float) -> None:
    lamp, sky = (
        fit(apply_filter(filter_(width, ORDER), light), light, noise=1e-4)
        for light in (directional_spectrum([0, 0, 1], ORDER), cloudy_sky(ORDER))
    )
    assert 50 < sky.std / lamp.std < 100  # at the same noise and the same brightness
    assert sky.gain > 10 * lamp.gain


def test_the_softer_the_light_the_worse() -> None:
    reflected = {order: directional_spectrum([0, 0, 1], order) for order in (1, 2, 4, 8, 16)}
    gains = [
        fit_shininess(apply_filter(phong_filter(100, order), light), light, 1e-3).gain
        for order, light in reflected.items()
    ]
    assert (np.diff(gains) < 0).all() and gains[0] > 40 * gains[-1]


@pytest.mark.parametrize(("fit", "filter_", "lobe", "width"), CASES)
@pytest.mark.parametrize("factor", [0.2, 1.0, 5.0])
def test_exact_without_noise_also_with_an_unknown_strength(fit, filter_, lobe, width: float, factor: float) -> None:
    light = directional_spectrum([1, -1, 0.3], 20)
    reflected = 0.37 * apply_filter(filter_(width * factor, 20), light)
    answer = fit(reflected, light, noise=0.0, strength=None)
    assert_allclose(answer.value, width * factor, rtol=1e-7)
    assert_allclose(answer.strength, 0.37, rtol=1e-7)
    assert answer.std == 0 and answer.noise == 0
    assert_allclose([answer.low, answer.high], answer.value, rtol=1e-6)


@pytest.mark.parametrize(("fit", "filter_", "lobe", "width"), CASES)
def test_the_noise_is_seen_in_the_residual(fit, filter_, lobe, width: float) -> None:
    light = directional_spectrum([1, 1, 1], 20)
    noise = 0.003 * np.random.default_rng(3).normal(size=light.shape)
    assert_allclose(fit(apply_filter(filter_(width, 20), light) + noise, light).noise, 0.003, rtol=0.1)


@pytest.mark.parametrize("strength", [1.0, None])
def test_the_noise_is_the_residual_for_each_degree_of_freedom(strength) -> None:
    light = directional_spectrum([1, 1, 1], 3)
    reflected = apply_filter(phong_filter(6, 3), light) + 0.02 * np.random.default_rng(4).normal(size=16)
    answer = fit_shininess(reflected, light, strength=strength)
    rest = reflected - answer.strength * apply_filter(phong_filter(answer.value, 3), light)
    assert_allclose(answer.noise**2 * (15 if strength else 14), rest @ rest, rtol=1e-9)


def test_the_standard_deviation_is_the_slope_of_the_answer() -> None:
    # each coefficient's change moves the answer by its row of the pseudo-inverse; their squares add up
    light = directional_spectrum([1, 2, 3], 3)
    reflected = apply_filter(phong_filter(8.0, 3), light)
    for strength in (1.0, None):
        step = 1e-5
        moves = [(fit_shininess(reflected + step * row, light, 1.0, strength).value - 8.0) / step for row in np.eye(16)]
        assert_allclose(fit_shininess(reflected, light, 1.0, strength).std, np.linalg.norm(moves), rtol=1e-3)


def test_an_interval_without_an_end() -> None:
    light = directional_spectrum([0, 0, 1], 2)
    shiny = fit_shininess(apply_filter(phong_filter(1000, 2), light), light, noise=0.01)
    assert shiny.high == math.inf and 1 < shiny.low < 1000
    smooth = fit_roughness(apply_filter(microfacet_filter(0.02, 2), light), light, noise=0.01)
    assert smooth.low == 0 and 0.02 < smooth.high < 1


@pytest.mark.parametrize("strength", [1.0, None])
@pytest.mark.parametrize("noise", [0.0, 1e-3, None])
def test_a_mirror_is_at_the_end_of_the_range(noise: float | None, strength: float | None) -> None:
    light = directional_spectrum([1, 2, 3], 8)
    shiny, smooth = fit_shininess(light, light, noise, strength), fit_roughness(light, light, noise, strength)
    assert_allclose([shiny.value, smooth.value], [1e6, 1e-3], rtol=1e-12)
    assert shiny.std == math.inf and shiny.high == math.inf and 1 < shiny.low <= 1e6 * (1 + 1e-12)
    assert smooth.std == math.inf and smooth.low == 0 and 1e-3 * (1 - 1e-12) <= smooth.high < 1


def test_light_from_nowhere_in_particular_is_at_the_other_end() -> None:
    light = directional_spectrum([1, 2, 3], 8)
    spread = apply_filter(phong_filter(0.01, 8), light)
    answer = fit_shininess(spread, light, noise=0.0)
    assert_allclose(answer.value, 0.05, rtol=1e-12)
    assert answer.std == math.inf and answer.low == 0 and 0.05 * (1 - 1e-12) <= answer.high < 0.06
    rough = fit_roughness(apply_filter(microfacet_filter(5.0, 8), light), light, noise=0.0)
    assert_allclose(rough.value, 3.0, rtol=1e-12)
    assert rough.std == math.inf and rough.high == math.inf and 2.9 < rough.low <= 3.0 * (1 + 1e-12)


def test_a_sentence() -> None:
    answer = LobeFit("shininess", 50.0, 1.0, 48.0, math.inf, 1.0, 0.01, 2.5)
    assert str(answer) == "shininess 50 +- 1 (95 %: 48 to inf), noise amplified 2.5 times"


def test_errors() -> None:
    light = directional_spectrum([0, 0, 1], 2)
    with pytest.raises(HarmonicFaceError, match="light: expected degrees that tell of the shininess, got light that"):
        fit_shininess(apply_filter(phong_filter(5, 2), uniform_spectrum(2)), uniform_spectrum(2), 0.1)
    with pytest.raises(HarmonicFaceError, match="light: expected degrees that tell of the roughness, got light that"):
        fit_roughness(np.zeros(9), np.zeros(9), 0.1)
    with pytest.raises(HarmonicFaceError, match="reflected: expected as many coefficients as light has"):
        fit_shininess(np.ones(4), light)
    with pytest.raises(HarmonicFaceError, match="reflected: expected as many coefficients as light has"):
        fit_shininess(np.ones((4, 3)), np.ones((4, 3)))
    with pytest.raises(HarmonicFaceError, match=r"coefficients: expected \(order \+ 1\)\^2"):
        fit_shininess(np.ones(5), np.ones(5))
    with pytest.raises(HarmonicFaceError, match="strength: expected a finite number above 0"):
        fit_shininess(light, light, 0.1, strength=0.0)
    with pytest.raises(HarmonicFaceError, match="noise: expected a finite number of at least 0"):
        fit_shininess(light, light, noise=-0.1)
    for uniform in ([1.0], uniform_spectrum(2)):
        with pytest.raises(
            HarmonicFaceError, match="light: expected degrees that tell of the roughness, got light that"
        ):
            fit_roughness(0.9 * np.array(uniform), uniform)
    for fit in (fit_shininess, fit_roughness):
        with pytest.raises(HarmonicFaceError, match="reflected: expected light that came back, got only zeros"):
            fit(np.zeros(9), light)
    with pytest.raises(HarmonicFaceError, match="reflected: expected finite numbers"):
        fit_roughness(np.full(9, np.nan), light)
    with pytest.raises(HarmonicFaceError, match="light: expected finite numbers"):
        fit_roughness(light, np.full(9, np.inf))
