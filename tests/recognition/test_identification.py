"""Searches: ranks against scikit-learn, open sets by counting, the growth of false alarms with the gallery."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from sklearn.metrics import top_k_accuracy_score

from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.identification import (
    cumulative_match,
    expected_fpir,
    fpir_by_size,
    identification_curve,
    match_ranks,
    open_set,
)

RNG = np.random.default_rng(5)
TABLE, RIGHT = RNG.normal(size=(40, 6)), RNG.integers(0, 6, 40)
STRANGERS = RNG.normal(size=(30, 6))


def test_the_curve_is_the_top_k_accuracy_of_scikit_learn() -> None:
    found = cumulative_match(TABLE, RIGHT)
    expected = [top_k_accuracy_score(RIGHT, TABLE, k=k, labels=range(6)) for k in range(1, 6)]
    assert_allclose(found, [*expected, 1.0])


def test_who_is_tied_comes_before() -> None:
    assert match_ranks([[1, 1, 1]], [0]).tolist() == [3]
    assert cumulative_match([[1, 1, 1]], [0]).tolist() == [0, 0, 1]
    assert open_set([[1, 1, 0]], [0], [0], threshold=0.5).identified == 0


def test_a_gallery_of_one_always_finds_her() -> None:
    assert cumulative_match([[3], [4]], [0, 0]).tolist() == [1.0]


def test_an_open_set_is_counted() -> None:
    threshold = 1.5
    found = open_set(TABLE, RIGHT, STRANGERS.max(axis=1), threshold)
    named = [row.argmax() == right and row.max() >= threshold for row, right in zip(TABLE, RIGHT, strict=True)]
    assert found.identified == pytest.approx(np.mean(named))
    assert found.fnir.events == len(named) - sum(named) and found.fnir.trials == 40
    assert found.fpir.value == np.mean([(row >= threshold).any() for row in STRANGERS])
    assert found.fpir.low < found.fpir.value < found.fpir.high


def test_the_curve_of_an_open_set_holds_every_threshold() -> None:
    best = STRANGERS.max(axis=1)
    curve = identification_curve(TABLE, RIGHT, best)
    assert curve.thresholds[0] == np.inf and np.isfinite(curve.thresholds[1:]).all()
    for threshold, fpir, fnir in zip(curve.thresholds, curve.fmr, curve.fnmr, strict=True):
        found = open_set(TABLE, RIGHT, best, threshold)
        assert (found.fpir.value, found.fnir.value) == pytest.approx((fpir, fnir))
    assert curve.fnmr[-1] == pytest.approx(np.mean(TABLE.argmax(axis=1) != RIGHT))


def test_nobody_right_is_never_identified() -> None:
    assert identification_curve([[0, 1]], [0], [2]).fnmr.tolist() == [1, 1]


def test_false_alarms_grow_as_independent_comparisons_do() -> None:
    scores = np.random.default_rng(0).uniform(size=(20000, 30))
    measured = fpir_by_size(scores, 0.99, [1, 5, 30])
    fmr = float((scores >= 0.99).mean())
    assert measured[0] == pytest.approx(fmr)
    assert_allclose(measured, [expected_fpir(fmr, size) for size in (1, 5, 30)], rtol=0.03)


@pytest.mark.parametrize("size", range(1, 7))
def test_the_average_over_galleries_is_that_of_all_of_them(size: int) -> None:
    alarms = [(STRANGERS[:, list(chosen)] >= 1).any(axis=1).mean() for chosen in combinations(range(6), size)]
    assert fpir_by_size(STRANGERS, 1, [size])[0] == pytest.approx(np.mean(alarms))


@given(st.floats(0, 1), st.integers(1, 10**6))
def test_the_expected_rate_is_a_probability(fmr: float, people: int) -> None:
    found = expected_fpir(fmr, people)
    assert 0 <= found <= 1 and found <= people * fmr * (1 + 1e-9)
    assert found >= fmr * (1 - 1e-9)


def test_the_expected_rate_keeps_small_digits() -> None:
    assert expected_fpir(1e-18, 1000) == pytest.approx(1e-15)
    assert expected_fpir(1, 3) == 1 and expected_fpir(0.5, 2) == pytest.approx(0.75)


@pytest.mark.parametrize(
    ("scores", "people", "message"),
    [
        (np.zeros((0, 3)), [], r"scores: expected shape \(searches, people\), at least one of each"),
        (np.zeros(3), [0], r"scores: expected shape \(searches, people\)"),
        ([[np.nan, 1]], [0], "scores: expected finite numbers"),
        ([[1, 2]], [0, 1], "people: expected an index for each of 1 searches"),
        ([[1, 2]], [0.0], "people: expected an index for each of 1 searches"),
        ([[1, 2]], [2], "people: expected indices from 0 to 1, got 2 to 2"),
        ([[1, 2]], [-1], "people: expected indices from 0 to 1, got -1 to -1"),
    ],
)
def test_bad_searches(scores: object, people: object, message: str) -> None:
    for function in (
        match_ranks,
        cumulative_match,
        lambda s, p: open_set(s, p, [1.0], 0),
        lambda s, p: identification_curve(s, p, [1.0]),
    ):
        with pytest.raises(HarmonicFaceError, match=message):
            function(scores, people)


def test_bad_arguments() -> None:
    with pytest.raises(HarmonicFaceError, match="strangers' scores: expected at least one, got none"):
        open_set([[1, 2]], [0], [], 0)
    with pytest.raises(HarmonicFaceError, match="fmr: expected a number from 0 to 1"):
        expected_fpir(2, 1)
    with pytest.raises(HarmonicFaceError, match="people: expected an integer of at least 1"):
        expected_fpir(0.5, 0)
    with pytest.raises(HarmonicFaceError, match="sizes: expected at most 2 people, as many as there are, got 3"):
        fpir_by_size([[1, 2]], 0, [3])
    with pytest.raises(HarmonicFaceError, match="size: expected an integer of at least 1"):
        fpir_by_size([[1, 2]], 0, [0])
