"""Coats: their lobe and their filter are one thing, and nothing outside its range is taken."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.reflectance.fresnel import fresnel
from harmonicface.reflectance.materials import HIGHEST_DEGREE, Material, Microfacet, Phong

NODES = np.polynomial.legendre.leggauss(400)
COATS = [Phong(0.5, 1), Phong(20, 0.1), Phong(333.3, 0), Microfacet(0.3), Microfacet(0.05, 1.5, 0.5), Microfacet(2)]


@pytest.mark.parametrize("coat", COATS, ids=repr)
def test_the_filter_is_the_lobes(coat: Material) -> None:
    cosines, weights = (NODES[0] + 1) / 2, NODES[1] / 2  # the lobe ends where the cosine is 0
    expected = 2 * math.pi * np.polynomial.legendre.legvander(cosines, 30).T @ (weights * coat.lobe(cosines))
    assert_allclose(coat.filter(30), expected, atol=1e-6)


@pytest.mark.parametrize("coat", COATS, ids=repr)
def test_what_is_left_above_the_highest_degree(coat: Material) -> None:
    highest = coat.highest_degree()
    factors = np.abs(coat.filter(2 * HIGHEST_DEGREE))
    assert factors[highest + 1 :].max() <= 0.01 * factors[0] < factors[highest]


@pytest.mark.parametrize("coat", [Phong(200, 1), Microfacet(0.05)], ids=repr)
def test_the_width_is_that_of_the_peak(coat: Material) -> None:
    small = coat.width / 10
    assert_allclose(coat.lobe(math.cos(small)) / coat.lobe(1.0), math.exp(-(0.1**2) / 2), rtol=1e-4)


def test_the_widest_lobes() -> None:
    assert Phong(0, 1).width == Microfacet(50).width == math.pi / 2


def test_how_strong() -> None:
    cosines = np.linspace(0, 1, 7, dtype=np.float32)
    assert (Phong(3, 0.25).reflectance(cosines) == 0.25).all()
    assert Phong(3, 0.25).reflectance(cosines).dtype == np.float32
    assert_allclose(Microfacet(0.3, 1.5, 0.5).reflectance(cosines), 0.5 * fresnel(cosines, 1.5), rtol=1e-15)


@pytest.mark.parametrize("coat", [Phong(1e5, 1), Microfacet(0.005)], ids=repr)
def test_lobes_too_narrow_for_harmonics(coat: Material) -> None:
    with pytest.raises(
        hf.HarmonicFaceError, match="material: expected a lobe wide enough for harmonics up to degree 200"
    ):
        coat.highest_degree()


@pytest.mark.parametrize(
    ("kind", "numbers", "message"),
    [
        (Phong, (-1, 0.5), "shininess: expected a finite number of at least 0, got -1"),
        (Phong, ("wet", 0.5), "shininess: expected a number of at least 0, got str"),
        (Phong, (10, 1.5), "strength: expected a number from 0 to 1, got 1.5"),
        (Phong, (10, np.nan), "strength: expected a number from 0 to 1, got nan"),
        (Microfacet, (0,), "roughness: expected a finite number above 0"),
        (Microfacet, (101,), "roughness: expected radians from 1e-100 to 100"),
        (Microfacet, (0.3, 1.0), "refractive_index: expected a number above 1 to 100, got 1"),
        (Microfacet, (0.3, 1.4, -0.1), "strength: expected a number from 0 to 1, got -0.1"),
    ],
)
def test_what_is_no_coat(kind: type[Phong | Microfacet], numbers: tuple[float, ...], message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        kind(*numbers)


def test_the_usual_strength() -> None:
    assert Phong(50) == Phong(50, 0.04)
