"""The default model: real and synthetic people from whatever they are enrolled from, and what must stay unknown."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import harmonicface as hf
from harmonicface.appearance.sensor import photograph
from harmonicface.bench.degradation import compressed, noisy
from harmonicface.datasets.yale_b import YalePerson, load_yale_b

SIZE = 48
NAMES = ("ada", "emmy", "sofia", "grace", "mary", "hedy")
PEOPLE = dict(zip(NAMES, hf.synthetic_people(len(NAMES), SIZE, seed=3), strict=True))
STRANGERS = list(hf.synthetic_people(6, SIZE, seed=99))
TOWARDS = np.array([[0.0, 0.0, 1.0], [0.4, 0.0, 0.9], [-0.4, 0.1, 0.9], [0.0, 0.45, 0.9], [0.1, -0.4, 0.9]])
TOWARDS /= np.linalg.norm(TOWARDS, axis=1, keepdims=True)


def picture(name: str, towards: object, seed: int = 0) -> np.ndarray:
    return photograph(hf.render(PEOPLE[name], hf.lights.directional(towards)), np.random.default_rng(seed))


def gallery_of(kind: str, names: tuple[str, ...] = NAMES, **settings: object) -> hf.Gallery:
    gallery = hf.Gallery(**settings)  # type: ignore[arg-type]
    for name in names:
        photos = np.stack([picture(name, towards, 5) for towards in TOWARDS])
        if kind == "surface":
            gallery.enroll(name, PEOPLE[name])
        elif kind == "lit photographs":
            gallery.enroll(name, photos, TOWARDS)
        elif kind == "photographs":
            gallery.enroll(name, photos)
        else:
            gallery.enroll(name, photos[0])
    return gallery


@pytest.fixture(scope="module")
def gallery() -> hf.Gallery:
    return gallery_of("surface")


@pytest.mark.parametrize("kind", ["surface", "lit photographs", "photographs", "photograph"])
def test_everybody_is_found_from_whatever_was_enrolled(kind: str) -> None:
    people = gallery_of(kind)
    for seed, name in enumerate(NAMES):
        found = people.match(picture(name, [0.8, 0.4, 0.6], seed), top=6)
        assert (found.candidates[0].name, found.source, found.domain) == (name, kind, "patterns")
        assert (found.light is None) == (kind in ("photographs", "photograph"))
        scores = [candidate.score for candidate in found.candidates]
        assert scores == sorted(scores, reverse=True)
        assert all(0 <= candidate.distance <= 1 for candidate in found.candidates)
        assert found.distance == found.candidates[0].distance


def test_all_kinds_share_a_gallery(gallery: hf.Gallery) -> None:
    mixed = gallery_of("surface", NAMES[:3])
    mixed.enroll("grace", np.stack([picture("grace", towards) for towards in TOWARDS]))
    mixed.enroll("mary", picture("mary", [0.1, 0.1, 1]))
    for name in NAMES[:5]:
        assert mixed.match(picture(name, [0.5, 0.2, 0.8], 7)).candidates[0].name == name


@pytest.mark.parametrize(("right", "down"), [(2, -1), (-3, 3)])
def test_the_shift_of_a_photograph_is_told(gallery: hf.Gallery, right: int, down: int) -> None:
    moved = np.roll(picture("emmy", [0.5, 0.3, 1], 2), (down, right), axis=(0, 1))
    found = gallery.match(moved)
    assert found.name == "emmy"
    assert found.candidates[0].shift == (right, down)
    still = gallery.match(picture("emmy", [0.5, 0.3, 1], 2))
    assert still.candidates[0].shift == (0, 0)
    assert found.light is not None and still.light is not None
    one, other = found.light.values[1:4], still.light.values[1:4]  # where most of the light comes from
    assert one @ other > 0.9 * np.linalg.norm(one) * np.linalg.norm(other)


def test_strangers_are_unknown(gallery: hf.Gallery) -> None:
    rng = np.random.default_rng(1)
    answers = [
        gallery.match(photograph(hf.render(one, hf.lights.directional([0.4, 0.2, 1])), rng)) for one in STRANGERS
    ]
    assert [answer.name for answer in answers] == [None] * len(STRANGERS)
    assert {answer.reason for answer in answers} == {"nobody is more alike than strangers are"}
    known = gallery.match(picture("ada", [0.4, 0.2, 1]))
    assert (known.name, known.reason) == ("ada", None)


def blank(value: float) -> np.ndarray:
    return np.full((SIZE, SIZE), value)


NOISE = np.random.default_rng(4).integers(0, 6, (SIZE, SIZE)) / 255
WALL = np.tile(np.linspace(0.3, 0.8, SIZE), (SIZE, 1))


@pytest.mark.parametrize("kind", ["surface", "photograph"])
@pytest.mark.parametrize("photo", [blank(0), blank(1), WALL, NOISE], ids=["dark", "burnt out", "a wall", "unlit"])
def test_what_shows_nobody_is_unknown(kind: str, photo: np.ndarray) -> None:
    for names in (NAMES, NAMES[:2], NAMES[:1]):
        answer = gallery_of(kind, names).match(photo)
        assert answer.name is None
        assert answer.reason is not None
        assert 0 <= answer.distance <= 1


@pytest.mark.parametrize(("levels", "reason"), [(6, "no more than 6 grey levels"), (30, None)])
def test_a_photograph_of_a_few_grey_levels_shows_nobody(levels: int, reason: str | None, gallery: hf.Gallery) -> None:
    dim = np.round(picture("grace", [0.2, 0.1, 1.0]) * (levels - 1)) / 255
    match = gallery.match(dim)
    assert match.candidates[0].name == "grace"  # something is left of her, even so
    assert (match.name, match.reason) == (
        "grace" if reason is None else None,
        reason and f"the photograph has {reason}",
    )


def test_one_person_alone_must_be_alike_by_herself() -> None:
    alone = gallery_of("surface", ("ada",))
    assert alone.match(picture("ada", [0.2, 0.2, 1])).name == "ada"
    answer = alone.match(picture("emmy", [0.2, 0.2, 1]))
    assert (answer.name, answer.margin) == (None, 1.0)
    assert answer.reason == "she is not alike, and there are no others to know what strangers are like"


def test_the_threshold_is_a_score(gallery: hf.Gallery) -> None:
    photo = picture("hedy", [0.4, 0.2, 1])
    score = gallery.match(photo).candidates[0].score
    assert gallery_of("surface", threshold=score * 0.999).match(photo).name == "hedy"
    assert gallery_of("surface", threshold=score * 1.001).match(photo).name is None


def test_scores_of_everybody(gallery: hf.Gallery) -> None:
    photo = picture("mary", [0.4, 0.2, 1])
    scores, answer = gallery.search_scores(photo), gallery.match(photo, top=6)
    assert scores.names == NAMES and scores.blocks == 16
    ranked = np.argsort(-scores.scores)
    assert [NAMES[place] for place in ranked] == [candidate.name for candidate in answer.candidates]
    assert_allclose(scores.scores[ranked], [candidate.score for candidate in answer.candidates])
    assert_allclose(scores.distances[ranked], [candidate.distance for candidate in answer.candidates])
    plain = hf.Gallery("harmonic9")
    for name in NAMES:
        plain.enroll(name, PEOPLE[name])
    nine = plain.search_scores(photo)
    assert nine.blocks is None
    assert_array_equal(nine.scores, -nine.distances)
    assert nine.names[int(nine.scores.argmax())] == plain.match(photo).name == "mary"


def test_a_shortlist_is_as_good_as_everybody(gallery: hf.Gallery) -> None:
    short = gallery_of("surface", shortlist=2)
    good = np.ones((SIZE, SIZE), np.bool_)
    good[:10] = False
    for mask in (None, good):
        photo = picture("grace", [0.4, 0.2, 1])
        found = short.match(photo, top=1, mask=mask)
        assert (found.name, len(found.candidates)) == ("grace", 1)
        assert len(short.match(photo, top=4, mask=mask).candidates) == 4


def test_what_is_masked_does_not_count(gallery: hf.Gallery) -> None:
    good = np.ones((SIZE, SIZE), np.bool_)
    good[28:, 10:40] = False  # a scarf
    photo = picture("sofia", [0.4, 0.2, 1])
    clean, spoiled = gallery.match(photo, mask=good), gallery.match(np.where(good, photo, 5.0), mask=good)
    assert clean.name == spoiled.name == "sofia"
    assert_allclose(spoiled.candidates[0].score, clean.candidates[0].score, rtol=1e-3)
    inside = gallery_of("surface", mask=good)
    assert inside.match(np.where(good, photo, 5.0)).name == "sofia"


def test_brightness_and_colour_do_not_matter(gallery: hf.Gallery) -> None:
    photo = picture("mary", [0.6, 0.2, 0.8])
    plain = gallery.match(photo)
    for other in (1e-20 * photo.astype(np.float64), 1e20 * photo, np.repeat(photo[..., None], 3, axis=2)):
        assert_allclose(gallery.match(other).candidates[0].score, plain.candidates[0].score, rtol=1e-3)


def test_ties_go_to_who_was_enrolled_first() -> None:
    twins = gallery_of("surface", ("emmy", "sofia"))
    twins.enroll("anna", PEOPLE["ada"])
    twins.enroll("ada", PEOPLE["ada"])
    answer = twins.match(picture("ada", [0, 0, 1]))
    assert [candidate.name for candidate in answer.candidates[:2]] == ["anna", "ada"]


def test_two_who_are_the_same_are_told_to_be_too_much_alike(gallery: hf.Gallery) -> None:
    twins = gallery_of("surface")
    twins.enroll("twin", PEOPLE["ada"])
    photo = picture("ada", [0.3, 0.2, 1])
    answer, single = twins.match(photo), gallery.match(photo)
    assert (answer.name, single.name) == (None, "ada")
    assert answer.reason == "the first two are too much alike to tell which of them it is"
    assert "too much alike" in answer.explain().reason


def test_a_saved_gallery_answers_the_same(tmp_path: Path) -> None:
    people = gallery_of("surface", NAMES[:4])
    people.remove("emmy")
    people.enroll("hedy", picture("hedy", [0, 0, 1]))
    people.threshold = 4.5
    people.save(tmp_path / "people.gallery")
    opened = hf.Gallery.open(tmp_path / "people.gallery")
    assert (opened.model, opened.threshold, opened.names) == ("default", 4.5, people.names)
    for name in ("ada", "sofia", "hedy"):
        photo = picture(name, [0.4, 0.1, 1])
        one, other = people.match(photo), opened.match(photo)
        assert one.candidates == other.candidates
        assert one.name == other.name


def test_bytes_are_those_of_rows_templates_and_pictures(gallery: hf.Gallery) -> None:
    alone = gallery_of("surface", ("ada",))
    rows, template = 9 * SIZE**2 * 4, 2 * SIZE**2 + 4 * 16 * 144
    assert alone.bytes_per_person == rows + template
    alone.match(picture("ada", [0, 0, 1]))
    assert alone.bytes_per_person == 3 * rows + template


@pytest.mark.parametrize(
    ("source", "lights", "message"),
    [
        (PEOPLE["ada"], TOWARDS, "lights: expected them with photographs only, got them with a Surface"),
        (np.ones((5, 5)), None, "photo: expected at least 24 pixels a side"),
        (np.ones((0, SIZE, SIZE)), None, "source: expected a Surface, or at least 1 photograph of shape"),
        (np.ones(7), None, "source: expected a Surface, or at least 1 photograph of shape"),
        (np.zeros((SIZE, SIZE)), None, "images: expected a picture with something in it"),
        (-np.ones((SIZE, SIZE)), None, "photographs: expected intensities of at least 0"),
        (np.ones((2, SIZE, SIZE)), TOWARDS[:2], "photographs: expected contrast"),
        (np.stack([picture("ada", towards) for towards in TOWARDS]), TOWARDS[:2], "lights: expected"),
    ],
)
def test_who_cannot_be_enrolled(source: object, lights: object, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        hf.Gallery().enroll("ada", source, lights)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def faces(data_dir: Path) -> list[YalePerson]:
    return load_yale_b(data_dir / "yaleb")


@pytest.fixture(scope="module")
def frontal(faces: list[YalePerson]) -> hf.Gallery:
    """Everybody from the seven photographs of subset 1 with their lights."""
    people = hf.Gallery()
    for face in faces:
        chosen = face.subsets == 1
        people.enroll(str(face.number), face.photographs[chosen], face.lights[chosen])
    return people


@pytest.mark.data
@pytest.mark.parametrize("spoil", ["clean", "noise", "jpeg"])
def test_light_from_anywhere_on_real_photographs(faces: list[YalePerson], frontal: hf.Gallery, spoil: str) -> None:
    wrong, asked = [], 0
    for face in faces:
        chosen = np.flatnonzero(face.subsets >= 4)[face.number % 3 :: 3]
        for place in chosen:
            photo = face.photographs[place]
            if spoil == "noise":
                photo = noisy(photo, 0.01, np.random.default_rng((face.number, int(place))))
            elif spoil == "jpeg":
                photo = compressed(photo, 50)
            asked += 1
            answer = frontal.match(photo)
            if answer.candidates[0].name != str(face.number):
                wrong.append((face.number, int(place)))
    assert asked > 110
    assert wrong == []


@pytest.mark.data
def test_unlit_photographs_of_real_people_are_unknown(faces: list[YalePerson], frontal: hf.Gallery) -> None:
    for face in faces[:4]:
        photo = face.photographs[face.angles.argmax()]
        unlit = np.rint(photo / photo.max() * 5) / 255  # six grey levels are left
        assert frontal.match(unlit).name is None
        noise = np.random.default_rng(face.number).integers(0, 6, photo.shape) / 255
        assert frontal.match(noise).name is None
