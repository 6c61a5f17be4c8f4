"""Error rates of thresholds: against scikit-learn's curves, at ties, and where scores tell all or nothing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import brentq
from scipy.stats import norm
from sklearn.metrics import det_curve, roc_auc_score, roc_curve

from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.decision import equal_error_rate, error_curve, rates_at, threshold_at_fmr

SCORES = st.lists(st.integers(-5, 5), min_size=1, max_size=30)  # few values, many ties


def labelled(genuine: list[int], impostor: list[int]) -> tuple[np.ndarray, np.ndarray]:
    return np.repeat([1, 0], [len(genuine), len(impostor)]), np.concatenate([genuine, impostor])


@given(SCORES, SCORES)
def test_the_curve_is_the_roc_curve_of_scikit_learn(genuine: list[int], impostor: list[int]) -> None:
    curve = error_curve(genuine, impostor)
    fpr, tpr, thresholds = roc_curve(*labelled(genuine, impostor), drop_intermediate=False)
    assert_array_equal(curve.thresholds, thresholds)
    assert_allclose(curve.fmr, fpr, atol=1e-12)
    assert_allclose(curve.tmr, tpr, atol=1e-12)


@given(SCORES, SCORES)
def test_it_holds_the_det_curve_of_scikit_learn(genuine: list[int], impostor: list[int]) -> None:
    curve = error_curve(genuine, impostor)
    for fpr, fnr, threshold in zip(*det_curve(*labelled(genuine, impostor)), strict=True):
        at = np.flatnonzero(curve.thresholds == threshold)
        if len(at):  # scikit-learn ends some curves at thresholds of its own
            assert_allclose([curve.fmr[at[0]], curve.fnmr[at[0]]], [fpr, fnr], atol=1e-12)


@given(SCORES, SCORES)
def test_the_rates_at_a_threshold_are_those_of_the_curve(genuine: list[int], impostor: list[int]) -> None:
    curve = error_curve(genuine, impostor)
    for threshold, fmr, fnmr in zip(curve.thresholds, curve.fmr, curve.fnmr, strict=True):
        found = rates_at(genuine, impostor, threshold)
        assert found.fmr.value == pytest.approx(fmr) and found.fnmr.value == pytest.approx(fnmr)
        assert found.fmr.trials == len(impostor) and found.fnmr.trials == len(genuine)


@given(SCORES, SCORES)
def test_equal_errors_are_where_the_interpolated_curve_says(genuine: list[int], impostor: list[int]) -> None:
    fpr, tpr, _ = roc_curve(*labelled(genuine, impostor), drop_intermediate=False)
    path = np.arange(len(fpr))  # the curve may be vertical: it is followed by the number of its points
    at = brentq(lambda t: np.interp(t, path, fpr) - (1 - np.interp(t, path, tpr)), 0, len(fpr) - 1, xtol=1e-13)
    assert equal_error_rate(genuine, impostor).rate == pytest.approx(np.interp(at, path, fpr), abs=1e-9)


def test_equal_errors_of_two_bells_are_those_of_the_closed_form() -> None:
    grid = (np.arange(20000) + 0.5) / 20000
    found = equal_error_rate(norm.ppf(grid, 2), norm.ppf(grid))
    assert found.rate == pytest.approx(norm.sf(1), abs=1e-4)
    assert found.threshold == pytest.approx(1, abs=1e-3)


def test_scores_that_tell_all_and_nothing() -> None:
    assert equal_error_rate([3, 4], [1, 2]).rate == 0
    assert 2 < equal_error_rate([3, 4], [1, 2]).threshold <= 3
    assert equal_error_rate([1, 1], [1, 1]).rate == 0.5
    assert equal_error_rate([1], [2]).rate == 1
    assert equal_error_rate([2], [1]).rate == 0


def test_the_area_under_the_curve_is_that_of_the_ranks() -> None:
    rng = np.random.default_rng(0)
    genuine, impostor = rng.normal(1, 1, 300).round(1), rng.normal(0, 1, 400).round(1)
    curve = error_curve(genuine, impostor)
    assert np.trapezoid(curve.tmr, curve.fmr) == pytest.approx(roc_auc_score(*labelled(genuine, impostor)))


@given(SCORES, st.floats(0, 1))
def test_the_threshold_is_the_lowest_that_keeps_the_rate(impostor: list[int], fmr: float) -> None:
    scores = np.array(impostor)
    threshold = threshold_at_fmr(scores, fmr)
    assert (scores >= threshold).mean() <= fmr + 1e-9
    lower = scores[scores < threshold]
    if lower.size:
        assert (scores >= lower.max()).mean() > fmr


@pytest.mark.parametrize("allowed", range(0, 101))
def test_whole_shares_are_whole(allowed: int) -> None:
    scores = np.arange(100)
    assert (scores >= threshold_at_fmr(scores, allowed / 100)).sum() == allowed


def test_too_few_impostors_accept_none_of_them() -> None:
    threshold = threshold_at_fmr([0.2, 0.3], 0.01)
    assert 0.3 < threshold < 0.3 + 1e-9
    assert rates_at([0.5], [0.2, 0.3], threshold).fmr.high > 0.5  # and the interval says how little that means


@pytest.mark.parametrize(
    ("genuine", "impostor", "message"),
    [
        ([], [1], "genuine scores: expected at least one, got none"),
        ([1], [], "impostor scores: expected at least one, got none"),
        ([1], [np.nan], "impostor scores: expected finite numbers"),
        ([np.inf], [1], "genuine scores: expected finite numbers"),
        ([[1]], [1], r"genuine scores: expected shape \(n,\), got"),
        (["a"], [1], "genuine scores: expected an array of real numbers"),
    ],
)
def test_bad_scores(genuine: list, impostor: list, message: str) -> None:
    for function in (error_curve, equal_error_rate, lambda g, i: rates_at(g, i, 0)):
        with pytest.raises(HarmonicFaceError, match=message):
            function(genuine, impostor)


def test_bad_rates() -> None:
    with pytest.raises(HarmonicFaceError, match="fmr: expected a number from 0 to 1, got 2"):
        threshold_at_fmr([1], 2)
    with pytest.raises(HarmonicFaceError, match="impostor scores: expected at least one, got none"):
        threshold_at_fmr([], 0.1)
