"""Galleries with a shared basis against the same ones without: the same answers, in memory and in a folder."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import harmonicface as hf
from harmonicface.gallery.enrolled import people as gallery_people
from harmonicface.gallery.enrolled.people_in_folder import PeopleInFolder
from harmonicface.gallery.match import Match

SIZE = 24
MODELS = ("default", "harmonic9")


def photographs(count: int, seed: int) -> np.ndarray:
    """Random photographs: what nobody's subspace knows."""
    return np.random.default_rng(seed).uniform(0, 1, (count, SIZE, SIZE)).astype(np.float32)


def people(count: int, seed: int = 0) -> dict[str, object]:
    """People of nine rows, of five photographs, of one, and some who are enrolled twice."""
    rng = np.random.default_rng(seed)
    found: dict[str, object] = {}
    for number, surface in enumerate(hf.synthetic_people(count, SIZE, seed=seed)):
        kind = number % 4
        lights = [hf.lights.directional([*rng.normal(size=2), 1.5]) for _ in range(5)]
        if kind == 1:
            found[f"five {number}"] = np.stack([hf.render(surface, light) for light in lights])
        elif kind == 2:
            found[f"three {number}"] = np.stack([hf.render(surface, light) for light in lights[:3]])
        else:
            found[f"nine {number}"] = surface
        if kind == 3:
            found[f"twin {number}"] = surface
    return found


PEOPLE = people(16)
PHOTOS = [
    *(hf.render(one, hf.lights.natural(seed)) for seed, one in enumerate(hf.synthetic_people(2, SIZE, seed=0))),
    *(hf.render(one, hf.lights.directional([0.5, 0.2, 1])) for one in hf.synthetic_people(1, SIZE, seed=9)),
    *photographs(1, 1),
]


def enrolled(gallery: hf.Gallery) -> hf.Gallery:
    for name, source in PEOPLE.items():
        gallery.enroll(name, source)  # type: ignore[arg-type]
    return gallery


def said(match: Match) -> tuple[object, ...]:
    light = None if match.light is None else match.light.values.tolist()
    return match.name, match.distance, match.margin, match.candidates, match.reason, light


def same_answers(one: hf.Gallery, other: hf.Gallery) -> None:
    for photo in PHOTOS:
        for top in (1, 7) if one.by_score else (1, 5, 40):
            assert said(one.match(photo, top)) == said(other.match(photo, top))
        assert one.within(photo, 0.3) == other.within(photo, 0.3)
    masked = np.random.default_rng(0).uniform(size=(SIZE, SIZE)) < 0.8
    assert said(one.match(PHOTOS[0], mask=masked)) == said(other.match(PHOTOS[0], mask=masked))
    together = [said(match) for match in one.match_many(PHOTOS, 3)]
    assert together == [said(match) for match in other.match_many(PHOTOS, 3)]
    assert together == [said(other.match(photo, 3)) for photo in PHOTOS]


@pytest.mark.parametrize("model", MODELS)
def test_in_memory(model: str) -> None:
    plain, indexed = (enrolled(hf.Gallery(model, shortlist=6)) for _ in range(2))
    indexed.index(people=10, seed=1)
    same_answers(plain, indexed)
    for gallery in (plain, indexed):
        gallery.remove("nine 0")
        gallery.rename("nine 3", "first of twins")
        gallery.enroll("nine 0", PEOPLE["nine 4"])  # type: ignore[arg-type]
    same_answers(plain, indexed)


@pytest.mark.parametrize(
    ("model", "dtype"), [("default", "float32"), ("harmonic9", "float32"), ("harmonic9", "float16")]
)
def test_in_a_folder(tmp_path: Path, model: str, dtype: str) -> None:
    plain, indexed = (
        enrolled(hf.Gallery.create(tmp_path / name, model, shortlist=6, dtype=dtype)) for name in ("plain", "indexed")
    )
    indexed.index(people=10, seed=1)
    same_answers(plain, indexed)
    for gallery in (plain, indexed):
        gallery.remove("nine 0")
        gallery.rename("nine 3", "first of twins")
        gallery.enroll("nine 0", PEOPLE["nine 4"])  # type: ignore[arg-type]
    indexed.index(people=30, seed=2)
    same_answers(plain, hf.Gallery.open(tmp_path / "indexed"))
    assert indexed.verify() == ()
    if dtype == "float32" and model == "harmonic9":
        same_answers(enrolled_as(plain, model), indexed)


