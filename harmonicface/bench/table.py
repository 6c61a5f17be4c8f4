"""The benchmark's figures as rows of text, for the terminal and the report."""

from __future__ import annotations

from harmonicface.bench.benchmark import BenchmarkResult


def error_table(result: BenchmarkResult) -> tuple[list[str], list[list[str]]]:
    """Return heads and rows: per method the error per tier in %, time a photograph, memory a person."""
    heads = ["method", *(f"{tier} %" for tier in result.queries), "ms / photo", "KiB / person"]
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
    heads = ["tier", "median margin", "worst margin", "enrolled refused %", "strangers refused %"]
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
