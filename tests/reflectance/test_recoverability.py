"""What reflections tell: verdicts against closed forms and against the scatter of actual recoveries."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harmonicface.errors import HarmonicFaceError
from harmonicface.harmonics.indexing import degrees
from harmonicface.reflectance.filters import lambertian_filter
from harmonicface.reflectance.phong import phong_filter
from harmonicface.reflectance.recoverability import recoverable_lighting, recoverable_reflectance
from harmonicface.reflectance.spectra import directional_spectrum, mirror_filter, uniform_spectrum


def test_a_matte_object_loses_odd_degrees_and_drowns_high_ones() -> None:
    report = recoverable_lighting(lambertian_filter(9), noise=0.03)
    assert report.recoverable == (0, 1, 2)
    assert report.ill_conditioned == (4, 6, 8)
    assert report.lost == (3, 5, 7, 9)
    assert_allclose(report.gains[[0, 1, 2, 4, 6]], [1, 1.5, 4, 24, 64], rtol=1e-14)
    assert_allclose(report.condition, 4, rtol=1e-14)


def test_a_mirror_tells_every_degree() -> None:
    report = recoverable_lighting(mirror_filter(50), noise=0.1)
    assert report.recoverable == tuple(range(51)) and report.condition == 1


@pytest.mark.parametrize("shininess", [25, 100, 400])
def test_phong_tells_light_up_to_the_root_of_the_shininess(shininess: int) -> None:
    # exp(-l^2 / 2s) reaches noise / tolerance = 0.02 at l = sqrt(2 s log 50) = 2.8 sqrt(s)
    told = recoverable_lighting(phong_filter(shininess, 100), noise=0.01).recoverable
    assert told == tuple(range(len(told)))
    assert abs(told[-1] / math.sqrt(shininess) - 2.8) < 0.2


def test_the_errors_are_those_of_actual_recoveries() -> None:
    random = np.random.default_rng(0)
    noise, order = 0.02, 6
    weights = lambertian_filter(order)[degrees(order)]
    light = directional_spectrum([1, 2, 2], order)
    seen = [0, 1, 2, 4, 6]
    scatter = {degree: [] for degree in seen}
    for _ in range(400):
        reflected = weights * light + noise * math.pi * light[0] * random.normal(size=len(light))
        for degree in seen:
            rows = degrees(order) == degree
            scatter[degree].append(reflected[rows] / weights[rows] - light[rows])
    found = [np.std(scatter[degree]) / light[0] for degree in seen]
    assert_allclose(found, recoverable_lighting(lambertian_filter(order), noise).errors[seen], rtol=0.07)


def test_light_of_natural_size_tells_less() -> None:
    falling = 1 / np.arange(1.0, 8.0)
    report = recoverable_lighting(phong_filter(10, 6), 0.1, spectrum=falling)
    assert_allclose(report.errors, recoverable_lighting(phong_filter(10, 6), 0.1).errors / falling, rtol=1e-14)
    assert len(report.recoverable) < len(recoverable_lighting(phong_filter(10, 6), 0.1).recoverable)


def test_a_lamp_tells_every_degree_of_a_material_and_a_sky_one() -> None:
    lamp = recoverable_reflectance(directional_spectrum([1, 1, 0], 8), noise=0.1)
    assert lamp.recoverable == tuple(range(9))
    assert_allclose(lamp.gains, 1 / np.sqrt(2 * np.arange(9) + 1), rtol=1e-12)
    sky = recoverable_reflectance(uniform_spectrum(8), noise=0.1)
    assert sky.recoverable == (0,) and sky.lost == tuple(range(1, 9))


def test_rounding_of_an_exact_zero_is_lost_and_not_a_number() -> None:
    light = directional_spectrum([0, 0, 1], 2)
    light[1:4] = 1e-17
    assert recoverable_reflectance(light, noise=0.1).lost == (1,)


def test_a_material_that_the_light_hardly_tells() -> None:
    light = directional_spectrum([0, 0, 1], 2)
    light[4:] *= 1e-3
    report = recoverable_reflectance(light, noise=0.01)
    assert report.ill_conditioned == (2,) and report.verdicts[2] == "ill-conditioned"


def test_the_table() -> None:
    table = str(recoverable_lighting(lambertian_filter(3), noise=0.1))
    assert table.splitlines()[0].split() == ["lighting", "factor", "gain", "error", "verdict"]
    assert table.splitlines()[3].split() == ["degree", "2", "0.7854", "4", "40.0%", "recoverable"]
    assert table.splitlines()[4].split() == ["degree", "3", "0.0000", "inf", "inf", "lost"]
    assert len({len(line.split("  ")[0]) for line in table.splitlines()[1:-1]}) == 1


def test_nothing_recoverable_has_no_condition() -> None:
    assert recoverable_lighting([1.0, 0.5], noise=0.9).condition == math.inf


def test_a_general_material_tells_by_any_of_its_coefficients() -> None:
    rho = np.zeros((4, 3, 2), complex)
    rho[0, 0, 0], rho[1, 2, 1], rho[3] = 2.0, 1j, 0.1 + 0.1j
    report = recoverable_lighting(rho, noise=0.1)
    assert_allclose(report.factors, [2, 1, 0, math.sqrt(6 * 0.02)], rtol=1e-14)
    assert report.lost == (2,)


def test_errors() -> None:
    with pytest.raises(HarmonicFaceError, match="filter: expected numbers for each degree, got"):
        recoverable_lighting(np.ones((0, 2)), 0.1)
    with pytest.raises(HarmonicFaceError, match="lighting: expected a degree 0 that is not nothing, got 0"):
        recoverable_lighting([0.0, 1.0], 0.1)
    with pytest.raises(HarmonicFaceError, match="reflectance: expected a degree 0 that is not nothing, got 0"):
        recoverable_reflectance(np.zeros(4), 0.1)
    with pytest.raises(HarmonicFaceError, match="spectrum: expected 2 numbers above 0"):
        recoverable_lighting([1.0, 1.0], 0.1, spectrum=[1.0])
    with pytest.raises(HarmonicFaceError, match="spectrum: expected 2 numbers above 0"):
        recoverable_lighting([1.0, 1.0], 0.1, spectrum=[1.0, 0.0])
    with pytest.raises(HarmonicFaceError, match="noise: expected a finite number above 0"):
        recoverable_lighting([1.0], 0.0)
    with pytest.raises(HarmonicFaceError, match="tolerance: expected a finite number above 0"):
        recoverable_lighting([1.0], 0.1, tolerance=-1)
    with pytest.raises(HarmonicFaceError, match=r"light: expected coefficients of shape \(k,\)"):
        recoverable_reflectance(np.ones((4, 3)), 0.1)
    with pytest.raises(HarmonicFaceError, match=r"coefficients: expected \(order \+ 1\)\^2"):
        recoverable_reflectance(np.ones(5), 0.1)
