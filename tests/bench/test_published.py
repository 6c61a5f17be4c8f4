"""Published figures are spelled as printed, and each stands beside a method that there is."""

from __future__ import annotations

import pytest

from harmonicface.bench.published import DIFFERENCES, ROWS, explained, published
from harmonicface.bench.yale_contenders import YALE_METHODS
from harmonicface.bench.yale_protocols import PROTOCOLS


def test_each_row_stands_beside_a_method_of_ours() -> None:
    for row in ROWS:
        assert row.ours in YALE_METHODS
        assert row.train in PROTOCOLS
        assert set(row.n) == set(row.error_percent)


def test_the_table_of_450_photographs() -> None:
    printed = {row.name: row.error_percent["1-4"] for row in published("subset1")}
    assert list(printed.values()) == [29.1, 30.4, 25.8, 4.6, 2.7, 1.1, 0.87, 0.85, 0.44, 0.0]
    events = [row.rate("1-4").events for row in published("subset1")]
    assert events == [131, 137, 116, 21, 12, 5, 4, 4, 2, 0]  # whole photographs


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_the_interval_holds_the_printed_error(row) -> None:  # type: ignore[no-untyped-def]
    for subsets, percent in row.error_percent.items():
        found = row.rate(subsets)
        assert 100 * found.low <= percent <= 100 * found.high
        assert 100 * found.value == pytest.approx(percent, abs=50 / found.trials)


def test_only_differences_are_explained() -> None:
    rows = [
        ["correlation", "1-4", "", "", "fewer"],
        ["Eigenfaces", "1-4", "", "", "as many"],
        ["gradient angle", "more"],
    ]
    assert explained("subset1", rows) == {"correlation": DIFFERENCES["correlation"]}
    assert explained("frontal", rows) == {}
    assert set(DIFFERENCES) <= {row.ours for row in ROWS}
