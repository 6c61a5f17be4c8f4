from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from harmonicface.datasets.yale_b import load_yale_b
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.baselines import BASELINES, Baseline, baseline

PEOPLE = [np.random.default_rng(person).uniform(0, 1, (3, 16, 12)).astype(np.float32) for person in range(4)]

for_each = pytest.mark.parametrize("make", BASELINES.values(), ids=BASELINES)


def test_the_names() -> None:
    assert list(BASELINES) == ["correlation", "eigenfaces", "eigenfaces_minus3", "fisherfaces", "lbph"]


@for_each
def test_a_photograph_is_of_who_is_in_it(make: Callable[[], Baseline]) -> None:
    method = make()
    method.enroll(PEOPLE)
    assert [method.nearest(photo) for person in PEOPLE for photo in person] == [0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3]
    assert method.bytes_per_person > 0


@for_each
def test_photographs_may_differ_in_number_and_lie_anyhow_in_memory(make: Callable[[], Baseline]) -> None:
    method = make()
    method.enroll([PEOPLE[0][:2], PEOPLE[1].astype(np.float64), np.asfortranarray(PEOPLE[2])])
    assert method.nearest(np.asfortranarray(PEOPLE[1][2])) == 1
    assert method.nearest(PEOPLE[2][0]) == 2


@for_each
def test_nobody_is_enrolled(make: Callable[[], Baseline]) -> None:
    with pytest.raises(HarmonicFaceError, match="expected people to be enrolled before a photo is matched"):
        make().nearest(PEOPLE[0][0])


@for_each
@pytest.mark.parametrize(
    ("photo", "message"),
    [
        (PEOPLE[0][0, :8], r"photo: expected shape \(16, 12\), got"),
        (PEOPLE[0][0] * np.nan, "photo: expected finite numbers"),
    ],
)
def test_a_bad_query(make: Callable[[], Baseline], photo: np.ndarray, message: str) -> None:
    method = make()
    method.enroll(PEOPLE)
    with pytest.raises(HarmonicFaceError, match=message):
        method.nearest(photo)


@for_each
@pytest.mark.parametrize(
    ("people", "message"),
    [
        ([], "expected those of at least one person, got none"),
        ([PEOPLE[0], PEOPLE[1][:, :8]], "photographs of person 1: expected images of shape"),
        ([PEOPLE[0], PEOPLE[1] * np.nan], "photographs of person 1: expected finite numbers"),
    ],
)
def test_bad_photographs_leave_those_enrolled_as_they_were(
    make: Callable[[], Baseline], people: list[np.ndarray], message: str
) -> None:
    method = make()
    method.enroll(PEOPLE)
    with pytest.raises(HarmonicFaceError, match=message):
        method.enroll(people)
    assert method.nearest(PEOPLE[3][1]) == 3


def test_no_such_baseline() -> None:
    with pytest.raises(HarmonicFaceError, match=r"baseline: expected one of correlation, eigenfaces, .*, got 'magic'"):
        baseline("magic")


@for_each
@pytest.mark.data
def test_light_near_that_of_the_training_is_no_problem(make: Callable[[], Baseline], data_dir: Path) -> None:
    people = load_yale_b(data_dir / "yaleb", range(1, 6))
    method = make()
    method.enroll([person.photographs[person.subsets == 1, ::3, ::3] for person in people])
    near = [(index, photo) for index, person in enumerate(people) for photo in person.photographs[person.subsets == 2]]
    errors = sum(method.nearest(photo[::3, ::3]) != index for index, photo in near)
    assert errors <= 0.1 * len(near)
