"""The benchmark's figures as rows of text, for the terminal and the report."""

from __future__ import annotations

from dataclasses import replace

from harmonicface.bench.benchmark import BenchmarkResult
from harmonicface.bench.measure import Record
from harmonicface.bench.published import published
from harmonicface.bench.timing import record
from harmonicface.bench.yale_result import YaleMethod, YaleResult
from harmonicface.recognition.intervals import Rate
from harmonicface.recognition.models import SUBSPACE_MODELS

NINE, NATURAL = "harmonic9", "natural"  # a model, and a tier
WRONG = "% of photographs given to the wrong person"


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


def method_records(result: BenchmarkResult) -> list[Record]:
    """Return one record a method: the time of a photograph, and the error over all tiers."""
    total = sum(result.queries.values())
    return [
        record(
            method.method,
            f"{result.faces} people {result.size}x{result.size}, {total} photographs",
            method.query,
            error=100 * sum(method.errors.values()) / total,
            unit=WRONG,
            bytes=round(method.bytes_per_person),
            seed=result.seed,
            note="bytes: a person",
        )
        for method in result.methods
    ]


def model_table(result: BenchmarkResult) -> tuple[list[str], list[list[str]]]:
    """Return heads and rows: per subspace model errors under natural light, time and memory beside nine images'.

    No rows where the nine images, or everybody else, were not asked.
    """
    heads = ["pictures", "errors in natural light", "ms", "of nine's", "KiB", "of nine's"]
    models = {method.method: method for method in result.methods if method.method in SUBSPACE_MODELS}
    nine = models.get(NINE)
    if nine is None or len(models) == 1:
        return heads, []
    rows = [
        [
            name,
            f"{method.errors[NATURAL]} of {result.queries[NATURAL]}",
            f"{method.milliseconds:.2f}",
            f"{100 * method.milliseconds / nine.milliseconds:.0f} %",
            f"{method.bytes_per_person / 1024:.0f}",
            f"{100 * method.bytes_per_person / nine.bytes_per_person:.0f} %",
        ]
        for name, method in sorted(models.items(), key=lambda pair: pair[1].bytes_per_person)
    ]
    return heads, rows


def model_records(result: BenchmarkResult) -> list[Record]:
    """Return one record a subspace model: the time of a photograph, and the error under natural light alone."""
    models = [method for method in result.methods if method.method in SUBSPACE_MODELS]
    share = {method.method: 100 * method.errors[NATURAL] / result.queries[NATURAL] for method in models}
    return [replace(one, error=share[one.name]) for one in method_records(result) if one.name in share]


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


def enrolment_table(result: BenchmarkResult) -> tuple[list[str], list[list[str]]]:
    """Return heads and rows: per method and way of enrolment the error per tier in %, and the normals' error."""
    heads = ["method", "by", *result.queries, "normals"]
    methods = [method.method for method in result.enrolments[0].methods] if result.enrolments else []
    rows = []
    for index, name in enumerate(methods):
        for way in result.enrolments:
            shares = ["-"] * len(result.queries)
            if way.methods:
                errors = way.methods[index].errors
                shares = [f"{100 * errors[tier] / n:.1f}" for tier, n in result.queries.items()]
            degrees = f"{way.degrees:.1f}°" if way.degrees > 0 else "-"
            rows.append([name, way.kind, *shares, degrees])
    return heads, rows


def cost_table(result: BenchmarkResult) -> tuple[list[str], list[list[str]]]:
    """Return heads and rows: per way of enrolment the margin of nine harmonic images, the normals' error, time."""
    heads = ["enrolled by", "median margin", "normals", "refused", "s a person"]
    rows = [
        [way.kind, f"{way.margin:.2f}", f"{way.degrees:.1f}°", f"{way.refused}", f"{way.seconds:.2f}"]
        for way in result.enrolments
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


def published_table(result: YaleResult) -> tuple[list[str], list[list[str]]]:
    """Return heads and rows: what is published for the protocol beside ours, in %, with binomial 95 % intervals.

    Ours is the same method; beside methods that the package does not have, it is the default one. The last column
    says whether our error lies in the interval of the published one, or beyond it.
    """
    heads = ["published method", "subsets", "published", "ours", "errors"]
    rows = []
    for row in published(result.train):
        for subsets in row.error_percent:
            theirs, own = row.rate(subsets), _own(result.methods.get(row.ours), subsets)
            left = [row.name, subsets, f"{row.error_percent[subsets]:g} {_interval(theirs)}"]
            right = ["-", "-"] if own is None else [f"{100 * own.value:.2f} {_interval(own)}", _side(own, theirs)]
            rows.append([*left, *right])
    return heads, rows


def _own(method: YaleMethod | None, subsets: str) -> Rate | None:
    """Return our error over subsets spelled as in "2" or "1-4"."""
    if method is None:
        return None
    first, _, last = subsets.partition("-")
    return method.rate(range(int(first), int(last or first) + 1))


def _side(own: Rate, theirs: Rate) -> str:
    """Say where our error lies beside a published interval."""
    if own.value < theirs.low:
        return "fewer"
    return "more" if own.value > theirs.high else "as many"


def _interval(found: Rate) -> str:
    return f"({100 * found.low:.1f}-{100 * found.high:.1f})"
