"""The one plot of speed against error: both axes logarithmic, and the front that nothing beats in both."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter, NullLocator

from harmonicface.bench.drawing import ACCENT, COOL, INK, MUTED, png
from harmonicface.bench.labels import place_labels
from harmonicface.bench.measure import Record
from harmonicface.bench.spelling import spelled_seconds

ALL_NAMED = 20  # points up to which everything is named, and not the front alone
ACROSS = 56  # letters of a line along the upright axis
ALL_NUMBERED = 45  # points up to which everything has at least the number of its row


@dataclass(frozen=True)
class Point:
    """A measurement in the plot.

    Parameters
    ----------
    name
        In words.
    seconds
        Positive.
    error
        At least 0.
    ours
        Whether it stands out.
    number
        Of its row in the table beside the plot; 0 where there is none.
    low, high
        Ends of the interval of the error, where there is one.
    """

    name: str
    seconds: float
    error: float
    ours: bool = True
    number: int = 0
    low: float | None = None
    high: float | None = None


def points_of(records: Sequence[Record]) -> dict[tuple[str, str], list[Point]]:
    """Return what can be drawn of a benchmark: points by question and unit, where there are at least two.

    Examples
    --------
    >>> beside = Record("match", "9", 0.2, 1.0, peer="numpy.dot", peer_seconds=0.1, peer_error=3.0, unit="% wrong")
    >>> [(point.name, point.ours) for point in points_of([beside])["", "% wrong"]]
    [('match', True), ('numpy.dot', False)]
    """
    found: dict[tuple[str, str], dict[object, Point]] = {}
    often = Counter((record.question, record.unit, record.name) for record in records)
    for number, record in enumerate(records, start=1):
        group = found.setdefault((record.question, record.unit), {})
        if record.error is not None and np.isfinite(record.error) and record.seconds > 0:
            name = record.name.removeprefix(record.question).lstrip(",: ") or record.name
            if often[record.question, record.unit, record.name] > 1:
                name = f"{name}, {record.size}"
            group[number] = Point(name, record.seconds, abs(record.error), True, number)
        if record.peer and record.peer_seconds and record.peer_error is not None and np.isfinite(record.peer_error):
            point = Point(short(record.peer), record.peer_seconds, abs(record.peer_error), False, number)
            group.setdefault((record.peer, record.peer_seconds), point)
    return {which: list(group.values()) for which, group in found.items() if len(group) > 1}


def short(name: str) -> str:
    """Return the name of a function without most of the modules that it is in.

    Examples
    --------
    >>> short("scipy.optimize.nnls, on all pixels"), short("harmonicface.reflectance.brdf.Phong.__call__")
    ('optimize.nnls, on all pixels', 'Phong.__call__')
    """
    functions, comma, about = name.partition(",")
    return " + ".join(".".join(one.split(".")[-2:]) for one in functions.split(" + ")) + comma + about


def pareto_front(points: Sequence[Point]) -> list[Point]:
    """Return the points that no other one beats in time and error both, the fastest first.

    Examples
    --------
    >>> [point.name for point in pareto_front([Point("a", 1, 2), Point("b", 2, 1), Point("c", 2, 2)])]
    ['a', 'b']
    """
    front: list[Point] = []
    for point in sorted(points, key=lambda one: (one.seconds, one.error)):
        if not front or point.error < front[-1].error:
            front.append(point)
    return front


def speed_error_picture(points: Sequence[Point], unit: str = "", time: str = "time") -> bytes:
    """Draw error against time.

    Parameters
    ----------
    points
        At least one.
    unit
        Of the errors, in words.
    time
        What the seconds are of.

    Returns
    -------
    bytes
        A PNG. An error of 0 stands on a line of its own below the others.
    """
    figure = Figure(figsize=(8.4, 4.9), layout="constrained")
    FigureCanvasAgg(figure)
    axis = figure.add_subplot()
    floor = _axes(axis, points)
    front = pareto_front(points)
    times = [point.seconds for point in front]
    heights = [point.error or floor for point in front]
    axis.step(times, heights, where="post", color=COOL, linewidth=1.6, alpha=0.55, zorder=1)
    for point in points:
        colour = ACCENT if point.ours else INK
        if point.low is not None and point.high is not None:
            ends = [max(point.low, floor), max(point.high, floor)]
            axis.plot([point.seconds] * 2, ends, color=colour, alpha=0.3, zorder=1)
        shape, inside = ("o", colour) if point.ours else ("s", "white")
        axis.plot(point.seconds, point.error or floor, shape, color=colour, markersize=7, mfc=inside)
    axis.set_xlabel(f"{time} (log)", color=INK)
    axis.set_ylabel(fill(f"error, {unit} (log)" if unit else "error (log)", ACROSS), color=INK)
    _legend(axis, points)
    figure.draw_without_rendering()  # labels are placed where the layout puts the points
    named = points if len(points) <= ALL_NAMED else front
    numbered = len(points) <= ALL_NUMBERED
    labels = [
        (point.seconds, point.error or floor, _label(point, point in named, numbered), point.ours and point in named)
        for point in sorted(points, key=lambda one: one not in front)
    ]
    steps = [corner for one, two in pairwise(front) for corner in _step(one, two, floor)]
    place_labels(axis, labels, steps)
    return png(figure)


def _step(one: Point, other: Point, floor: float) -> list[tuple[float, float]]:
    """Return the corners of a step of the front."""
    high, low = one.error or floor, other.error or floor
    return [(one.seconds, high), (other.seconds, high), (other.seconds, low)]


def _axes(axis: Axes, points: Sequence[Point]) -> float:
    """Scale both axes, and return the height at which an error of 0 stands."""
    errors = np.array([point.error for point in points])
    positive = errors[errors > 0]
    low, high = (positive.min(), positive.max()) if len(positive) else (0.1, 1.0)
    floor = float(low / max(4.0, (high / low) ** 0.15))
    times = np.array([point.seconds for point in points])
    axis.set_xscale("log")
    axis.set_yscale("log")
    widen = max(1.5, (times.max() / times.min()) ** 0.1)
    axis.set_xlim(times.min() / widen, times.max() * widen**3)
    bottom = floor / 1.6 if (errors == 0).any() else low / max(1.6, (high / low) ** 0.08)
    axis.set_ylim(bottom, high * max(1.8, (high / low) ** 0.12))
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: spelled_seconds(value)))
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.yaxis.set_minor_formatter(NullFormatter())
    for line, (least, most) in (
        (axis.xaxis, axis.get_xlim()),
        (axis.yaxis, (max(bottom, low / 2), axis.get_ylim()[1])),
    ):
        line.set_major_locator(_ticks(least, most))
        line.set_minor_locator(NullLocator())
    axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}".replace("e-0", "e-")))
    if (errors == 0).any():
        axis.axhline(floor, color=MUTED, linewidth=0.8, linestyle=":", zorder=0)
        axis.annotate(
            "0", (0, floor), xycoords=("axes fraction", "data"), xytext=(-6, 0), textcoords="offset points", ha="right",
            va="center", color=INK,
        )  # fmt: skip
    axis.tick_params(colors=INK, labelsize=9)
    axis.spines[["top", "right"]].set_visible(False)
    axis.grid(alpha=0.25)
    return floor


def _ticks(least: float, most: float) -> FixedLocator:
    """Return a locator with about six round places between two numbers."""
    for steps in ((1.0,), (1.0, 3.0), (1.0, 2.0, 5.0), (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)):
        decades = range(int(np.floor(np.log10(least))), int(np.ceil(np.log10(most))) + 1)
        places = [step * 10.0**decade for decade in decades for step in steps]
        inside = [place for place in places if least <= place <= most]
        if len(inside) >= 4:
            break
    return FixedLocator(inside[:: -(-len(inside) // 9)])


def _legend(axis: Axes, points: Sequence[Point]) -> None:
    """Say what the marks are."""
    if any(point.ours for point in points):
        axis.plot([], [], "o", color=ACCENT, label="ours")
    if not all(point.ours for point in points):
        axis.plot([], [], "s", color=INK, mfc="white", label="beside")
    axis.plot([], [], color=COOL, alpha=0.55, label="front: nothing is both faster and more exact")
    axis.figure.legend(loc="outside upper right", ncols=3, fontsize=9, frameon=False, labelcolor=INK)


def _label(point: Point, named: bool, numbered: bool) -> str:
    """Return the number and the name, where they are wanted."""
    name = point.name if len(point.name) <= 46 else f"{point.name[:44]}…"
    number = str(point.number) if point.number else ""
    return f"{number} {name}".strip() if named else number if numbered else ""
