from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import harmonicface as hf
from harmonicface.bench import enrolment
from harmonicface.bench.benchmark import BenchmarkResult, checked_enrolments, run_benchmark
from harmonicface.bench.enrolment import ENROLMENTS, enrol_by, mean_angle, rig
from harmonicface.bench.report import results, write_report
from harmonicface.bench.table import cost_table, enrolment_table
from harmonicface.errors import HarmonicFaceError

PEOPLE = list(hf.synthetic_people(2, 32, seed=0))


@pytest.fixture(scope="module")
def compared() -> BenchmarkResult:
    return run_benchmark(3, 24, 0, 1, ["harmonic9", "correlation"], enroll=["stereo"])


def test_geometry_is_as_it_is() -> None:
    found = enrol_by("geometry", PEOPLE, 0)
    assert all(a is b for a, b in zip(found.surfaces, PEOPLE, strict=True))
    assert_array_equal(found.degrees, 0)


def test_seven_lamps_give_normals_and_albedo() -> None:
    found = enrol_by("stereo", PEOPLE, 0)
    assert found.refusals == {} and (found.degrees < 8).all() and (found.degrees > 0).all()
    seen, truth = found.surfaces[0], PEOPLE[0]
    assert seen is not None
    both = np.corrcoef(seen.pixel_albedo, truth.grey_albedo)
    assert both[0, 1] > 0.9
    assert_allclose(mean_angle(seen, truth), found.degrees[0])


def test_the_same_seed_gives_the_same_people() -> None:
    one, two, other = (enrol_by("stereo", PEOPLE[:1], seed).surfaces[0] for seed in (0, 0, 1))
    assert one is not None and two is not None and other is not None
    assert_array_equal(one.normals, two.normals)
    assert not np.array_equal(one.normals, other.normals)


def test_lamps_of_the_rig_surround_the_camera() -> None:
    lamps = rig()
    assert_allclose(np.linalg.norm(lamps, axis=1), 1)
    assert_allclose(lamps[1:, 2], np.cos(np.radians(40)))


def test_who_is_refused_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise HarmonicFaceError("no light")

    monkeypatch.setattr(enrolment, "photometric_stereo", refuse)
    monkeypatch.setattr(enrolment, "_environments", refuse)
    found = enrol_by("unknown", PEOPLE[:1], 0)
    assert found.surfaces == [None] and found.refusals == {0: "no light"} and np.isnan(found.degrees).all()
    result = run_benchmark(2, 24, 0, 1, ["harmonic9"], enroll=["unknown"])
    geometry, unknown = result.enrolments
    assert unknown.refused == 2 and unknown.methods == () and np.isnan(unknown.degrees)
    assert enrolment_table(result)[1][1][2:] == ["-"] * 7
    assert results(result)["enrolments"]["unknown"]["normals_deg"] is None  # type: ignore[index]
    assert geometry.refused == 0


def test_ways_are_compared_with_geometry(compared: BenchmarkResult) -> None:
    assert [way.kind for way in compared.enrolments] == ["geometry", "stereo"]
    assert [method.method for method in compared.enrolments[0].methods] == ["harmonic9"]  # others enrol no Surface
    heads, rows = enrolment_table(compared)
    assert heads[:2] == ["method", "by"] and [row[1] for row in rows] == ["geometry", "stereo"]
    geometry = next(method for method in compared.methods if method.method == "harmonic9")
    assert compared.enrolments[0].methods[0].errors == geometry.errors
    scanner, camera = cost_table(compared)[1]
    assert float(scanner[1]) > float(camera[1]) > 1 and scanner[2] == "0.0°"


def test_the_report_tells_what_a_camera_costs(compared: BenchmarkResult, tmp_path: object) -> None:
    page = write_report(compared, tmp_path).read_text()  # type: ignore[arg-type]
    assert "What a camera costs against a scanner" in page and ENROLMENTS["stereo"] in page
    told = results(compared)["enrolments"]
    assert isinstance(told, dict) and told["stereo"]["error_percent"].keys() == {"harmonic9"}


def test_without_a_comparison_there_is_none(small_run: BenchmarkResult) -> None:
    assert small_run.enrolments == () and enrolment_table(small_run)[1] == [] and results(small_run)["enrolments"] == {}


def test_refuses_other_ways() -> None:
    with pytest.raises(HarmonicFaceError, match="enroll: expected one of geometry, stereo, unknown, got 'scan'"):
        enrol_by("scan", PEOPLE, 0)
    with pytest.raises(HarmonicFaceError, match="enroll: expected some of geometry, stereo, unknown, got 'scan'"):
        run_benchmark(2, 24, 0, enroll=["scan"])
    assert checked_enrolments(["unknown"]) == ["geometry", "unknown"]
