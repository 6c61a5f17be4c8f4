import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harmonicface.io.colour import luminance
from harmonicface.people.complexion import draw_complexion
from harmonicface.people.skin import Paint
from harmonicface.people.skin_colour import LARGEST, Pigments, colours, draw_pigments

PLAIN = Pigments(blood=1.0, carotene=0.0, red_hair=0.0, green_iris=0.0)


@pytest.fixture(scope="module")
def complexion():
    return draw_complexion(np.random.default_rng(0), 0.0, 0.0)


def paint_of(albedo=0.3, lips=0.0, hair=0.0, white=0.0, iris=0.0):
    return Paint(*(np.array([value]) for value in (albedo, lips, hair, white, iris)))


def colour(complexion, pigments=PLAIN, redness=0.0, **shares):
    return colours(complexion, pigments, paint_of(**shares), np.array([redness]))[0]


@given(seed=st.integers(0, 2**32), albedo=st.floats(0.02, 0.4), redness=st.floats(-0.5, 1.2), hair=st.floats(0, 1))
def test_luminance_is_the_painted_grey(seed, albedo, redness, hair):
    rng = np.random.default_rng(seed)
    complexion = draw_complexion(rng, 0.0, 0.0)
    found = colours(complexion, draw_pigments(rng), paint_of(albedo, hair=hair), np.array([redness]))
    assert 0 < found.min() <= found.max() <= LARGEST
    if found.max() < LARGEST and found.min() > 0.0051:
        assert luminance(found) == pytest.approx(albedo, rel=1e-12)


def test_skin_is_redder_than_it_is_green_and_blue(complexion):
    for tone in (0.12, 0.34, 0.56):
        red, green, blue = colour(dataclasses.replace(complexion, tone=tone), albedo=tone)
        assert red > green > blue > 0.2 * red


def test_dark_skin_is_more_saturated(complexion):
    light, dark = (colour(dataclasses.replace(complexion, tone=tone), albedo=tone) for tone in (0.5, 0.1))
    assert dark[0] / dark[2] > 1.3 * light[0] / light[2]


def test_blood_and_lips_add_red(complexion):
    pale, flushed, lips = colour(complexion), colour(complexion, redness=1.0), colour(complexion, lips=1.0)
    assert flushed[0] / flushed[1] > 1.2 * pale[0] / pale[1]
    assert lips[0] / lips[1] > 1.2 * pale[0] / pale[1]


def test_hair_is_black_blond_or_red(complexion):
    black, blond = (colour(dataclasses.replace(complexion, hair=hair), hair=1.0) for hair in (0.03, 0.25))
    red = colour(complexion, dataclasses.replace(PLAIN, red_hair=1.0), hair=1.0)
    assert black[0] / black[2] < 2 < blond[0] / blond[2] < red[0] / red[2]


def test_irises_are_brown_blue_or_green(complexion):
    brown, light = (dataclasses.replace(complexion, iris=iris) for iris in (0.04, 0.2))
    blue, green = (colour(light, dataclasses.replace(PLAIN, green_iris=share), iris=1.0) for share in (0.0, 1.0))
    assert np.argmax(colour(brown, iris=1.0)) == 0
    assert np.argmax(blue) == 2
    assert np.argmax(green) == 1


def test_the_white_of_the_eye_is_white(complexion):
    assert np.ptp(colour(complexion, white=1.0, albedo=0.5)) < 0.1
