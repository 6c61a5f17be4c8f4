from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.correlation import Correlation

RANDOM = np.random.default_rng(7)
PEOPLE = [RANDOM.uniform(0, 1, (count, 9, 7)) for count in (3, 1, 4, 2)]


@pytest.fixture(scope="module")
def enrolled() -> Correlation:
    correlation = Correlation()
    correlation.enroll(PEOPLE)
    return correlation


def test_finds_whom_numpy_correlates_most(enrolled: Correlation) -> None:
    rows = np.concatenate(PEOPLE).reshape(10, -1)
    people = np.repeat(range(4), [3, 1, 4, 2])
    decisions = set()
    for query in RANDOM.uniform(0, 1, (60, 9, 7)):
        expected = people[np.corrcoef(rows, query.ravel())[-1, :-1].argmax()]
        assert enrolled.nearest(query) == expected
        decisions.add(int(expected))
    assert len(decisions) == 4


@given(gain=st.floats(1e-3, 1e3), offset=st.floats(-1, 1), person=st.integers(0, 3))
def test_brightness_and_contrast_change_nothing(enrolled: Correlation, gain: float, offset: float, person: int) -> None:
    assert enrolled.nearest(gain * (PEOPLE[person][0] + offset)) == person


def test_keeps_one_float32_a_pixel_and_photograph(enrolled: Correlation) -> None:
    assert enrolled.bytes_per_person == 10 * 63 * 4 // 4


def test_enrolling_again_replaces_everybody(enrolled: Correlation) -> None:
    again = Correlation()
    again.enroll(PEOPLE)
    again.enroll(PEOPLE[::-1])
    assert again.nearest(PEOPLE[0][0]) == 3


def test_people_without_contrast_are_refused_and_those_enrolled_stay() -> None:
    correlation = Correlation()
    correlation.enroll(PEOPLE)
    with pytest.raises(HarmonicFaceError, match=r"photographs: expected an image with contrast, got one of 0.5 every"):
        correlation.enroll([PEOPLE[0], np.full((1, 9, 7), 0.5)])
    assert correlation.nearest(PEOPLE[2][1]) == 2


@pytest.mark.parametrize("level", [0.0, 1.0, -2.5])
def test_a_photo_without_contrast_is_like_nobody(enrolled: Correlation, level: float) -> None:
    with pytest.raises(HarmonicFaceError, match="photo: expected an image with contrast, got one of"):
        enrolled.nearest(np.full((9, 7), level))
