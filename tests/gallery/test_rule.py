"""When a gallery names somebody."""

from __future__ import annotations

import numpy as np
import pytest

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.rule import DEFAULT_SCORE, DEFAULT_THRESHOLD, FARTHEST, Rule


def test_a_threshold_is_a_score_or_a_distance() -> None:
    assert (Rule().by_score, Rule().threshold) == (True, DEFAULT_SCORE)
    assert (Rule("harmonic9").by_score, Rule("harmonic9").threshold) == (False, DEFAULT_THRESHOLD)
    assert Rule(threshold=7.5).threshold == 7.5
    assert not Rule("linear3").ambient and Rule("ambient4").ambient


def test_who_is_near_or_clearly_nearer_is_known() -> None:
    rule = Rule("harmonic9", threshold=0.1, margin=1.5)
    assert rule.is_known(0.1, 1.0) and rule.is_known(FARTHEST, 1.5)
    assert not rule.is_known(0.11, 1.49) and not rule.is_known(FARTHEST + 0.01, 9.0)
    rule.margin = np.inf
    assert rule.is_known(0.1, 1.0) and not rule.is_known(0.11, 1e9)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"model": "magic"}, "model: expected one of default, "),
        ({"threshold": 0}, "threshold: expected"),
        ({"model": "harmonic9", "threshold": 1.1}, "threshold: expected"),
        ({"margin": 0.9}, "margin: expected a number of at least 1, got 0.9"),
        ({"shortlist": 1}, "shortlist: expected an integer of at least 2"),
    ],
)
def test_settings_that_make_no_sense(settings: dict, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        Rule(**settings)
