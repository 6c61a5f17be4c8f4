"""Counting answers."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.stats import binomtest

from harmonicface.bench.yale_result import Answers, Query, YaleMethod, YaleResult, as_json

PHOTO = np.zeros((2, 2), np.float32)
QUERIES = [Query(index % 2, subset, PHOTO, f"photo{index}") for index, subset in enumerate((1, 1, 4, 4, 4, 5))]


def test_errors_are_counted_by_subset() -> None:
    method = YaleMethod.of(Answers(QUERIES, [0, 1, 1, 1, 0, 0]), [0.001, 0.002, 0.009, 0.002, 0.002, 0.001])
    assert method.asked == {"1": 2, "2": 0, "3": 0, "4": 3, "5": 1}
    assert method.wrong == {"1": 0, "2": 0, "3": 0, "4": 1, "5": 1}
    assert method.error_percent == {"1": 0.0, "4": pytest.approx(100 / 3), "5": 100.0}
    assert method.ms_per_query == pytest.approx(2)
    assert method.answers is not None
    assert [(query.file, named) for query, named in method.answers.missed()] == [("photo2", 1), ("photo5", 0)]


def test_intervals_of_totals() -> None:
    method = YaleMethod({}, 1.0, {"4": 3, "5": 7}, {"4": 100, "5": 50})
    exact = binomtest(3, 100).proportion_ci(method="exact")
    totals = method.totals()
    assert (totals["1-4"].low, totals["1-4"].high) == pytest.approx((exact.low, exact.high))
    assert totals["1-5"].value == 10 / 150
    assert method.rate([1, 2]) is None


def test_ten_divisions_ask_for_the_same_photographs() -> None:
    once = YaleMethod({}, 1.0, {"5": 2}, {"5": 100}).rate([5])
    ten = YaleMethod({}, 1.0, {"5": 21}, {"5": 1000}, splits=10).rate([5])
    assert once is not None and ten is not None
    assert (ten.low, ten.high) == (once.low, once.high)
    assert ten.value == 0.021


def test_people_on_whom_nothing_was_chosen_judge() -> None:
    method = YaleMethod.of(Answers(QUERIES, [0, 1, 1, 1, 0, 0]), [0.001] * 6)
    assert method.wrong_by_person([3, 7]) == {3: (1, 3), 7: (1, 3)}
    found = method.unseen([3, 7])
    assert found is not None and (found.events, found.trials) == (1, 3)
    assert method.unseen([3, 4]) is None
    assert YaleMethod({}, 1.0).unseen([3, 7]) is None


def test_json_keeps_its_keys() -> None:
    method = YaleMethod.of(Answers(QUERIES, [0] * 6), [0.001] * 6)
    found = json.loads(json.dumps(as_json(YaleResult("yale-b", "frontal", [1, 2], {"1": 2}, {"default": method}))))
    assert {"protocol", "train", "people", "n", "methods"} <= set(found)
    assert {"error_percent", "ms_per_query"} <= set(found["methods"]["default"])
    assert found["methods"]["default"]["wrong_by_person"] == {"1": 0, "2": 3}
    low, high = found["methods"]["default"]["total_interval_percent"]["1-4"]
    assert low < found["methods"]["default"]["total_percent"]["1-4"] == 40 < high
