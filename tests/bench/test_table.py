"""Figures as rows of text."""

from __future__ import annotations

from types import SimpleNamespace

from harmonicface.bench.benchmark import Margin, MethodResult, OpenSet
from harmonicface.bench.table import error_table, margin_table, yale_table
from harmonicface.bench.yale_b import YaleMethod, YaleResult

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
