"""The page of the curves: error against what happens to a photograph, one plot each, and times in a full gallery."""

from __future__ import annotations

import html
import os
from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harmonicface.bench.curves import CurvePoint, lost_points
from harmonicface.bench.drawing import ACCENT, INK, png
from harmonicface.bench.measure import machine
from harmonicface.bench.ordeals import ENROLMENT, ORDEALS, Ordeal
from harmonicface.bench.page import image, page, table
from harmonicface.bench.yale_plots import OURS
from harmonicface.bench.yale_timing import Timing
from harmonicface.io.files import replacing

COLUMNS = 3
STYLES = {  # colour and line of a method, so that they also differ in print
    OURS: (ACCENT, "-", "o"),
    "harmonic9": ("#2f6f8f", "--", "s"),
    "lbph": ("#7a8691", ":", "^"),
    "tan_triggs": (INK, "-.", "v"),
}


def write_curves_page(
    points: Sequence[CurvePoint], timings: Sequence[Timing], people: Sequence[int], file: str | os.PathLike[str]
) -> Path:
    """Write the page, which needs no other file; it is replaced whole.

    Raises
    ------
    HarmonicFaceError
        The file cannot be written.
    """
    about = machine()
    fields = {
        "people": len(people),
        "queries": max(point.asked for point in points),
        "unseen": max(point.asked_unseen for point in points),
        "curves": image(curves_picture(points), "error against what happens to a photograph"),
        "lost": html.escape(_lost(points)),
        "tables": "".join(_table(ordeal, points) for ordeal in (*ORDEALS, ENROLMENT)),
        "gallery": timings[0].people if timings else 0,
        "timings": table(*timing_table(timings), OURS),
        "machine": html.escape(f"{about['processor']}, {about['cores']} cores, Python {about['python']}"),
        "packages": html.escape(", ".join(f"{name} {number}" for name, number in dict(about["packages"]).items())),  # type: ignore[call-overload]
    }
    target = Path(file)
    text = page("curves.html.template", "harmonicface: photographs that get worse", fields)
    with replacing(target) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return target


def curves_picture(points: Sequence[CurvePoint]) -> bytes:
    """Draw the error of every method against the level, one plot an ordeal, with the 95 % interval of ours."""
    ordeals = [ordeal for ordeal in (*ORDEALS, ENROLMENT) if any(point.ordeal == ordeal.name for point in points)]
    rows = -(-len(ordeals) // COLUMNS)
    figure = Figure(figsize=(9.6, 2.7 * rows), layout="constrained")
    axes = figure.subplots(rows, COLUMNS, squeeze=False)
    for axis, ordeal in zip(axes.flat, ordeals, strict=False):
        _draw(axis, ordeal, [point for point in points if point.ordeal == ordeal.name])
    for axis in axes.flat[len(ordeals) :]:
        axis.set_visible(False)
    axes[0, 0].legend(fontsize=8, frameon=False, loc="upper left")
    figure.supylabel("photographs given to the wrong person, %", fontsize=10, color=INK)
    return png(figure)


def timing_table(timings: Sequence[Timing]) -> tuple[list[str], list[list[str]]]:
    """Return heads and rows: per method milliseconds a query, seconds of enrolment, KiB a person."""
    heads = ["method", "ms a query", "s to enrol all", "KiB a person"]
    rows = [
        [
            timing.method,
            f"{timing.milliseconds:.2f}",
            f"{timing.enrolment_seconds:.2f}",
            f"{timing.bytes_per_person / 1024:.0f}",
        ]
        for timing in timings
    ]
    return heads, rows


def _draw(axis: Axes, ordeal: Ordeal, points: Sequence[CurvePoint]) -> None:
    """Draw one plot; levels are evenly spaced, for some are ratios and some are differences."""
    levels = sorted({point.level for point in points})
    methods = list(dict.fromkeys(point.method for point in points))
    for method in methods:
        own = sorted((point for point in points if point.method == method), key=lambda point: point.level)
        places = [levels.index(point.level) for point in own]
        colour, line, marker = STYLES.get(method, (INK, "-", "."))
        ours = method == OURS
        width, order = (2.2, 3) if ours else (1.3, 2)
        axis.plot(
            places,
            [100 * point.error.value for point in own],
            color=colour,
            linestyle=line,
            marker=marker,
            markersize=4,
            linewidth=width,
            zorder=order,
            label=method,
        )
        if ours:
            low, high = [100 * point.error.low for point in own], [100 * point.error.high for point in own]
            axis.fill_between(places, low, high, color=colour, alpha=0.12, linewidth=0)
    axis.set_xticks(range(len(levels)), [ordeal.spell(level) for level in levels])
    axis.set_ylim(-2, 102)
    axis.set_title(f"{ordeal.name}, {ordeal.unit}", fontsize=9.5, color=INK, loc="left")
    axis.tick_params(labelsize=8, colors=INK)
    axis.spines[["top", "right"]].set_visible(False)
    axis.grid(alpha=0.25)


def _table(ordeal: Ordeal, points: Sequence[CurvePoint]) -> str:
    """Return the figures of one ordeal, levels across, methods always in the same order."""
    own = [point for point in points if point.ordeal == ordeal.name]
    if not own:
        return ""
    levels = sorted({point.level for point in own})
    rows = []
    for method in dict.fromkeys(point.method for point in points):
        found = {point.level: point for point in own if point.method == method}
        rows += [[method, *(_cell(found.get(level)) for level in levels)]] if found else []
    title = html.escape(f"{ordeal.name}, {ordeal.unit}")
    return f"<h3>{title}</h3>" + table(["", *(ordeal.spell(level) for level in levels)], rows, OURS)


def _lost(points: Sequence[CurvePoint]) -> str:
    """Say where another method is better than ours."""
    units = {ordeal.name: ordeal for ordeal in (*ORDEALS, ENROLMENT)}
    places = [
        f"{ours.ordeal} {units[ours.ordeal].spell(ours.level)} ({best.method} {100 * best.error.value:.1f} % against "
        f"{100 * ours.error.value:.1f} %)"
        for ours, best in lost_points(points, OURS)
    ]
    return (
        f"Another method has fewer errors than {OURS} at " + "; ".join(places) + "."
        if places
        else (f"Nowhere has another method fewer errors than {OURS}.")
    )


def _cell(point: CurvePoint | None) -> str:
    """Return the error; of ours also that of people on whom no setting was chosen, in brackets."""
    if point is None:
        return "-"
    unseen = point.error_unseen if point.method == OURS else None
    return _percent(point.error.value) + ("" if unseen is None else f" ({_percent(unseen.value)})")


def _percent(error: float) -> str:
    return f"{100 * error:.1f}" if error else "0"
