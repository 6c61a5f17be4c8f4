"""Curves and times, on a made-up Yale B."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import harmonicface as hf
from harmonicface.bench.curves import CurvePoint, error_curves, lost_points, spread_lights
from harmonicface.bench.curves_page import curves_picture, timing_table, write_curves_page
from harmonicface.bench.ordeals import ENROLMENT, ORDEALS
from harmonicface.bench.yale_timing import Timing, filled_up, query_times
from harmonicface.datasets.yale_b import YalePerson, load_yale_b


@pytest.fixture(scope="module")
def faces(yale_folder: Path) -> list[YalePerson]:
    return [replace(face, number=number) for face, number in zip(load_yale_b(yale_folder), (1, 2, 6), strict=True)]


@pytest.fixture(scope="module")
def points(faces: list[YalePerson]) -> list[CurvePoint]:
    return error_curves(faces, ["correlation", "harmonic9"], queries=3, every=10)


def test_every_ordeal_is_asked_of_every_method(points: list[CurvePoint]) -> None:
    found = {(point.ordeal, point.level, point.method) for point in points}
    assert len(found) == len(points)
    for ordeal in ORDEALS:
        assert {level for name, level, _ in found if name == ordeal.name} >= {ordeal.still, ordeal.levels[-1]}
    assert {point.asked for point in points} == {9}
    assert {point.asked_unseen for point in points} == {3}  # settings were not chosen on person 6
    assert all(0 <= point.wrong_unseen <= point.wrong <= 9 and point.milliseconds > 0 for point in points)


def test_nothing_goes_wrong_where_nothing_happens(points: list[CurvePoint]) -> None:
    still = {ordeal.name: ordeal.still for ordeal in (*ORDEALS, ENROLMENT)}
    calm = [point for point in points if point.method == "harmonic9" and point.level == still[point.ordeal]]
    assert len(calm) == len(ORDEALS) + 1
    assert {point.wrong for point in calm} == {0}
    assert any(point.wrong for point in points)


def test_a_method_that_needs_more_photographs_has_no_point(points: list[CurvePoint]) -> None:
    enrolled = {(point.level, point.method) for point in points if point.ordeal == "enrolment"}
    assert enrolled == {(1, "correlation"), (7, "correlation"), (7, "harmonic9")}


def test_lights_spread_out() -> None:
    lights = np.array([[0, 0, 1.0], [0.3, 0, 0.95], [0.1, 0, 0.99], [-0.3, 0, 0.95]])
    assert spread_lights(lights) in ([0, 1, 3, 2], [0, 3, 1, 2])


def test_errors_with_and_without_unseen_people() -> None:
    point = CurvePoint("noise", 1, "default", 3, 10, 0, 0, 1.0)
    assert point.error.value == 0.3
    assert point.error_unseen is None
    seen = replace(point, wrong_unseen=1, asked_unseen=4).error_unseen
    assert seen is not None and seen.value == 0.25


def test_where_another_method_is_better() -> None:
    wrong = {"default": 3, "lbph": 2, "harmonic9": 1, "tan_triggs": 3}
    points = [CurvePoint("noise", 1, name, count, 10, 0, 0, 1.0) for name, count in wrong.items()]
    assert [(ours.wrong, best.method) for ours, best in lost_points(points, "default")] == [(3, "harmonic9")]
    assert lost_points(points, "harmonic9") == []
    assert lost_points([replace(point, wrong=2) for point in points], "default") == []
    assert lost_points([replace(points[1], level=2), points[0]], "default") == []


def test_people_who_cannot_be_asked_for(faces: list[YalePerson]) -> None:
    with pytest.raises(hf.HarmonicFaceError, match="people: expected at least two to tell apart, got 1"):
        error_curves(faces[:1])
    with pytest.raises(hf.HarmonicFaceError, match="queries: expected an integer of at least 1, got int 0"):
        error_curves(faces, ["correlation"], queries=0)
    with pytest.raises(hf.HarmonicFaceError, match="every: expected an integer of at least 1, got int 0"):
        error_curves(faces, ["correlation"], every=0)
    for subsets, message in (
        (1, "yaleB02: expected photographs beyond subset 1"),
        (2, "expected photographs in subset 1"),
    ):
        chosen = replace(faces[1], subsets=np.full_like(faces[1].subsets, subsets))
        with pytest.raises(hf.HarmonicFaceError, match=message):
            error_curves([faces[0], chosen], ["correlation"])


def test_a_gallery_is_filled_up(faces: list[YalePerson]) -> None:
    people = filled_up(faces, 8)
    assert [person.name for person in people] == [
        "1", "2", "6", "mirrored 1", "mirrored 2", "mirrored 6", "synthetic 0", "synthetic 1",
    ]  # fmt: skip
    np.testing.assert_array_equal(people[3].photographs, people[0].photographs[:, :, ::-1])
    np.testing.assert_allclose(people[3].surface.normals[..., 0], -people[0].surface.normals[:, ::-1, 0], atol=1e-5)
    assert people[7].photographs.shape == people[0].photographs.shape
    assert len(filled_up(faces, 4)) == 4


def test_times_of_queries(faces: list[YalePerson]) -> None:
    told: list[tuple[str, int, int]] = []
    found = query_times(faces, ["correlation", "nine_points_real", "linear3"], 5, 2, lambda *step: told.append(step))
    assert [(timing.method, timing.people) for timing in found] == [("correlation", 5), ("linear3", 5)]
    assert all(timing.milliseconds > 0 and timing.enrolment_seconds > 0 for timing in found)
    assert told[-1] == ("times", 3, 3)
    with pytest.raises(hf.HarmonicFaceError, match="people: expected 1 to 2, got 3"):
        query_times(faces, ["correlation"], 2)


def test_the_page_stands_alone(points: list[CurvePoint], tmp_path: Path) -> None:
    timings = [Timing("correlation", 38, 1.25, 0.5, 2048)]
    text = write_curves_page(points, timings, [1, 2, 6], tmp_path / "curves.html").read_text(encoding="utf-8")
    assert not re.search(r'(src|href)="(?!data:)', text)
    for told in ("gallery of 38 people", "<td>1.25</td>", "shift, pixels at 84 x 96", "<th>none</th>", "<td>-</td>"):
        assert told in text
    assert timing_table(timings)[1] == [["correlation", "1.25", "0.50", "2"]]
    assert curves_picture(points) != curves_picture([replace(point, wrong=9) for point in points])
    ours = [replace(point, method="default", wrong=9) for point in points if point.method == "harmonic9"]
    text = write_curves_page([*points, *ours], timings, [1, 2, 6], tmp_path / "curves.html").read_text("utf-8")
    assert "Another method has fewer errors than default at noise 0 (" in text
    assert "glasses dark (" in text
    alone = [replace(point, asked_unseen=0) for point in points if point.ordeal == "noise"]
    assert "shift" not in write_curves_page(alone, [], [1, 2], tmp_path / "curves.html").read_text(encoding="utf-8")
