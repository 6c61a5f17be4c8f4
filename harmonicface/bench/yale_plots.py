"""The plots of the report on Yale B: errors by method and subset, errors against time, decisions."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib
import numpy as np
from matplotlib.colors import PowerNorm
from matplotlib.figure import Figure

from harmonicface.bench.drawing import ACCENT, BESIDE, INK, png
from harmonicface.bench.speed_plot import Point, speed_error_picture
from harmonicface.bench.yale_result import YaleMethod, YaleResult

OURS = "default"


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
    points = []
    for name, method in by_error(result):
        found = method.rate([int(subset) for subset in method.asked])
        low, high = (None, None) if found is None else (100 * found.low, 100 * found.high)
        points.append(Point(name, method.ms_per_query / 1e3, overall(method), name not in BESIDE, low=low, high=high))
    return speed_error_picture(points, "% of photographs given to the wrong person", "time a photograph")


def _mark_ours(labels: Sequence[matplotlib.text.Text]) -> None:
    """Let the name of our method stand out."""
    for label in labels:
        if label.get_text() == OURS:
            label.set_color(ACCENT)
            label.set_fontweight("bold")
