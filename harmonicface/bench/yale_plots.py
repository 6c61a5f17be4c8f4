"""The plots of the report on Yale B: errors by method and subset, errors against time, decisions."""

from __future__ import annotations

import io
from collections.abc import Sequence

import matplotlib
import numpy as np
from matplotlib.colors import PowerNorm
from matplotlib.figure import Figure

from harmonicface.bench.yale_result import YaleMethod, YaleResult

matplotlib.use("Agg")

OURS = "default"
INK = "#22303c"
ACCENT = "#c8553d"
LABEL = 0.045  # of the height of a plot: what a name needs
LETTER = 0.0115  # of the width


def by_error(result: YaleResult) -> list[tuple[str, YaleMethod]]:
    """Return the methods, those with the fewest errors over all subsets first."""
    return sorted(result.methods.items(), key=lambda pair: (overall(pair[1]), pair[1].ms_per_query))


def overall(method: YaleMethod) -> float:
    """Return the error over everything that was asked, in %."""
    return 100 * sum(method.wrong.values()) / max(sum(method.asked.values()), 1)


def subsets_picture(result: YaleResult) -> bytes:
    """Draw the error of every method in every subset as a coloured cell with its number."""
    methods = by_error(result)
    subsets = [subset for subset, count in result.n.items() if count]
    errors = np.array([[method.error_percent[subset] for subset in subsets] for _, method in methods])
    figure = Figure(figsize=(7.2, 0.9 + 0.3 * len(methods)), layout="constrained")
    axis = figure.add_subplot()
    axis.imshow(errors, cmap="OrRd", norm=PowerNorm(0.4, 0, 100), aspect="auto")
    for (row, column), error in np.ndenumerate(errors):
        text = "0" if error == 0 else f"{error:.1f}" if error >= 0.95 else f"{error:.2f}"
        axis.text(column, row, text, ha="center", va="center", fontsize=9, color="white" if error > 35 else INK)
    axis.set_xticks(range(len(subsets)), [f"subset {subset}\n{result.n[subset]} photographs" for subset in subsets])
    axis.set_yticks(range(len(methods)), [name for name, _ in methods])
    _mark_ours(axis.get_yticklabels())
    axis.tick_params(length=0, labelsize=9, colors=INK)
    axis.xaxis.tick_top()
    axis.spines[:].set_visible(False)
    return png(figure)


def time_picture(result: YaleResult) -> bytes:
    """Draw the error over all subsets against the time of a query, its 95 % interval as a line."""
    figure = Figure(figsize=(7.2, 5.2), layout="constrained")
    axis = figure.add_subplot()
    points = [(name, method.ms_per_query, overall(method)) for name, method in by_error(result)]
    for name, method in result.methods.items():
        found = method.rate([int(subset) for subset in method.asked])
        if found is not None:
            colour = ACCENT if name == OURS else INK
            axis.plot([method.ms_per_query] * 2, [100 * found.low, 100 * found.high], color=colour, alpha=0.35)
    for name, milliseconds, percent in points:
        ours = name == OURS
        axis.plot(milliseconds, percent, "o", markersize=9 if ours else 6, color=ACCENT if ours else INK)
    axis.set_xscale("log")
    axis.set_yscale("symlog", linthresh=1, linscale=0.6)
    axis.set_yticks([0, 0.5, 1, 2, 5, 10, 20, 50], ["0", "0.5", "1", "2", "5", "10", "20", "50"])
    axis.set_ylim(-0.15, 100)
    axis.margins(x=0.2)
    axis.set_xlabel("milliseconds a photograph")
    axis.set_ylabel("photographs given to the wrong person, %")
    axis.spines[["top", "right"]].set_visible(False)
    axis.grid(alpha=0.25)
    figure.draw_without_rendering()  # names are placed where the layout puts the points
    _name_points(axis, points)
    return png(figure)


def png(figure: Figure) -> bytes:
    """Return the PNG of a figure."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=130)
    return buffer.getvalue()


def _name_points(axis: matplotlib.axes.Axes, points: Sequence[tuple[str, float, float]]) -> None:
    """Write names to the right of points, moved up or down until they do not cover each other."""
    into = axis.transAxes.inverted()
    dots = [into.transform(axis.transData.transform((one, two))) for _, one, two in points]
    placed = [(x - 0.012, x + 0.012, y) for x, y in dots]
    for name, milliseconds, percent in sorted(points, key=lambda point: point[2]):
        x, y = into.transform(axis.transData.transform((milliseconds, percent)))
        start = x + 0.02
        end, step = start + LETTER * len(name), 0
        height = y
        while any(abs(height - other) < LABEL and start < right and left < end for left, right, other in placed):
            step += 1
            height = y + LABEL / 3 * (step // 2 if step % 2 == 0 else -(step + 1) // 2)  # below and above in turn
        placed.append((start, end, height))
        ours = name == OURS
        axis.annotate(
            name,
            (x, y),
            xytext=(start, height),
            xycoords="axes fraction",
            textcoords="axes fraction",
            va="center",
            color=ACCENT if ours else INK,
            fontweight="bold" if ours else "normal",
            fontsize=8.5,
            arrowprops=None if abs(height - y) < LABEL / 2 else {"arrowstyle": "-", "color": "#b8c0c7", "lw": 0.7},
        )


def _mark_ours(labels: Sequence[matplotlib.text.Text]) -> None:
    """Let the name of our method stand out."""
    for label in labels:
        if label.get_text() == OURS:
            label.set_color(ACCENT)
            label.set_fontweight("bold")
