"""The benchmark's figures as rows of text, for the terminal and the report."""

from __future__ import annotations

from harmonicface.bench.benchmark import BenchmarkResult
from harmonicface.bench.yale_b import YaleResult


def error_table(result: BenchmarkResult) -> tuple[list[str], list[list[str]]]:
    """Return heads and rows: per method the error per tier in %, milliseconds a photograph, KiB a person."""
    heads = ["method", *result.queries, "ms", "KiB"]
    rows = [
        [
            method.method,
            *(f"{100 * method.errors[tier] / count:.1f}" for tier, count in result.queries.items()),
            f"{method.milliseconds:.2f}",
            f"{method.bytes_per_person / 1024:.0f}",
        ]
        for method in result.methods
    ]
    return heads, rows


def margin_table(result: BenchmarkResult) -> tuple[list[str], list[list[str]]]:
    """Return heads and rows: per tier the margin of the nine harmonic images, and who is refused as unknown."""
    heads = ["light", "median margin", "worst margin", "refused: enrolled", "strangers"]
    rows = [
        [
            tier,
            f"{margin.median:.2f}",
            f"{margin.worst:.2f}",
            f"{100 * result.open_set[tier].enrolled_refused:.1f}",
            f"{100 * result.open_set[tier].strangers_refused:.1f}",
        ]
        for tier, margin in result.margins.items()
    ]
    return heads, rows


def yale_table(result: YaleResult) -> tuple[list[str], list[list[str]]]:
    """Return heads and rows: per method the error per subset in %, milliseconds a photograph."""
    heads = ["method", *(f"subset {subset}" for subset, count in result.n.items() if count), "ms"]
    rows = [
        [name, *(f"{percent:.2f}" for percent in method.error_percent.values()), f"{method.ms_per_query:.2f}"]
        for name, method in result.methods.items()
    ]
    return heads, rows