def enrolled_as(kept: hf.Gallery, model: str) -> hf.Gallery:
    """Return a gallery in memory of the same people in the same order."""
    gallery = enrolled(hf.Gallery(model, shortlist=6))
    gallery.remove("nine 0")
    gallery.rename("nine 3", "first of twins")
    gallery.enroll("nine 0", PEOPLE["nine 4"])  # type: ignore[arg-type]
    assert gallery.names == kept.names
    return gallery


@settings(deadline=None, max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.lists(st.sampled_from([1, 3, 5, 9]), min_size=2, max_size=12),
    st.integers(0, 1000),
    st.integers(1, 14),
    st.floats(0, 1),
)
def test_any_gallery_any_photograph(ranks: list[int], seed: int, top: int, distance: float) -> None:
    rng = np.random.default_rng(seed)
    plain, indexed = hf.Gallery("linear3"), hf.Gallery("linear3")
    shared = rng.uniform(0, 1, (25, 8, 8))
    for number, rank in enumerate(ranks):
        photos = rng.uniform(0, 1, (max(rank, 3), 8, 8)) + 4 * rng.permutation(shared)[: max(rank, 3)]
        for gallery in (plain, indexed):
            gallery.enroll(str(number), photos)
    indexed.index(people=4, seed=seed)
    photo = rng.uniform(0, 1, (8, 8)) + rng.uniform(0, 4) * shared[0]
    assert said(plain.match(photo, top)) == said(indexed.match(photo, top))
    assert plain.within(photo, distance) == indexed.within(photo, distance)


@pytest.mark.parametrize("folder", [False, True])
def test_a_better_basis_is_learned_when_there_are_more(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, folder: bool
) -> None:
    monkeypatch.setattr(gallery_people, "LEARNED_AT", (6, 12))
    gallery = hf.Gallery.create(tmp_path / "people", "harmonic9") if folder else hf.Gallery("harmonic9")
    sources, samples = list(PEOPLE.items()), []
    for part in (sources[:5], sources[5:11], sources[11:]):
        gallery.enroll_many(part)  # type: ignore[arg-type]
        samples.append(None if gallery._people.index is None else gallery._people.index.sample)
    assert samples == [None, 6, 12]
    same_answers(gallery, enrolled(hf.Gallery("harmonic9")))


def test_a_basis_that_was_asked_for_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gallery_people, "LEARNED_AT", (6, 12))
    gallery = hf.Gallery("harmonic9")
    sources = list(PEOPLE.items())
    gallery.enroll_many(sources[:7])  # type: ignore[arg-type]
    gallery.index(people=5)
    gallery.enroll_many(sources[7:])  # type: ignore[arg-type]
    assert gallery._people.index is not None
    assert gallery._people.index.sample == 5


@pytest.mark.parametrize("folder", [False, True])
def test_a_basis_is_learned_when_there_are_enough(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, folder: bool
) -> None:
    monkeypatch.setattr(gallery_people, "LEARNED_AT", (12, len(PEOPLE) + 1))
    gallery = hf.Gallery.create(tmp_path / "people", "harmonic9") if folder else hf.Gallery("harmonic9")
    assert gallery.match_many([]) == []
    sources = list(PEOPLE.items())
    told: list[int] = []
    assert gallery.enroll_many(sources[:11], told.append) == 11  # type: ignore[arg-type]
    assert told == list(range(1, 12))
    assert gallery._people.index is None
    assert gallery.match(PHOTOS[0], explain=True).search.survivors == ()  # type: ignore[union-attr]
    assert gallery.enroll_many(sources[11:]) == len(sources) - 11  # type: ignore[arg-type]
    index = gallery._people.index
    assert index is not None
    assert index.sample == 12
    found = gallery.match(PHOTOS[0], explain=True).search
    assert found is not None
    assert (found.people, len(found.survivors) > 0) == (len(sources), True)
    assert found.measured <= found.people
    assert gallery.match(PHOTOS[0]).search is None
    same_answers(gallery, enrolled(hf.Gallery("harmonic9")))
    if folder:
        assert isinstance(gallery._people, PeopleInFolder)
        assert gallery._people.about.sample == 12
