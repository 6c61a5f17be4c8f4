"""The published protocol, on made-up files and on the real ones."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

import harmonicface as hf
from harmonicface.bench.contenders import EVERY_METHOD, contender
from harmonicface.bench.yale_b import enrolled_people, evaluate_yale_b
from harmonicface.datasets.yale_b import load_yale_b
from harmonicface.recognition.models import subspace_model
from harmonicface.recognition.subspace import Subspace


def test_every_photograph_is_asked_of_every_method(yale_folder: Path) -> None:
    told: list[tuple[str, int, int]] = []
    result = evaluate_yale_b(yale_folder, progress=lambda *step: told.append(step))
    assert (result.protocol, result.train, result.people) == ("yale-b", "subset1", [1, 2, 3])
    assert result.n == {"1": 21, "2": 6, "3": 6, "4": 6, "5": 3}
    assert list(result.methods) == list(EVERY_METHOD)
    for name, method in result.methods.items():
        assert set(method.error_percent) == set(result.n)
        assert all(0 <= percent <= 100 for percent in method.error_percent.values())
        assert method.ms_per_query > 0
        assert [done for what, done, of in told if what == name] == list(range(43))
        assert {of for what, _, of in told if what == name} == {42}


def test_matte_heads_without_cast_shadows_are_no_problem_for_nine_images(yale_folder: Path) -> None:
    result = evaluate_yale_b(yale_folder, methods=["harmonic9"])
    assert list(result.methods) == ["harmonic9"]
    assert result.methods["harmonic9"].error_percent == dict.fromkeys("12345", 0.0)


def test_some_people_in_the_order_asked_for_and_more_training(yale_folder: Path) -> None:
    result = evaluate_yale_b(yale_folder, [3, 1], "subset12", ["harmonic9", "correlation"])
    assert (result.people, result.train) == ([3, 1], "subset12")
    assert result.n == {"1": 14, "2": 4, "3": 4, "4": 4, "5": 2}
    assert result.methods["correlation"].error_percent["2"] == 0.0  # they were enrolled


def test_a_subset_that_nobody_has_is_left_out(yale_folder: Path, tmp_path: Path) -> None:
    copy = tmp_path / "yale"
    shutil.copytree(yale_folder, copy)
    for path in copy.glob("*/*A+085*"):
        path.unlink()
    result = evaluate_yale_b(copy, methods=["linear3"])
    assert result.n["5"] == 0
    assert set(result.methods["linear3"].error_percent) == set("1234")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"train": "subset9"}, "train: expected one of subset1, subset12, got 'subset9'"),
        ({"people": [2]}, "people: expected at least two to tell apart, got 1"),
        ({"people": [1, 9]}, r"expected people that are in .* \(1-3\), got 9"),
        ({"methods": ["magic"]}, "method: expected one of correlation, .*, got 'magic'"),
        ({"folder": "no such folder"}, r"expected the folder of the Extended Yale B .*, got no folder no such folder"),
    ],
)
def test_bad_input(yale_folder: Path, arguments: dict, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        evaluate_yale_b(**{"folder": yale_folder, **arguments})


def test_too_few_training_photographs(yale_folder: Path, tmp_path: Path) -> None:
    copy = tmp_path / "yale"
    shutil.copytree(yale_folder, copy)
    for path in list((copy / "yaleB02").glob("*A+005*")) + list((copy / "yaleB02").glob("*A-*")):
        path.unlink()
    with pytest.raises(hf.HarmonicFaceError, match="expected"):
        evaluate_yale_b(copy, methods=["harmonic9"])


@pytest.mark.data
def test_the_published_table(data_dir: Path) -> None:
    result = evaluate_yale_b(data_dir / "yaleb", range(1, 11), methods=["correlation", "harmonic9"])
    assert result.n == {"1": 70, "2": 120, "3": 120, "4": 140, "5": 190}
    nine = result.methods["harmonic9"].error_percent
    # Lee, Ho & Kriegman 2005 print 0, 0, 0 and 3.57 for nine harmonic images trained on subset 1
    assert (nine["1"], nine["2"], nine["3"]) == (0, 0, 0)
    assert nine["4"] <= 3.6
    assert result.methods["correlation"].error_percent["4"] > 10 * nine["4"]


@pytest.mark.data
def test_cast_shadows_where_attached_ones_fail(data_dir: Path) -> None:
    # Lee, Ho & Kriegman 2005 print 2.7 % for nine images with cast shadows on subset 4
    faces = load_yale_b(data_dir / "yaleb", range(1, 11))
    people = enrolled_people(faces, depth=True)
    searching = contender("harmonic_shadowed")
    searching.enroll(people)
    rows = np.concatenate([Subspace.of(subspace_model("harmonic_shadowed")(person.surface)).rows for person in people])
    for subset, target in ((4, 2.7), (5, 15)):
        photographs = np.concatenate([face.photographs[face.subsets == subset] for face in faces])
        truth = np.repeat(np.arange(10), [(face.subsets == subset).sum() for face in faces])
        explained = np.square(rows @ photographs.reshape(len(photographs), -1).T).reshape(10, 25, -1).sum(axis=1)
        assert 100 * (explained.argmax(axis=0) != truth).mean() <= target
        found = np.array([searching.nearest(photo) for photo in photographs])
        assert 100 * (found != truth).mean() <= target
