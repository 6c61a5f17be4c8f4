"""Figures as rows of text."""

from __future__ import annotations

from types import SimpleNamespace

from harmonicface.bench.benchmark import Margin, MethodResult, OpenSet
from harmonicface.bench.table import error_table, margin_table, published_table, yale_table
from harmonicface.bench.yale_result import YaleMethod, YaleResult

RESULT = SimpleNamespace(
    queries={"frontal": 200, "side": 40},
    methods=[
        MethodResult("correlation", {"frontal": 1, "side": 13}, 1.2345, 0.1, 28_672),
        MethodResult("harmonic9", {"frontal": 0, "side": 40}, 0.06, 0.1, 147_456),
    ],
    margins={"frontal": Margin(7.654, 0.987), "side": Margin(2.0, 1.5)},
    open_set={"frontal": OpenSet(0.0125, 1.0), "side": OpenSet(0.5, 0.25)},
)


def test_errors_in_percent_of_each_tier() -> None:
    heads, rows = error_table(RESULT)  # type: ignore[arg-type]
    assert heads == ["method", "frontal", "side", "ms", "KiB"]
    assert rows == [
        ["correlation", "0.5", "32.5", "1.23", "28"],
        ["harmonic9", "0.0", "100.0", "0.06", "144"],
    ]


def test_margins_and_who_is_refused() -> None:
    heads, rows = margin_table(RESULT)  # type: ignore[arg-type]
    assert heads == ["light", "median margin", "worst margin", "refused: enrolled", "strangers"]
    assert rows == [["frontal", "7.65", "0.99", "1.2", "100.0"], ["side", "2.00", "1.50", "50.0", "25.0"]]


def test_subsets_without_photographs_have_no_column() -> None:
    method = YaleMethod({"1": 0.0, "4": 2.857}, 1.7)
    result = YaleResult("yale-b", "subset1", [1, 2], {"1": 14, "2": 0, "3": 0, "4": 28, "5": 0}, {"harmonic9": method})
    assert yale_table(result) == (
        ["method", "subset 1", "subset 4", "ms"],
        [["harmonic9", "0.00", "2.86", "1.70"]],
    )


def test_published_errors_beside_ours() -> None:
    asked = {"1": 70, "2": 120, "3": 120, "4": 140, "5": 190}
    methods = {
        "correlation": YaleMethod({}, 1.0, {"4": 131}, asked),  # 29.1 % of 450, as is published
        "linear3": YaleMethod({}, 1.0, {"4": 2, "5": 100}, asked),  # subset 5 is not among the 450
        "harmonic9": YaleMethod({}, 1.0, {"3": 20}, asked),
    }
    heads, rows = published_table(YaleResult("yale-b", "subset1", list(range(1, 11)), asked, methods))
    assert heads == ["published method", "subsets", "published", "ours", "errors"]
    found = {row[0]: row[1:] for row in rows}
    assert found["correlation"] == ["1-4", "29.1 (25.0-33.5)", "29.11 (25.0-33.5)", "as many"]
    assert found["3-D linear subspace"] == ["1-4", "4.6 (2.9-7.0)", "0.44 (0.1-1.6)", "fewer"]
    assert found["harmonic images, attached"] == ["1-4", "1.1 (0.4-2.6)", "4.44 (2.7-6.8)", "more"]
    assert found["gradient angle"] == ["1-4", "0.44 (0.1-1.6)", "-", "-"]


def test_single_subsets_beside_published_ones() -> None:
    asked = {"2": 12, "3": 12, "4": 14, "5": 0}
    method = YaleMethod({}, 1.0, {"4": 7}, asked)
    rows = published_table(YaleResult("yale-b", "frontal", [1, 2], asked, {"default": method}))[1]
    assert [(row[1], row[2].split()[0], row[3].split()[0], row[4]) for row in rows[:4]] == [
        ("2", "0", "0.00", "as many"),
        ("3", "12.9", "0.00", "fewer"),
        ("4", "12.4", "50.00", "more"),
        ("5", "15.2", "-", "-"),
    ]
    assert published_table(YaleResult("yale-b", "subset12", [1, 2], asked, {"default": method}))[1] == []
