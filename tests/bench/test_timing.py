"""A row times what it names, or there is no row."""

from __future__ import annotations

from functools import cache, partial

import cv2
import numpy as np
import pytest
import trimesh
from scipy.optimize import least_squares, nnls
from scipy.special import sph_harm_y_all
from trimesh.ray.ray_pyembree import RayMeshIntersector

import harmonicface as hf
from harmonicface.bench import timing, watching
from harmonicface.bench.timing import Call, Stopwatch, Timing, best, in_turn, once, record
from harmonicface.bench.watching import Function, name_of


def by_nnls() -> object:
    return nnls(np.eye(2), np.ones(2))


def not_by_nnls() -> object:
    return np.linalg.lstsq(np.eye(2), np.ones(2))


@pytest.mark.parametrize(
    ("function", "name"),
    [
        (nnls, "scipy.optimize.nnls"),  # not scipy.optimize._nnls.nnls
        (np.copyto, "numpy.copyto"),
        (np.ones(2).sum, "numpy.ndarray.sum"),
        (np.ndarray.sum, "numpy.ndarray.sum"),
        (sph_harm_y_all, "scipy.special.sph_harm_y_all"),  # an object that is no function
        (cv2.face.LBPHFaceRecognizer.create().predict, "cv2.face.LBPHFaceRecognizer.predict"),
        (least_squares, "scipy.optimize.least_squares"),  # of a private module that bears its name
        (hf.Gallery().match, "harmonicface.Gallery.match"),
        (hf.estimate_light, "harmonicface.estimate_light"),
        (hf.lights.directional([0, 0, 1]).irradiance, "harmonicface.lighting.sources.DirectionalLights.irradiance"),
    ],
)
def test_a_function_is_named_by_where_it_is_found(function: Function, name: str) -> None:
    assert name_of(function) == name


def test_a_decorated_method_is_named_by_its_class() -> None:
    caster = RayMeshIntersector(trimesh.creation.box())
    assert name_of(caster.intersects_first) == "trimesh.ray.ray_pyembree.RayMeshIntersector.intersects_first"


def test_a_function_of_a_script_is_named_by_its_file(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(by_nnls, "__module__", "__main__")
    monkeypatch.setattr("sys.modules", {**watching.sys.modules, "__main__": timing})
    assert name_of(by_nnls) == "by_nnls of timing.py"


def test_what_is_called_by_a_helper_is_seen() -> None:
    assert Call(by_nnls, nnls, about="of two").name == "scipy.optimize.nnls, of two"
    timed = best(Call(by_nnls, nnls), repeats=2)
    assert timed.name == "scipy.optimize.nnls"
    assert list(timed.versions) == ["scipy"]
    assert once(Call(by_nnls, nnls))[1][1] == 0  # type: ignore[index]


@pytest.mark.parametrize("measured", [best, once, partial(in_turn, lambda: None)])
def test_a_row_cannot_name_what_it_does_not_call(measured: Function) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=r"nnls: expected a call of scipy\.optimize\.nnls, got none"):
        measured(Call(not_by_nnls, nnls))


def test_an_answer_that_is_remembered_is_found_out() -> None:
    """The first call is that of the peer, the others look its answer up."""
    remembered = cache(by_nnls)
    with pytest.raises(hf.HarmonicFaceError, match=r"nnls: expected a call of scipy\.optimize\.nnls, got none"):
        best(Call(lambda: remembered(), nnls))


def test_all_that_is_named_is_to_be_called() -> None:
    name = r"scipy\.optimize\.nnls \+ numpy\.linalg\.lstsq: expected a call of scipy\.optimize\.nnls, got none"
    with pytest.raises(hf.HarmonicFaceError, match=name):
        best(Call(not_by_nnls, nnls, np.linalg.lstsq))


def test_decorators_of_one_kind_are_told_apart() -> None:
    caster = RayMeshIntersector(trimesh.creation.box())
    ray = [[0.0, 0.0, 5.0]], [[0.0, 0.0, -1.0]]
    assert best(Call(lambda: caster.intersects_first(*ray), caster.intersects_first), 1).name.endswith("first")
    with pytest.raises(hf.HarmonicFaceError, match="contains_points, got none"):
        best(Call(lambda: caster.intersects_first(*ray), caster.contains_points))


def test_built_in_methods_are_seen_also_by_their_base() -> None:
    model = cv2.face.LBPHFaceRecognizer.create()
    picture = np.zeros((24, 24), np.uint8)
    model.train([picture], np.array([0]))
    for named in (model.predict, cv2.face.FaceRecognizer.predict):
        assert best(Call(lambda: model.predict(picture), named), 1).name.endswith("predict")
    with pytest.raises(hf.HarmonicFaceError, match=r"EigenFaceRecognizer\.predict, got none"):
        best(Call(lambda: model.predict(picture), cv2.face.EigenFaceRecognizer.create().predict))


def test_what_no_profiler_sees_is_timed_by_itself() -> None:
    with pytest.raises(hf.HarmonicFaceError, match=r"numpy\.copyto: expected a function whose calls can be seen"):
        best(Call(lambda: np.copyto(np.ones(2), 0), np.copyto))
    assert best(Call(partial(np.copyto, np.ones(2), 0)), 1).name == "numpy.copyto"


def test_a_stopwatch_watches_its_first_call() -> None:
    watch = Stopwatch(nnls, about="of two")
    assert watch.run(by_nnls)[1] == 0  # type: ignore[index]
    watch.run(by_nnls)
    watch.seconds[:] = [1.0, 3.0]
    assert (watch.timing().name, watch.timing().seconds, watch.timing(min).seconds) == (
        "scipy.optimize.nnls, of two",
        2,
        1,
    )
    with pytest.raises(hf.HarmonicFaceError, match="got none"):
        Stopwatch(nnls).run(not_by_nnls)


def test_watching_ends_with_the_call(monkeypatch: pytest.MonkeyPatch) -> None:
    before = watching.sys.getprofile()
    best(Call(by_nnls, nnls))
    assert watching.sys.getprofile() is before
    with pytest.raises(ZeroDivisionError):
        best(Call(lambda: 1 / 0, nnls))
    assert watching.sys.getprofile() is before


def test_the_best_of_several_in_turn(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = iter(np.cumsum([0, 5, 0, 4, 0, 9, 0, 7, 0, 2, 0, 8, 0, 3, 0, 6]))
    monkeypatch.setattr(timing.time, "perf_counter", lambda: next(clock))
    ours, peer = in_turn(lambda: None, Call(by_nnls), rounds=2, repeats=2)
    assert (ours.seconds, peer.seconds) == (2, 3)


def test_a_record_takes_name_and_time_of_its_peer_together() -> None:
    found = record("a", "b", Timing("mine", 1.0), Timing("theirs", 2.0, {"other": "1"}), error=0.5, peer_error=0.25)
    assert (found.call, found.peer, found.peer_seconds, found.ratio) == ("mine", "theirs", 2.0, 0.5)
    assert found.versions["other"] == "1"
    assert record("a", "b", Timing("", 1.0)).peer is None


def test_a_peer_without_a_name_is_refused() -> None:
    with pytest.raises(hf.HarmonicFaceError, match="a: expected a peer that tells which function it calls"):
        record("a", "b", Timing("", 1.0), best(lambda: by_nnls()))
