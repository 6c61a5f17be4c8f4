import dataclasses

import numpy as np
import pytest

from harmonicface.people.complexion import draw_complexion
from harmonicface.people.hair import hair_cover
from harmonicface.people.mottling import draw_knots, edge, field_at
from harmonicface.people.skin import SkinPixels, albedo


def face(step=1.0):
    x, y = (grid.ravel() for grid in np.meshgrid(np.arange(-70.0, 70, step), np.arange(34.0, -108, -step)))
    return x, y


def reflectance(complexion, x, y, blur=0.3):
    outside = np.zeros(x.shape)
    return albedo(complexion, SkinPixels(x, y, outside, outside, outside > 0, blur))


@pytest.fixture
def plain():
    complexion = draw_complexion(np.random.default_rng(0), 0.0, 0.0)
    bare = dict.fromkeys(("beard_density", "moustache_density", "chin_beard_density", "stubble_density"), 0.0)
    return dataclasses.replace(complexion, **bare, fringe=90.0, temple_hair=100.0, hair=0.03, brow_density=0.9)


def at(complexion, x, y):
    return float(reflectance(complexion, np.array([x]), np.array([y]))[0])


def test_brows_lips_and_nostrils_are_darker_than_cheeks(plain):
    cheek = np.median(reflectance(plain, np.linspace(30, 50, 30), np.full(30, -35.0)))
    brow = np.median(reflectance(plain, np.linspace(20, 40, 40), np.full(40, plain.brow_height)))
    assert brow < 0.5 * cheek
    lips = dataclasses.replace(plain, lips=0.6)
    assert np.median(reflectance(lips, np.linspace(-8, 8, 30), np.full(30, -76.0))) < 0.8 * cheek
    assert at(plain, 7.6, -41.2) < 0.5 * cheek


def test_tone_scales_bare_skin(plain):
    x, y = np.linspace(25, 50, 50), np.full(50, -40.0)
    light, dark = (reflectance(dataclasses.replace(plain, tone=tone), x, y) for tone in (0.6, 0.3))
    assert np.allclose(light, 2 * dark, rtol=1e-5)


@pytest.mark.parametrize(
    ("name", "x", "y"),
    [
        ("beard_density", 45.0, -85.0),
        ("moustache_density", 8.0, -56.0),
        ("chin_beard_density", 0.0, -95.0),
        ("stubble_density", 45.0, -85.0),
    ],
)
def test_beards_grow_where_they_are_named(plain, name, x, y):
    bearded = dataclasses.replace(plain, **{name: 0.8})
    xs, ys = x + np.linspace(-2, 2, 40), np.full(40, y)
    assert hair_cover(bearded, xs, ys, 0.3)[0].mean() > 0.6
    assert hair_cover(plain, xs, ys, 0.3)[0].max() == 0
    cheek, nose = (hair_cover(bearded, np.full(9, x), np.full(9, y), 0.3)[0] for x, y in ((35, -30), (0, -30)))
    assert cheek.max() == nose.max() == 0


def test_fringe_and_temples(plain):
    hairy = dataclasses.replace(plain, fringe=26.0, temple_hair=66.0)
    assert hair_cover(hairy, np.zeros(5), np.full(5, 34.0), 0.3)[0].min() > 0.8
    assert hair_cover(hairy, np.full(5, -74.0), np.full(5, 10.0), 0.3)[0].min() > 0.8
    assert hair_cover(plain, np.zeros(5), np.full(5, 34.0), 0.3)[0].max() == 0


def test_eyes_have_pupil_iris_and_white(plain):
    inward = np.array([0.0, 4.0, 9.5])
    x, y = 31.3 + inward, np.full(3, -1.5)
    pixels = SkinPixels(x, y, inward, np.zeros(3), np.ones(3, bool), 0.1)
    pupil, iris, white = albedo(plain, pixels)
    assert pupil < 0.03 < iris < 0.3 < white


def test_a_mole_is_spread_by_the_blur_but_keeps_its_sum(plain):
    x, y = face(0.5)
    marks = np.zeros_like(plain.marks)
    marks[0] = 40.0, -40.0, 1.2, -0.5
    sums = []
    for blur in (0.2, 2.0):
        clean = reflectance(dataclasses.replace(plain, marks=np.zeros_like(marks)), x, y, blur)
        marked = reflectance(dataclasses.replace(plain, marks=marks), x, y, blur)
        sums.append(np.log(marked.astype(float) / clean).sum() * 0.25)
    wanted = -0.5 * 2 * np.pi * 1.2**2
    assert np.allclose(sums, wanted, rtol=0.02)


def test_albedo_stays_in_range_for_all_kinds_of_people():
    x, y = face(2.0)
    for seed in range(40):
        rng = np.random.default_rng(seed)
        values = reflectance(draw_complexion(rng, *rng.normal(0, 1.5, 2)), x, y)
        assert values.dtype == np.float32 and values.min() >= 0.01 and values.max() <= 0.95


def test_field_goes_through_its_knots():
    knots = draw_knots(np.random.default_rng(0), 10.0, 20.0)
    rows, columns = np.meshgrid(np.arange(2, 6), np.arange(3, 9), indexing="ij")
    x, y = -84 + 10.0 * columns.ravel(), -124 + 20.0 * rows.ravel()
    assert np.allclose(field_at(knots, x, y, 10.0, 20.0), knots[rows, columns].ravel(), atol=1e-5)


def test_field_of_more_pixels_than_a_line_of_opencv():
    knots = draw_knots(np.random.default_rng(0), 10.0, 10.0)
    x = np.linspace(-60, 60, 70_001)
    many = field_at(knots, x, np.zeros_like(x), 10.0, 10.0)
    assert len(many) == len(x)
    assert np.allclose(many[::7000], field_at(knots, x[::7000], np.zeros(11), 10.0, 10.0), atol=1e-6)


def test_edge_is_half_at_the_border():
    assert np.array_equal(edge(np.array([-3.0, 0.0, 3.0]), 2.0), [0.0, 0.5, 1.0])
