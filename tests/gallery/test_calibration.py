"""Calibrating a gallery: the threshold from searches by people who are not in it, and what it promises."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.datasets.yale_b import load_yale_b
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.calibration import LAMPS
from harmonicface.gallery.gallery import Gallery
from harmonicface.recognition.identification import expected_fpir, open_set
from harmonicface.recognition.strangers import Strangers

PEOPLE = list(hf.synthetic_people(9, 48, seed=11))
LAMP = hf.lights.directional([0.3, 0.2, 1.0])


def gallery_of(count: int, **options: object) -> Gallery:
    gallery = Gallery(**options)  # type: ignore[arg-type]
    for number, surface in enumerate(PEOPLE[:count]):
        gallery.enroll(str(number), surface)
    return gallery


def picture(person: int, seed: int = 0) -> np.ndarray:
    return hf.photograph(hf.render(PEOPLE[person], LAMP), np.random.default_rng(seed))


def test_the_threshold_is_set_and_told() -> None:
    gallery = gallery_of(4)
    found = gallery.calibrate(fpir=0.02)
    assert gallery.threshold == found.threshold and found.fpir == 0.02
    assert (found.people, found.strangers, found.searches) == (4, 4, 4 * len(LAMPS))
    assert found.seen.trials == found.searches and found.seen.high > found.seen.low
    assert list(found.expected) == [4, 40, 400, 4000]
    assert found.expected[4] <= 0.02 * 1.0001
    for people, expected in found.expected.items():
        assert expected == pytest.approx(expected_fpir(found.fmr, people))
    assert "20 searches by 4 people" in str(found) and "with 4000 people" in str(found)
    assert "100 % with 9 people" in str(replace(found, expected={4: 0.01, 9: 0.9999}))


def test_everybody_is_left_out_of_her_own_searches() -> None:
    gallery = gallery_of(4)
    names = ["0", "0", "2"]
    photographs = [picture(0), picture(0, 1), picture(2)]
    found = gallery.calibrate(0.05, photographs, names)
    tables = [
        np.stack([gallery.search_scores(photo, among=others).scores for photo in photos])
        for photos, others in ((photographs[:2], ["1", "2", "3"]), (photographs[2:], ["0", "1", "3"]))
    ]
    assert found.threshold == Strangers.of(tables, 4).threshold(0.05, 4)
    assert (found.strangers, found.searches) == (2, 3)


def test_strangers_search_the_whole_gallery() -> None:
    gallery = gallery_of(4)
    photographs = [picture(person) for person in (5, 6, 7)]
    found = gallery.calibrate(0.05, photographs)
    tables = [gallery.search_scores(photo).scores[None] for photo in photographs]
    assert found.threshold == Strangers.of(tables, 4).threshold(0.05, 4)
    assert gallery.calibrate(0.05, photographs, ["a", "b", "c"]).threshold == found.threshold
    assert gallery.calibrate(0.05, photographs, ["a", "a", "c"]).strangers == 2


def test_who_is_enrolled_is_named_then_and_strangers_are_not() -> None:
    gallery = gallery_of(6)
    gallery.calibrate(0.01)
    assert [gallery.match(picture(person)).name for person in range(6)] == list("012345")
    assert [gallery.match(picture(person)).name for person in range(6, 9)] == [None] * 3


def test_a_stricter_rate_and_a_larger_gallery_need_more() -> None:
    gallery = gallery_of(5)
    thresholds = [gallery.calibrate(fpir).threshold for fpir in (0.1, 0.01, 0.001)]
    assert thresholds == sorted(thresholds) and len(set(thresholds)) == 3


def test_photographs_stand_for_themselves() -> None:
    gallery = Gallery()
    own = [picture(person) for person in range(4)]
    for person, photo in enumerate(own):
        gallery.enroll(str(person), photo)
    found = gallery.calibrate(0.01)
    assert (found.strangers, found.searches) == (4, 4)
    assert found.threshold == pytest.approx(gallery.calibrate(0.01, own, list("0123")).threshold, rel=1e-3)


@pytest.mark.parametrize("model", ["harmonic9", "linear3", "harmonic_shadowed"])
def test_models_that_rank_by_distance_get_a_distance(model: str) -> None:
    gallery = gallery_of(4, model=model)
    found = gallery.calibrate(0.01)
    assert gallery.threshold == found.threshold and 0 < found.threshold < 1
    assert gallery.margin == np.inf
    strangers = [gallery.search_scores(picture(person)).distances.min() for person in range(5, 9)]
    assert found.threshold < min(strangers)


def test_the_pictures_that_stand_for_a_person_are_her_harmonic_images() -> None:
    gallery = gallery_of(2)
    expected = np.zeros((9, *PEOPLE[0].shape))
    expected[:, PEOPLE[0].mask] = hf.harmonic_images(PEOPLE[0])
    assert_allclose(gallery.pictures_of("0"), expected, atol=1e-5)
    assert gallery.source_of("0") == "surface"


def test_scores_among_some_are_those_of_a_smaller_gallery() -> None:
    large, small = gallery_of(5), gallery_of(3)
    for photo in (picture(1), picture(7)):
        found, expected = large.search_scores(photo, among=["0", "1", "2"]), small.search_scores(photo)
        assert found.names == expected.names
        assert_allclose(found.scores, expected.scores)
    projected = gallery_of(5, model="harmonic9").search_scores(picture(1), among=["3", "1"])
    assert projected.names == ("3", "1")
    assert projected.distances[1] < projected.distances[0]


def test_only_so_many_are_compared_as_a_shortlist_holds() -> None:
    gallery = gallery_of(7, shortlist=3)
    assert gallery.calibrate(0.01).searches == 7 * len(LAMPS)


@pytest.mark.data
def test_half_of_the_people_of_yale_b_are_unknown(data_dir: Path) -> None:
    faces = load_yale_b(data_dir / "yaleb")
    known, unknown = faces[:8:2], faces[1:8:2]
    gallery = Gallery()
    for face in known:
        chosen = face.subsets == 1
        gallery.enroll(str(face.number), face.photographs[chosen], lights=face.lights[chosen])
    photographs = [photo for face in known for photo in face.photographs[face.subsets == 1]]
    found = gallery.calibrate(0.01, photographs, [str(face.number) for face in known for _ in range(7)])
    hard = {face.number: face.photographs[np.isin(face.subsets, (3, 4))][::4] for face in [*known, *unknown]}
    scores = [gallery.search_scores(photo).scores for face in known for photo in hard[face.number]]
    people = np.repeat(np.arange(4), [len(hard[face.number]) for face in known])
    strangers = [gallery.search_scores(photo).scores.max() for face in unknown for photo in hard[face.number]]
    judged = open_set(scores, people, strangers, found.threshold)
    assert judged.fpir.value <= 0.02
    assert judged.identified >= 0.95


@pytest.mark.parametrize(
    ("count", "arguments", "message"),
    [
        (1, {}, "calibrate: expected a gallery of at least two people, got 1"),
        (2, {}, "calibrate: expected at least 3 people, each to be left out once, or photographs of others, got 2"),
        (3, {"fpir": 0}, "fpir: expected a rate between 0 and 1, got 0"),
        (3, {"names": ["a"]}, "names: expected them with photographs only, got names alone"),
        (3, {"photographs": [picture(5)], "names": ["a", "b"]}, "names: expected one for each of 1 photographs, got 2"),
        (3, {"photographs": [picture(5)]}, "scores: expected those of at least two strangers, got 1"),
        (3, {"photographs": [np.ones(4)] * 2}, "photograph 0: expected an image"),
        (3, {"photographs": []}, "scores: expected those of at least two strangers, got 0"),
    ],
)
def test_bad_input(count: int, arguments: dict, message: str) -> None:
    gallery = gallery_of(count)
    before = gallery.threshold
    with pytest.raises(HarmonicFaceError, match=message):
        gallery.calibrate(**arguments)
    assert gallery.threshold == before


def test_bad_names() -> None:
    gallery = gallery_of(2)
    with pytest.raises(HarmonicFaceError, match="among: expected at least one name, got none"):
        gallery.search_scores(picture(0), among=[])
    with pytest.raises(HarmonicFaceError, match="among: expected each name once, got 3 of 2 people"):
        gallery.search_scores(picture(0), among=["0", "1", "0"])
    for ask in (gallery.pictures_of, gallery.source_of, lambda name: gallery.search_scores(picture(0), among=[name])):
        with pytest.raises(HarmonicFaceError, match="name: expected somebody in the gallery, got 'x', who is not"):
            ask("x")
