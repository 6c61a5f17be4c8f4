"""How high strangers score: closed forms, and the rate that a threshold promises on people who resemble each other."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm, t

from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.strangers import Strangers


def scores_between(rng: np.random.Generator, strangers: int, enrolled: int, photographs: int) -> list[np.ndarray]:
    """Scores with a part of the stranger, of the person enrolled, of the pair, and of the photograph."""
    pair = 0.4 * rng.normal(size=(strangers, 1)) + 0.4 * rng.normal(size=enrolled)
    pair = pair + 0.7 * rng.normal(size=(strangers, enrolled))
    return [one + 0.4 * rng.normal(size=(photographs, enrolled)) for one in pair]


def test_one_photograph_of_each_is_the_prediction_of_a_sample() -> None:
    values = np.array([1.0, 2.0, 4.0, 9.0])
    found = Strangers.of([[[value]] for value in values], enrolled=1)
    assert found.freedom == 3  # as of four numbers
    expected = values.mean() + values.std(ddof=1) * np.sqrt(1 + 1 / 4) * t.isf(0.001, 3)
    assert found.threshold(0.001, 1) == pytest.approx(expected)


def test_photographs_of_a_pair_spread_too() -> None:
    found = Strangers.of([[[0.0, 1.0], [2.0, 1.0]], [[1.0, 4.0], [3.0, 4.0]]], enrolled=2)
    pairs, within = np.array([1, 1, 2, 4]), np.array([1, 0, 1, 0])
    assert found.mean == 2
    assert found.deviation**2 == pytest.approx((pairs.var(ddof=1) + within.mean()) * 1.25)
    assert found.best == (1.0, 2.0, 4.0, 4.0)


def test_many_people_of_a_bell_give_its_quantile() -> None:
    rng = np.random.default_rng(0)
    found = Strangers.of([rng.normal(3, 2, (1, 300)) for _ in range(300)], enrolled=300)
    assert found.fmr(norm.isf(0.001, 3, 2)) == pytest.approx(0.001, rel=0.1)


def test_threshold_and_rate_are_inverse() -> None:
    found = Strangers(0.5, 2.0, 12, (0.0,))
    for people in (1, 30, 10**5):
        assert found.fpir(found.threshold(0.02, people), people) == pytest.approx(0.02)


def test_more_people_need_a_higher_threshold() -> None:
    found = Strangers(0.0, 1.0, 8, (0.0,))
    thresholds = [found.threshold(0.01, people) for people in (1, 10, 100)]
    assert thresholds == sorted(thresholds) and len(set(thresholds)) == 3
    assert found.fpir(2.0, 10) < found.fpir(2.0, 100) < 1


def test_what_was_seen_is_kept_out() -> None:
    assert Strangers(0.0, 1.0, 100, (1.0, 50.0)).threshold(0.01, 1) > 50
    assert Strangers(0.0, 1.0, 100, (1.0, 50.0)).threshold(0.5, 1) < 50


@pytest.mark.parametrize("people", [4, 8])
def test_the_rate_is_kept_on_average_by_people_who_resemble_each_other(people: int) -> None:
    rng = np.random.default_rng(1)
    rates, plain = [], []
    for _ in range(400):
        known = scores_between(rng, people, people, 5)  # of each person with all; her own are left out
        own = [np.delete(table, index, axis=1) for index, table in enumerate(known)]
        flat = np.concatenate([table.ravel() for table in own])
        each = 1 - 0.99 ** (1 / people)
        thresholds = [Strangers.of(own, people).threshold(0.01, people), flat.mean() + flat.std() * norm.isf(each)]
        spread = np.sqrt(0.4**2 + 0.4**2 + 0.7**2 + 0.4**2)
        rates.append(1 - norm.cdf(thresholds[0] / spread) ** people)
        plain.append(1 - norm.cdf(thresholds[1] / spread) ** people)
    assert np.mean(rates) < 0.012
    assert np.mean(plain) > 0.02  # as if all comparisons were independent


@pytest.mark.parametrize(
    ("scores", "enrolled", "message"),
    [
        ([[[1.0]]], 1, "scores: expected those of at least two strangers, got 1"),
        ([[[1.0]], [[1.0]]], 1, "scores: expected some that differ, got 2 pairs of the same score"),
        ([[[1.0]], [1.0]], 1, r"scores: expected shape \(photographs, people\)"),
        ([[[1.0]], [[np.nan]]], 1, "scores: expected finite numbers"),
        ([[[1.0]], [[2.0]]], 0, "enrolled: expected an integer of at least 1"),
    ],
)
def test_bad_scores(scores: list, enrolled: int, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        Strangers.of(scores, enrolled)


def test_bad_rates() -> None:
    found = Strangers(0.0, 1.0, 5, (0.0,))
    for fpir in (0, 1):
        with pytest.raises(HarmonicFaceError, match="fpir: expected a rate between 0 and 1"):
            found.threshold(fpir, 3)
    with pytest.raises(HarmonicFaceError, match="fpir: expected a number from 0 to 1"):
        found.threshold(2, 3)
    with pytest.raises(HarmonicFaceError, match="people: expected an integer of at least 1"):
        found.threshold(0.1, 0)
