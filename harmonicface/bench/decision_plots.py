"""Decisions in a report: ROC, DET and CMC curves, error rates at thresholds, false alarms as a gallery grows."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from scipy.stats import norm

from harmonicface._validate import Floats
from harmonicface.bench.drawing import ACCENT, INK, png
from harmonicface.bench.page import image, table
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.decision import ErrorCurve, equal_error_rate, error_curve, rates_at, threshold_at_fmr
from harmonicface.recognition.identification import (
    checked_table,
    cumulative_match,
    expected_fpir,
    fpir_by_size,
    match_ranks,
)
from harmonicface.recognition.intervals import rate

OURS = "default"
COLOURS = (INK, "#4c8c9b", "#8a7aa8", "#b59a4a", "#6f8f5f", "#a0a7ad", "#7a5c48")
TICKS = (0.001, 0.01, 0.05, 0.2, 0.5, 0.8)  # of a DET plot
LEAST = 5e-4  # errors below are drawn there
RANKS = 10
FMR = 0.001
SIZES = 12

T = TypeVar("T")


def decision_section(distances: Mapping[str, ArrayLike], people: ArrayLike) -> str:
    """Return HTML about decisions, with its plots inside.

    Every photograph is compared with everybody: once with the right person, and with all others as impostors.

    Parameters
    ----------
    distances
        For each method (photographs, people), smaller for more alike; scores with a minus sign.
    people
        (photographs,) the index of the right person.

    Raises
    ------
    HarmonicFaceError
        No methods, fewer than two people, other shapes, NaN.
    """
    scores = {name: -checked_table(one) for name, one in distances.items()}
    if not scores:
        raise HarmonicFaceError("distances: expected those of at least one method, got none")
    if min(one.shape[1] for one in scores.values()) < 2:
        raise HarmonicFaceError("distances: expected at least two people, so that there are impostors, got one")
    right = np.asarray(people)
    parts = {name: separated(one, right) for name, one in scores.items()}
    curves = {name: error_curve(*part) for name, part in parts.items()}
    chosen = OURS if OURS in scores else next(iter(scores))
    heads = ["", "equal error %", f"FNMR % at FMR {100 * FMR:g} %", "found first %", "within the first 5 %"]
    return (
        "<h2>Decisions</h2><p>One against one: each photograph with the right person (genuine) and with everybody else "
        "(impostors). Rates have 95 % intervals (Clopper &amp; Pearson), as if photographs of one person did not "
        "depend on each other.</p>"
        + table(heads, [_row(name, scores[name], right) for name in scores], OURS)
        + image(roc_picture(curves), "ROC: true matches against false matches")
        + image(det_picture(curves), "DET: false non-matches against false matches")
        + image(cmc_picture({name: cumulative_match(one, right) for name, one in scores.items()}), "CMC")
        + "<p>One against many: how often a search by somebody unknown finds an impostor as the gallery grows, each "
        f"person left out of her own searches; {chosen}, at the threshold where 1 % of comparisons do.</p>"
        + image(growth_picture(scores[chosen], right), "false alarms by size of the gallery")
    )


def separated(scores: Floats, people: ArrayLike) -> tuple[Floats, Floats]:
    """Return the scores with the right people, and those with all others.

    Examples
    --------
    >>> [part.tolist() for part in separated(np.array([[3.0, 1.0], [0.0, 2.0]]), [0, 1])]
    [[3.0, 2.0], [1.0, 0.0]]
    """
    match_ranks(scores, people)  # it checks both
    own = np.arange(scores.shape[1]) == np.asarray(people)[:, None]
    return scores[own], scores[~own]


def roc_picture(curves: Mapping[str, ErrorCurve]) -> bytes:
    """Draw true matches against false matches, the latter on a logarithmic axis."""

    def draw(axis: Axes) -> None:
        for name, curve, style in _styled(curves):
            axis.step(np.maximum(curve.fmr, LEAST / 5), curve.tmr, where="post", label=name, **style)
        axis.set_xscale("log")
        axis.set_xlabel("false match rate")
        axis.set_ylabel("true match rate")

    return _drawn(draw)


def det_picture(curves: Mapping[str, ErrorCurve]) -> bytes:
    """Draw both errors on axes of normal deviates, where bells of scores are straight lines (Martin et al. 1997)."""

    def draw(axis: Axes) -> None:
        for name, curve, style in _styled(curves):
            fmr, fnmr = (norm.ppf(np.clip(one, LEAST, 1 - LEAST)) for one in (curve.fmr, curve.fnmr))
            axis.plot(fmr, fnmr, label=name, **style)
        labels = [f"{100 * tick:g} %" for tick in TICKS]
        axis.set_xticks(norm.ppf(TICKS), labels)
        axis.set_yticks(norm.ppf(TICKS), labels)
        axis.set_xlim(norm.ppf(0.8 * LEAST), norm.ppf(TICKS[-1]))
        axis.set_ylim(norm.ppf(0.8 * LEAST), norm.ppf(TICKS[-1]))
        axis.plot(*[norm.ppf([LEAST, TICKS[-1]])] * 2, color="#c9ced2", linewidth=0.8, zorder=0)
        axis.set_xlabel("false match rate")
        axis.set_ylabel("false non-match rate")

    return _drawn(draw)


def cmc_picture(curves: Mapping[str, ArrayLike]) -> bytes:
    """Draw the share of searches that find the right person among the first k."""

    def draw(axis: Axes) -> None:
        for name, curve, style in _styled(curves):
            shown = np.asarray(curve)[:RANKS]
            axis.plot(np.arange(1, len(shown) + 1), 100 * shown, "o-", markersize=4, label=name, **style)
        axis.set_ylim(min(95.0, 100 * min(float(np.min(one)) for one in curves.values()) - 2), 100.5)
        axis.set_xlabel("among the first")
        axis.set_ylabel("searches that find the right person, %")

    return _drawn(draw)


def growth_picture(scores: Floats, people: ArrayLike, fmr: float = 0.01) -> bytes:
    """Draw the rate of false alarms of a search by the number of people, measured and as 1 - (1 - FMR)^n."""
    own = np.arange(scores.shape[1]) == np.asarray(people)[:, None]
    others = scores[~own].reshape(len(scores), -1)
    threshold = threshold_at_fmr(others.ravel(), fmr)
    measured_fmr = float((others >= threshold).mean())
    sizes = np.unique(np.linspace(1, others.shape[1], SIZES).round().astype(int))

    def draw(axis: Axes) -> None:
        expected = [100 * expected_fpir(measured_fmr, int(size)) for size in sizes]
        axis.plot(sizes, expected, "--", color=INK, label="if comparisons were independent")
        measured = 100 * fpir_by_size(others, threshold, sizes.tolist())
        axis.plot(sizes, measured, "o-", color=ACCENT, label="measured, mean over all galleries of that size")
        axis.set_xlabel("people in the gallery")
        axis.set_ylabel("searches with a false alarm, %")
        axis.set_ylim(bottom=0)

    return _drawn(draw)


def _row(name: str, scores: Floats, people: ArrayLike) -> list[str]:
    """Return a method's figures."""
    genuine, impostor = separated(scores, people)
    threshold = threshold_at_fmr(impostor, FMR)
    ranks = match_ranks(scores, people)
    found = [rate(int((ranks <= most).sum()), len(ranks)) for most in (1, 5)]
    return [
        name,
        f"{100 * equal_error_rate(genuine, impostor).rate:.2f}",
        str(rates_at(genuine, impostor, threshold).fnmr),
        *(str(one) for one in found),
    ]


def _styled(curves: Mapping[str, T]) -> Sequence[tuple[str, T, dict[str, Any]]]:
    """Return curves with colours, ours last so that it lies above the others."""
    others = [name for name in curves if name != OURS]
    styles: dict[str, dict[str, Any]] = {
        name: {"color": COLOURS[place % len(COLOURS)], "linewidth": 1.2} for place, name in enumerate(others)
    }
    styles[OURS] = {"color": ACCENT, "linewidth": 2.2}
    return [(name, curves[name], styles[name]) for name in (*others, *([OURS] if OURS in curves else []))]


def _drawn(draw: Callable[[Axes], None]) -> bytes:
    """Return the PNG of one plot."""
    figure = Figure(figsize=(7.2, 4.4), layout="constrained")
    axis = figure.add_subplot()
    draw(axis)
    axis.spines[["top", "right"]].set_visible(False)
    axis.grid(alpha=0.25)
    axis.legend(frameon=False, fontsize=9)
    return png(figure)
