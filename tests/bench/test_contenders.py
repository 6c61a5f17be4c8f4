"""A row of the benchmark is the method that it names."""

from __future__ import annotations

import numpy as np
import pytest

import harmonicface as hf
from harmonicface.bench.contenders import (
    EVERY_METHOD,
    METHODS,
    GalleryContender,
    Person,
    PhotographContender,
    ShiftedContender,
    contender,
)
from harmonicface.recognition.correlation import Correlation
from harmonicface.recognition.opencv import Eigenfaces, Fisherfaces, LocalBinaryPatterns

LAMPS = [hf.lights.directional(towards) for towards in ([0, 0, 1], [0.1, 0, 1], [0, 0.1, 1], [-0.1, 0, 1])]
PEOPLE = [
    Person(f"p{number}", np.stack([hf.photograph(hf.render(face, lamp), number) for lamp in LAMPS]), face)
    for number, face in enumerate(hf.synthetic_people(4, 24, seed=1))
]


def test_the_names() -> None:
    photographs = ("correlation", "eigenfaces", "eigenfaces_minus3", "fisherfaces", "lbph")
    assert list(METHODS) == [
        *photographs,
        "linear3",
        "ambient4",
        "harmonic9",
        "pca3",
        "pca5",
        "pca_auto",
        "auto",
        "default",
    ]
    assert [*METHODS, "harmonic_shadowed", "harmonic_shadowed_fixed"] == list(EVERY_METHOD)


@pytest.mark.parametrize(
    ("name", "kind", "dropped"),
    [
        ("correlation", Correlation, None),
        ("eigenfaces", Eigenfaces, 0),
        ("eigenfaces_minus3", Eigenfaces, 3),
        ("fisherfaces", Fisherfaces, None),
        ("lbph", LocalBinaryPatterns, None),
    ],
)
def test_methods_that_learn_from_photographs(name: str, kind: type, dropped: int | None) -> None:
    made = contender(name)
    assert isinstance(made, PhotographContender)
    assert type(made.baseline) is kind
    assert getattr(made.baseline, "_drop_first", None) == dropped


@pytest.mark.parametrize("name", ["linear3", "ambient4", "harmonic9", "pca3", "pca5", "pca_auto", "auto", "default"])
def test_methods_that_know_the_surface(name: str) -> None:
    made = contender(name)
    assert isinstance(made, GalleryContender)
    assert made.gallery.model == name


def test_shadows_with_and_without_a_search_for_shifts() -> None:
    searching, fixed = contender("harmonic_shadowed"), contender("harmonic_shadowed_fixed")
    assert isinstance(searching, ShiftedContender) and isinstance(fixed, GalleryContender)
    assert searching.model == fixed.gallery.model == "harmonic_shadowed"
    assert searching.bytes_per_person == fixed.bytes_per_person == 0
    searching.enroll(PEOPLE)
    assert searching.bytes_per_person == 25 * 12 * 12 * 4


@pytest.mark.parametrize("name", EVERY_METHOD)
def test_everybody_is_found_in_an_enrolled_photograph(name: str) -> None:
    method = contender(name)
    method.enroll(PEOPLE)
    assert [method.nearest(person.photographs[0]) for person in PEOPLE] == [0, 1, 2, 3]
    assert method.bytes_per_person > 0


@pytest.mark.parametrize(
    ("name", "rows"),
    [("linear3", 3), ("ambient4", 4), ("harmonic9", 9), ("pca3", 3), ("pca5", 5), ("harmonic_shadowed_fixed", 25)],
)
def test_memory_of_a_gallery_is_its_rows(name: str, rows: int) -> None:
    method = contender(name)
    method.enroll(PEOPLE)
    assert method.bytes_per_person == rows * 24 * 24 * 4


def test_contenders_are_fresh() -> None:
    used = contender("harmonic9")
    used.enroll(PEOPLE)
    contender("harmonic9").enroll(PEOPLE)


def test_no_such_method() -> None:
    with pytest.raises(
        hf.HarmonicFaceError, match=r"method: expected one of correlation, .*harmonic_shadowed_fixed, got 'magic'"
    ):
        contender("magic")
