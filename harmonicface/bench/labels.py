"""Names beside the points of a plot, placed so that a person can read them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from matplotlib.transforms import Bbox

from harmonicface.bench.drawing import ACCENT, INK, MUTED

Label = tuple[float, float, str, bool]  # across, up, what is written, whether it stands out
GAP = 7.0  # points of type between a mark and its name
MARK = 4.5  # half the size of a mark
DISTANCES = (1.0, 2.6, 4.5, 7.0)  # in gaps: the nearest place is taken that is free
LEADER = 2.0  # gaps beyond which a line leads to the mark


def place_labels(
    axis: Axes, labels: Sequence[Label], line: Sequence[tuple[float, float]] = (), size: float = 8.5
) -> None:
    """Write each label at the nearest free place to its point; the first ones choose first.

    A label that finds none is left out: the number of its row is not worth an unreadable name.

    Parameters
    ----------
    axis
        Drawn already, so that its points are where they stay.
    labels
        Points in data coordinates, texts, and whether they stand out; points without a text are only kept clear of.
    line
        Corners, in data coordinates, of a line that no label shall cover; its pieces go across or up.
    size
        Of the type.
    """
    scale = axis.figure.dpi / 72
    marks = axis.transData.transform([(across, up) for across, up, _, _ in labels]) if labels else np.empty((0, 2))
    taken = [_box(x - MARK * scale, y, 2 * MARK * scale, 2 * MARK * scale) for x, y in marks]
    corners = axis.transData.transform(line) if len(line) else np.empty((0, 2))
    for one, other in pairwise(corners):
        low, high = np.minimum(one, other) - 1, np.maximum(one, other) + 1
        taken.append(Bbox.from_extents(*low, *high))
    inside = axis.get_window_extent()
    inside = Bbox.from_extents(inside.x0, inside.y0, axis.figure.bbox.x1 - 4, inside.y1)
    for mark, (across, up, text, strong) in zip(marks, labels, strict=True):
        if not text:
            continue
        colour = ACCENT if strong else INK if len(text) > 3 else MUTED
        written = axis.annotate(
            text, (across, up), xytext=(0, 0), textcoords="offset points", color=colour, va="center",
            fontsize=size if len(text) > 3 else size - 1.5, fontweight="bold" if strong else "normal",
        )  # fmt: skip
        written.set_path_effects([withStroke(linewidth=2.5, foreground="white")])  # lines pass behind names
        box = written.get_window_extent()
        place = _free_place(mark, box.width, box.height, taken, inside, scale)
        if place is None:
            written.remove()
            continue
        left, middle, away = place
        written.set_position(((left - mark[0]) / scale, (middle - mark[1]) / scale))
        taken.append(_box(left, middle, box.width, box.height))
        if away > LEADER:
            end = (left if left > mark[0] else left + box.width, middle)
            axis.annotate(
                "", (across, up), xytext=((end[0] - mark[0]) / scale, (end[1] - mark[1]) / scale),
                textcoords="offset points", arrowprops={"arrowstyle": "-", "color": MUTED, "lw": 0.6}, zorder=0.5,
            )  # fmt: skip


def _free_place(
    mark: np.ndarray, width: float, height: float, taken: Sequence[Bbox], inside: Bbox, scale: float
) -> tuple[float, float, float] | None:
    """Return left end, middle and distance of the nearest place that covers nothing; None if there is none."""
    for away in DISTANCES:
        gap = away * GAP * scale
        lift = gap * 0.75 + height / 4
        across = (mark[0] + gap, mark[0] - gap - width, mark[0] - width / 2)
        places = [(across[0], 0.0), (across[1], 0.0)]
        places += [(left, up * lift) for left in (across[0], across[2], across[1]) for up in (1.0, -1.0)]
        places += [(left, up * lift * 1.8) for left in (across[0], across[1]) for up in (1.0, -1.0)]
        for left, up in places:
            box = _box(left, mark[1] + up, width, height)
            free = not any(_covers(box, other) for other in taken)
            if free and inside.x0 <= box.x0 and box.x1 <= inside.x1 and inside.y0 <= box.y0 and box.y1 <= inside.y1:
                return left, float(mark[1] + up), away
    return None


def _box(left: float, middle: float, width: float, height: float) -> Bbox:
    return Bbox.from_extents(left, middle - height / 2, left + width, middle + height / 2)


def _covers(one: Bbox, other: Bbox) -> bool:
    """Say whether two boxes share more than a border."""
    return bool(one.x0 < other.x1 and other.x0 < one.x1 and one.y0 < other.y1 and other.y0 < one.y1)
