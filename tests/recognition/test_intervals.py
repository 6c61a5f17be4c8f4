"""Intervals of rates: by their definitions, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom, norm

from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.intervals import rate


@given(st.integers(1, 60), st.data())
def test_the_exact_ends_make_the_count_improbable(trials: int, data: st.DataObject) -> None:
    events = data.draw(st.integers(0, trials))
    found = rate(events, trials)
    assert found.low <= found.value <= found.high
    if events:
        assert binom.sf(events - 1, trials, found.low) == pytest.approx(0.025, abs=1e-6)
    if events < trials:
        assert binom.cdf(events, trials, found.high) == pytest.approx(0.025, abs=1e-6)


@given(st.integers(1, 1000), st.data())
def test_wilsons_ends_solve_his_equation(trials: int, data: st.DataObject) -> None:
    events = data.draw(st.integers(0, trials))
    found = rate(events, trials, confidence=0.9, method="wilson")
    for end in (found.low, found.high):
        squared = norm.ppf(0.95) ** 2 * end * (1 - end) / trials
        assert (found.value - end) ** 2 == pytest.approx(squared, abs=1e-9)


def test_nothing_and_everything_reach_the_ends() -> None:
    assert rate(0, 10).low == 0 and rate(0, 10).high == pytest.approx(1 - 0.025**0.1)
    assert rate(10, 10).high == 1 and rate(10, 10).low == pytest.approx(0.025**0.1)


def test_the_exact_interval_holds_the_truth_as_often_as_it_says() -> None:
    truth, trials = 0.03, 80
    covered = sum(
        binom.pmf(events, trials, truth)
        for events in range(trials + 1)
        if rate(events, trials).low <= truth <= rate(events, trials).high
    )
    assert covered >= 0.95


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((1, 0), "trials: expected an integer of at least 1, got int 0"),
        ((-1, 5), "events: expected an integer of at least 0"),
        ((6, 5), "events: expected at most as many as trials, 5, got 6"),
        ((1, 5, 1.5), "confidence: expected a number from 0 to 1, got 1.5"),
        ((1, 5, 0.9, "wald"), "method: expected one of exact, wilson, got 'wald'"),
        ((np.nan, 5), "events: expected an integer of at least 0"),
    ],
)
def test_bad_input(arguments: tuple, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        rate(*arguments)
