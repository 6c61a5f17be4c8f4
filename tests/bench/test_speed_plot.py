"""The plot of speed against error: its points, its front, and names that do not cover each other."""

from __future__ import annotations

import io
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from harmonicface.bench import speed_plot
from harmonicface.bench.labels import place_labels
from harmonicface.bench.measure import Record
from harmonicface.bench.speed_plot import Point, pareto_front, points_of, short, speed_error_picture

POINTS = st.lists(st.tuples(st.integers(1, 9), st.integers(0, 9)), min_size=1, max_size=12)


def painted(png: bytes, colour: str) -> np.ndarray:
    """Return where a colour is."""
    picture = np.asarray(Image.open(io.BytesIO(png)).convert("RGB"))
    wanted = [int(colour[place : place + 2], 16) for place in (1, 3, 5)]
    return np.asarray((picture == wanted).all(axis=2))


@given(POINTS)
def test_nothing_beats_the_front_and_everything_else_is_beaten(pairs: list[tuple[int, int]]) -> None:
    points = [Point(str(number), *pair) for number, pair in enumerate(pairs)]
    front = pareto_front(points)
    for one in front:
        assert not any(other.seconds <= one.seconds and other.error < one.error for other in points)
    for one in points:
        assert any(other.seconds <= one.seconds and other.error <= one.error for other in front)
    assert [one.seconds for one in front] == sorted({one.seconds for one in front})


def test_records_of_one_question_and_unit_share_a_plot() -> None:
    def made(question: str, unit: str, name: str, seconds: float, error: float | None = 1.0) -> Record:
        return Record(name, "9 people", seconds, error, question=question, unit=unit)

    found = points_of(
        [
            made("faces", "%", "faces, fast", 1.0),
            made("faces", "%", "faces: slow", 2.0),
            made("faces", "degrees", "faces, other", 2.0),  # alone
            made("lights", "%", "a", 1.0),
            made("lights", "%", "a", 1.5, 0.0),  # twice the same name: the size tells them apart
            made("none", "%", "b", 1.0, None),
            made("none", "%", "c", 1.0, float("nan")),
        ]
    )
    assert {which: [point.name for point in points] for which, points in found.items()} == {
        ("faces", "%"): ["fast", "slow"],
        ("lights", "%"): ["a, 9 people", "a, 9 people"],
    }
    assert [point.number for point in found["lights", "%"]] == [4, 5]


def test_a_peer_that_stands_in_many_rows_is_one_point() -> None:
    rows = [
        Record(f"order {order}", "", 0.1 * order, 1 / order, peer="a.b.c, exactly", peer_seconds=3.0, peer_error=0.0)
        for order in (1, 2, 3)
    ]
    points = points_of(rows)["", ""]
    assert [point.name for point in points if not point.ours] == ["b.c, exactly"]
    assert len(points) == 4


def test_a_peer_without_an_error_is_no_point() -> None:
    rows = [Record(name, "", 1.0, 1.0, peer="a", peer_seconds=1.0) for name in "ab"]
    assert all(point.ours for point in points_of(rows)["", ""])


def test_short_names() -> None:
    assert short("sum") == "sum"
    assert short("a.b.c + d.e.f, both") == "b.c + e.f, both"
    assert short("scipy.optimize.nnls, on all. pixels") == "optimize.nnls, on all. pixels"


def test_ours_peers_and_the_front_have_their_colours() -> None:
    ours, peer = Point("ours", 1.0, 1.0), Point("peer", 2.0, 0.5, ours=False)
    assert painted(speed_error_picture([ours]), speed_plot.ACCENT).sum() > 100
    assert not painted(speed_error_picture([peer]), speed_plot.ACCENT).any()
    assert painted(speed_error_picture([ours, peer]), speed_plot.ACCENT).any()


def test_faster_is_to_the_left_and_more_exact_further_down() -> None:
    heights, places = [], []
    for seconds, error in ((1.0, 1.0), (10.0, 0.1)):
        others = [Point("", 1.0, 0.1, False), Point("", 10.0, 1.0, False)]  # the same range in both
        rows, columns = np.nonzero(
            painted(speed_error_picture([Point("", seconds, error), *others]), speed_plot.ACCENT)
        )
        below = rows > 60  # the legend stands above
        heights.append(rows[below].mean())
        places.append(columns[below].mean())
    assert places[0] < places[1] - 100
    assert heights[0] < heights[1] - 100


@pytest.mark.parametrize("errors", [[0.0, 0.0], [0.0, 1e-16], [1e-16, 1e3], [1.0, 1.0], [99.0, 100.0]])
@pytest.mark.parametrize("times", [[1e-7, 1e3], [1.0, 1.0]])
def test_every_range_can_be_drawn(errors: list[float], times: list[float]) -> None:
    points = [Point("one", times[0], errors[0]), Point("other", times[1], errors[1], low=0.0, high=200.0)]
    assert speed_error_picture(points, "%").startswith(b"\x89PNG")


@pytest.mark.parametrize("count", [3, 12, 40])
def test_names_cover_neither_each_other_nor_points_nor_the_line(count: int) -> None:
    rng = np.random.default_rng(count)
    figure = Figure(figsize=(8, 5))
    FigureCanvasAgg(figure)
    axis = figure.add_subplot()
    axis.set_xlim(-0.1, 1.4)
    axis.set_ylim(-0.1, 1.1)
    points = rng.uniform(size=(count, 2))
    figure.draw_without_rendering()
    line = [(0.2, 0.9), (0.5, 0.9), (0.5, 0.3)]
    place_labels(
        axis, [(*point, f"name {number} of a method", number == 0) for number, point in enumerate(points)], line
    )
    names = [text for text in axis.texts if text.get_text()]
    boxes = [text.get_window_extent() for text in names]
    assert len(boxes) >= min(count, 12)  # the first ones find a place
    for one, other in combinations(boxes, 2):
        assert not one.shrunk(0.98, 0.98).overlaps(other.shrunk(0.98, 0.98))
    marks = axis.transData.transform(points)
    corners = axis.transData.transform([(0.35, 0.9), (0.5, 0.6)])
    for box in boxes:
        assert not any(box.contains(*mark) for mark in (*marks, *corners))
        assert box.x0 >= axis.get_window_extent().x0
        assert box.x1 <= figure.bbox.x1


def test_no_points_need_no_names() -> None:
    axis = Figure().add_subplot()
    place_labels(axis, [])
    place_labels(axis, [(0.5, 0.5, "", False)])
    assert not axis.texts


def test_names_keep_clear_of_points_without_names() -> None:
    figure = Figure(figsize=(8, 5))
    FigureCanvasAgg(figure)
    axis = figure.add_subplot()
    figure.draw_without_rendering()
    beside = [(0.3 + 0.01 * number, 0.5, "", False) for number in range(30)]
    place_labels(axis, [(0.3, 0.5, "a name", True), *beside])
    box = axis.texts[0].get_window_extent()
    assert not any(box.contains(*axis.transData.transform(one[:2])) for one in beside)
