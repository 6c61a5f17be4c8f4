"""Standardized measures and their sum."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.recognition.fusion import fused, standardized


def test_many_strangers_speak_for_themselves() -> None:
    values = np.random.default_rng(0).normal(3.0, 0.5, 4000)
    values[7] = 5.5
    assert_allclose(standardized(values, usual=0.7)[7], (5.5 - 3) / 0.5, rtol=0.05)


def test_few_strangers_lean_on_the_usual_deviation() -> None:
    assert_allclose(standardized([1.0, 0.0], usual=0.5), [1 / (0.5 * np.sqrt(5 / 5 * 2)), 0])
    spread = np.sqrt((5 * 0.5**2 + 2 * 0.1**2) / 6 * 1.5)
    assert_allclose(standardized([0.1, 2.0, -0.1], usual=0.5), np.array([0.1, 2, -0.1]) / spread)


def test_units_do_not_matter() -> None:
    values = np.random.default_rng(1).normal(size=9)
    assert_allclose(standardized(100 * values + 7, usual=30), standardized(values, usual=0.3))


def test_somebody_alone_and_twins_have_no_deviation() -> None:
    assert standardized([0.7], usual=1).tolist() == [0.0]
    assert_allclose(standardized([0.7] * 4, usual=1), 0, atol=1e-12)


def test_independent_measures_add_to_unit_deviation() -> None:
    measures = np.random.default_rng(2).normal(size=(3, 20000))
    assert_allclose(fused(list(measures)).std(), 1, rtol=0.03)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: standardized([], 1), r"values: expected shape \(n,\)"),
        (lambda: standardized([[1.0]], 1), r"values: expected shape \(n,\)"),
        (lambda: standardized([np.nan], 1), "values: expected finite numbers"),
        (lambda: standardized([1.0], 0), "usual: expected a finite number above 0"),
        (lambda: standardized([1.0], 1, prior=0), "prior: expected a finite number above 0"),
        (lambda: fused([]), "measures: expected at least one, got none"),
    ],
)
def test_bad_input(call, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        call()
