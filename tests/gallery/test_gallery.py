"""The gallery against least squares on everybody, with photographs summed over lamps."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import harmonicface as hf
from harmonicface.gallery.answers import ratio

SIZE = 24
NAMES = ("ada", "emmy", "sofia", "grace", "mary", "hedy", "lise", "vera")
PEOPLE = dict(zip(NAMES, hf.synthetic_people(len(NAMES), SIZE, seed=2), strict=True))
STRANGER = hf.synthetic_person(99, SIZE)
SPANS = {"linear3": slice(1, 4), "ambient4": slice(0, 4), "harmonic9": slice(0, 9)}


def photographed(surface: hf.Surface, seed: int, lamps: int = 40) -> np.ndarray:
    """A photograph under random lamps, most of them in front: the clamped cosine summed lamp by lamp."""
    rng = np.random.default_rng(seed)
    towards = rng.normal(size=(lamps, 3)) * 0.2 + rng.normal(size=3) * [0.6, 0.6, 0.1] + [0, 0, 0.7]
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    picture = np.zeros(surface.shape)
    for direction in towards:
        picture += surface.albedo * np.maximum(surface.normals @ direction, 0) / lamps
    return picture


def pictures(surface: hf.Surface, model: str = "harmonic9") -> np.ndarray:
    """The pictures of a model over all pixels by their polynomials, (k, h, w), zero outside the mask."""
    x, y, z = np.moveaxis(surface.normals.astype(np.float64), -1, 0)
    one = np.ones_like(x)
    nine = np.array([one, x, y, z, x * y, y * z, x * z, x * x - y * y, 3 * z * z - 1])
    return (nine * surface.albedo * surface.mask)[SPANS[model]]


def brute_distance(photo: np.ndarray, basis: np.ndarray, good: np.ndarray) -> float:
    pixels, rows = photo[good], basis[:, good]
    rest = pixels - np.linalg.lstsq(rows.T, pixels, rcond=1e-6)[0] @ rows
    return float(np.linalg.norm(rest) / np.linalg.norm(pixels))


def gallery_of(people: dict[str, hf.Surface], **settings: object) -> hf.Gallery:
    gallery = hf.Gallery(**{"model": "harmonic9", **settings})  # type: ignore[arg-type]
    for name, surface in people.items():
        gallery.enroll(name, surface)
    return gallery


@pytest.fixture(scope="module")
def gallery() -> hf.Gallery:
    return gallery_of(PEOPLE)


@pytest.mark.parametrize("model", SPANS)
def test_candidates_are_those_of_least_squares_on_everybody(model: str) -> None:
    gallery = gallery_of(PEOPLE, model=model)
    everywhere = np.ones((SIZE, SIZE), np.bool_)
    for seed, surface in enumerate([*PEOPLE.values(), STRANGER]):
        photo = photographed(surface, seed)
        expected = sorted((brute_distance(photo, pictures(PEOPLE[name], model), everywhere), name) for name in NAMES)
        answer = gallery.match(photo, top=len(NAMES))
        assert [candidate.name for candidate in answer.candidates] == [name for _, name in expected]
        found = [candidate.distance for candidate in answer.candidates]
        assert_allclose(found, [distance for distance, _ in expected], rtol=1e-4)
        assert_allclose(answer.margin, expected[1][0] / expected[0][0], rtol=1e-4)
        assert answer.distance == found[0]


def test_everybody_is_found_under_lamps_that_nobody_enrolled(gallery: hf.Gallery) -> None:
    for seed, (name, surface) in enumerate(PEOPLE.items()):
        assert gallery.match(photographed(surface, 100 + seed)).name == name


@pytest.mark.parametrize("top", [1, 2, 3, 8, 50])
def test_as_many_candidates_as_are_asked_for(gallery: hf.Gallery, top: int) -> None:
    photo = photographed(PEOPLE["lise"], 1)
    some, everybody = gallery.match(photo, top=top), gallery.match(photo, top=len(NAMES))
    assert some.candidates == everybody.candidates[:top]
    assert (some.margin, some.name, some.distance) == (everybody.margin, everybody.name, everybody.distance)


def test_masked_photographs_are_compared_where_they_are_good(gallery: hf.Gallery) -> None:
    rng = np.random.default_rng(0)
    for seed, surface in enumerate([PEOPLE["ada"], PEOPLE["vera"], STRANGER]):
        good = rng.uniform(size=(SIZE, SIZE)) < 0.5
        photo = np.where(good, photographed(surface, seed), 40.0)  # what is bad shouts
        expected = sorted((brute_distance(photo, pictures(PEOPLE[name]), good), name) for name in NAMES)
        answer = gallery.match(photo, top=8, mask=good)
        assert [candidate.name for candidate in answer.candidates] == [name for _, name in expected]
        found = [candidate.distance for candidate in answer.candidates]
        assert_allclose(found, [distance for distance, _ in expected], rtol=1e-3)


def test_a_mask_of_all_pixels_changes_nothing(gallery: hf.Gallery) -> None:
    photo = photographed(PEOPLE["mary"], 5)
    masked, plain = gallery.match(photo, mask=np.ones((SIZE, SIZE), np.bool_)), gallery.match(photo)
    assert masked.candidates == plain.candidates
    assert_array_equal(masked.light.values, plain.light.values)


def test_the_gallerys_own_mask_leaves_the_rest_out() -> None:
    frame = np.zeros((SIZE, SIZE), np.bool_)
    frame[5:20, 4:18] = True
    gallery = gallery_of(PEOPLE, mask=frame)
    assert_array_equal(gallery.mask, frame)
    photo = np.where(frame, photographed(PEOPLE["hedy"], 3), 9.0)
    expected = sorted((brute_distance(photo, pictures(PEOPLE[name]), frame), name) for name in NAMES)
    answer = gallery.match(photo, top=8)
    assert [candidate.name for candidate in answer.candidates] == [name for _, name in expected]
    assert_allclose([c.distance for c in answer.candidates], [distance for distance, _ in expected], rtol=1e-4)


def test_ties_go_to_who_was_enrolled_first() -> None:
    twins = gallery_of({"emmy": PEOPLE["emmy"], "anna": PEOPLE["ada"], "ada": PEOPLE["ada"]})
    answer = twins.match(photographed(PEOPLE["ada"], 0))
    assert [candidate.name for candidate in answer.candidates] == ["anna", "ada", "emmy"]
    assert (answer.name, answer.margin) == ("anna", 1.0)
    twins.threshold = 0.0  # only the margin is left, and neither is nearer than the other
    assert twins.match(photographed(PEOPLE["ada"], 0)).name is None


def test_the_threshold_names_or_not(gallery: hf.Gallery) -> None:
    photo = photographed(PEOPLE["ada"], 0)
    distance = gallery.match(photo).distance
    assert gallery_of(PEOPLE, threshold=distance, margin=np.inf).match(photo).name == "ada"
    refused = gallery_of(PEOPLE, threshold=distance * 0.999, margin=np.inf).match(photo)
    assert refused.name is None
    assert refused.candidates[0].name == "ada"


def test_the_margin_names_or_not(gallery: hf.Gallery) -> None:
    photo = photographed(PEOPLE["ada"], 0)
    margin = gallery.match(photo).margin
    assert gallery_of(PEOPLE, threshold=0, margin=margin).match(photo).name == "ada"
    assert gallery_of(PEOPLE, threshold=0, margin=margin * 1.001).match(photo).name is None


def test_a_stranger_is_nobody(gallery: hf.Gallery) -> None:
    for seed in range(5):
        answer = gallery.match(photographed(STRANGER, seed))
        assert (answer.name is None) == (answer.distance > gallery.threshold and answer.margin < gallery.margin)
    unknown = [gallery.match(photographed(STRANGER, seed)).name is None for seed in range(20)]
    assert np.mean(unknown) > 0.5


def test_a_gallery_of_one_has_no_next() -> None:
    alone = gallery_of({"ada": PEOPLE["ada"]})
    answer = alone.match(photographed(PEOPLE["ada"], 0))
    assert (answer.name, answer.margin, len(answer.candidates)) == ("ada", 1.0, 1)
    assert alone.match(photographed(STRANGER, 0)).name is None


def test_the_light_of_the_winner_explains_the_photograph(gallery: hf.Gallery) -> None:
    surface = PEOPLE["vera"]
    photo = photographed(surface, 4)
    answer = gallery.match(photo)
    assert answer.light is not None
    explained = hf.render(surface, answer.light)
    rest = np.linalg.norm(photo - explained) / np.linalg.norm(photo)
    assert_allclose(rest, answer.distance, rtol=1e-3)
    assert_allclose(gallery.reconstruct("vera", photo), explained, rtol=0, atol=1e-4 * photo.max())


@pytest.mark.parametrize(("model", "count"), [("linear3", 4), ("ambient4", 4), ("harmonic9", 9)])
def test_the_light_is_in_the_order_of_the_model(model: str, count: int) -> None:
    gallery = gallery_of(PEOPLE, model=model)
    photo = photographed(PEOPLE["ada"], 0)
    for mask in (None, photo > 0):
        light = gallery.match(photo, mask=mask).light
        assert light is not None
        assert light.values.shape == (count,)
        assert (light.values[0] == 0) == (model == "linear3")
        assert light.values[2] > 0  # it comes from the front


def test_brightness_and_colour_do_not_matter(gallery: hf.Gallery) -> None:
    photo = photographed(PEOPLE["mary"], 2)
    plain = gallery.match(photo)
    for other in (1e-20 * photo, 1e20 * photo, np.repeat(photo[..., None], 3, axis=2), photo.astype(np.float32)):
        answer = gallery.match(other)
        assert answer.name == plain.name
        assert_allclose(answer.distance, plain.distance, rtol=1e-5)


def test_people_enrolled_from_photographs() -> None:
    stacks = {name: np.stack([photographed(PEOPLE[name], seed, lamps=1) for seed in range(12)]) for name in NAMES[:4]}
    gallery = gallery_of(stacks)  # type: ignore[arg-type]
    photo = photographed(PEOPLE["sofia"], 77)
    answer = gallery.match(photo, top=4)
    assert answer.candidates[0].name == "sofia"
    assert answer.light is None
    for candidate in answer.candidates:
        rows = stacks[candidate.name].reshape(12, -1)
        strongest = np.linalg.svd(rows, full_matrices=False)[2][:9]
        rest = photo.ravel() - (strongest @ photo.ravel()) @ strongest
        assert_allclose(candidate.distance, np.linalg.norm(rest) / np.linalg.norm(photo), rtol=1e-4)


def test_three_photographs_or_coloured_ones_will_do() -> None:
    stack = np.stack([photographed(PEOPLE["ada"], seed, lamps=1) for seed in range(3)])
    grey, coloured = hf.Gallery("harmonic9"), hf.Gallery("harmonic9")
    grey.enroll("ada", stack)
    coloured.enroll("ada", np.repeat(stack[..., None], 3, axis=3))
    photo = stack.sum(axis=0)
    assert grey.match(photo).distance < 1e-6
    assert coloured.match(photo).distance < 1e-6


def test_surfaces_and_photographs_share_a_gallery() -> None:
    gallery = gallery_of({"ada": PEOPLE["ada"]})
    gallery.enroll("emmy", np.stack([photographed(PEOPLE["emmy"], seed, lamps=1) for seed in range(9)]))
    assert gallery.match(photographed(PEOPLE["ada"], 50)).light is not None
    assert gallery.match(photographed(PEOPLE["emmy"], 50)).light is None


def test_removing_is_as_if_never_enrolled(gallery: hf.Gallery) -> None:
    shrunk = gallery_of({"wall": wall(), **PEOPLE})
    for name in ("wall", "grace", "ada"):
        shrunk.remove(name)
    rest = {name: surface for name, surface in PEOPLE.items() if name not in ("grace", "ada")}
    assert shrunk.names == tuple(rest)
    assert "grace" not in shrunk
    for seed, surface in enumerate(PEOPLE.values()):
        photo = photographed(surface, seed)
        assert shrunk.match(photo, top=8).candidates == gallery_of(rest).match(photo, top=8).candidates
    shrunk.enroll("grace", PEOPLE["grace"])
    assert shrunk.match(photographed(PEOPLE["grace"], 1)).name == "grace"


def test_everybody_may_leave_and_the_frame_stays() -> None:
    gallery = gallery_of({"ada": PEOPLE["ada"]})
    gallery.remove("ada")
    assert (len(gallery), gallery.names, gallery.bytes_per_person) == (0, (), 0.0)
    with pytest.raises(hf.HarmonicFaceError, match="match: expected a gallery with somebody in it, got an empty one"):
        gallery.match(np.ones((SIZE, SIZE)))
    with pytest.raises(hf.HarmonicFaceError, match=r"surface: expected the gallery's shape \(24, 24\)"):
        gallery.enroll("emmy", hf.synthetic_person(1, size=32))
    gallery.enroll("emmy", PEOPLE["emmy"])
    assert gallery.match(photographed(PEOPLE["emmy"], 0)).name == "emmy"


def test_people_of_different_rank_share_a_gallery() -> None:
    gallery = gallery_of({"wall": wall(), **PEOPLE})
    assert gallery.match(photographed(PEOPLE["lise"], 0)).name == "lise"
    assert gallery.match(wall().albedo).distance < 1e-6
    assert gallery.match(wall().albedo).name == "wall"
    mean_rank = (1 + 9 * len(NAMES)) / (1 + len(NAMES))
    assert_allclose(gallery.bytes_per_person, mean_rank * SIZE * SIZE * 4)


def test_somebody_without_a_pixel_behind_the_mask_explains_nothing() -> None:
    half = np.zeros((SIZE, SIZE), np.bool_)
    half[:, : SIZE // 2] = True
    face = PEOPLE["ada"]
    left = hf.Surface(face.normals, face.albedo, face.mask & half)
    gallery = gallery_of({"left": left, "ada": face})
    answer = gallery.match(photographed(face, 0), mask=~half & face.mask)
    assert answer.candidates[0].name == "ada"
    assert (answer.candidates[1].name, answer.candidates[1].distance) == ("left", 1.0)


def wall() -> hf.Surface:
    albedo = np.random.default_rng(0).uniform(0.2, 1, (SIZE, SIZE))
    return hf.Surface(np.tile([0.0, 0.0, 1.0], (SIZE, SIZE, 1)), albedo)


def test_what_a_gallery_says_of_itself(gallery: hf.Gallery) -> None:
    assert repr(gallery) == "<Gallery of 8 people, 24 x 24 pixels, model harmonic9>"
    assert repr(hf.Gallery()) == "<Gallery of 0 people, no frame yet, model default>"
    assert (hf.Gallery().mask, hf.Gallery().bytes_per_person) == (None, 0.0)
    assert gallery.names == NAMES
    assert "ada" in gallery
    mask = gallery.mask
    assert mask is not None
    mask[:] = False  # a copy: nobody else's pixels are lost
    assert gallery.mask.all()


GOOD = photographed(PEOPLE["ada"], 0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"photo": np.ones((24, 25))}, r"photo: expected the gallery's shape \(24, 24\), got \(24, 25\)"),
        ({"photo": np.full((24, 24), np.nan)}, "photo: expected finite numbers, got 576 NaN"),
        ({"photo": np.zeros((24, 24))}, "photo: expected some light in it, got 576 pixels that are all 0"),
        ({"photo": np.ones(24)}, "photo: expected an image of shape"),
        ({"photo": "photo.png"}, "photo: expected an array of real numbers, got str 'photo.png'"),
        ({"top": 0}, "top: expected an integer of at least 1, got int 0"),
        ({"mask": np.zeros((24, 24), np.bool_)}, "mask: expected at least one pixel in the mask, got an empty one"),
        ({"mask": np.ones((24, 24))}, "mask: expected a boolean mask of shape"),
        ({"photo": np.eye(24), "mask": ~np.eye(24, dtype=np.bool_)}, "photo: expected some light in it, got 552"),
    ],
)
def test_bad_queries(gallery: hf.Gallery, arguments: dict, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message) as caught:
        gallery.match(**{"photo": GOOD, **arguments})
    assert "\n" not in str(caught.value)


def test_a_mask_beside_the_gallerys(gallery: hf.Gallery) -> None:
    half = np.zeros((SIZE, SIZE), np.bool_)
    half[:, : SIZE // 2] = True
    with pytest.raises(hf.HarmonicFaceError, match="mask inside the gallery's mask: expected at least one pixel"):
        gallery_of(PEOPLE, mask=half).match(GOOD, mask=~half)


def test_nobody_to_compare_with() -> None:
    with pytest.raises(hf.HarmonicFaceError, match="match: expected a gallery with somebody in it, got an empty one"):
        hf.Gallery().match(GOOD)


STACK = np.stack([GOOD] * 3)


@pytest.mark.parametrize(
    ("name", "source", "message"),
    [
        ("ada", PEOPLE["emmy"], "name: expected one that is not in the gallery yet, got 'ada', who is"),
        ("", PEOPLE["ada"], "name: expected 1 to 200 printable characters"),
        (" ada", PEOPLE["ada"], "name: expected 1 to 200 printable characters"),
        ("a\x00b", PEOPLE["ada"], "name: expected 1 to 200 printable characters"),
        ("\ud800", PEOPLE["ada"], "name: expected 1 to 200 printable characters"),
        ("a" * 201, PEOPLE["ada"], "name: expected 1 to 200 printable characters"),
        (" \n", PEOPLE["ada"], "name: expected 1 to 200 printable characters"),
        (7, PEOPLE["ada"], "name: expected a text, got int 7"),
        ("new", hf.synthetic_person(0, size=32), r"surface: expected the gallery's shape \(24, 24\), got \(32, 32\)"),
        ("new", STACK[:2], r"source: expected a Surface, or at least 3 photographs of shape \(n, h, w\), got an array"),
        ("new", np.full((24, 24), 0.5), "photo: expected"),
        ("new", np.zeros((3, 0, 4)), "source: expected a Surface, or at least 3 photographs"),
        ("new", STACK[:, :, 1:], r"photographs: expected the gallery's shape \(24, 24\), got \(24, 23\)"),
        ("new", STACK * np.nan, "photographs: expected finite numbers"),
        ("new", STACK * 0, "images: expected a picture with something in it, got 3 of zeros"),
        ("new", "ada.png", "photographs: expected an array of real numbers, got str 'ada.png'"),
        ("new", None, "photographs: expected an array of real numbers, got NoneType None"),
    ],
)
def test_people_who_cannot_be_enrolled_leave_the_gallery_as_it_was(name: str, source, message: str) -> None:
    gallery = gallery_of(PEOPLE)
    before = gallery.match(GOOD, top=8)
    with pytest.raises(hf.HarmonicFaceError, match=message) as caught:
        gallery.enroll(name, source)
    assert "\n" not in str(caught.value)
    assert gallery.names == NAMES
    assert gallery.match(GOOD, top=8).candidates == before.candidates


def test_a_first_person_who_cannot_be_enrolled_leaves_no_frame() -> None:
    gallery = hf.Gallery("harmonic9")
    with pytest.raises(hf.HarmonicFaceError, match="images: expected a picture with something in it"):
        gallery.enroll("shade", hf.Surface(PEOPLE["ada"].normals, np.zeros((SIZE, SIZE)), PEOPLE["ada"].mask))
    assert (gallery.mask, len(gallery)) == (None, 0)
    gallery.enroll("ada", hf.synthetic_person(0, size=32))
    assert gallery.mask.shape == (32, 32)


def test_a_person_beside_the_gallerys_mask() -> None:
    outside = ~PEOPLE["ada"].mask
    assert outside.any()
    gallery = hf.Gallery("harmonic9", mask=outside)
    with pytest.raises(hf.HarmonicFaceError, match="surface: expected some of its pixels inside the gallery's mask"):
        gallery.enroll("ada", PEOPLE["ada"])


def test_unknown_names(gallery: hf.Gallery) -> None:
    message = "name: expected somebody in the gallery, got 'nobody', who is not"
    with pytest.raises(hf.HarmonicFaceError, match=message):
        gallery.remove("nobody")
    with pytest.raises(hf.HarmonicFaceError, match=message):
        gallery.reconstruct("nobody", GOOD)
    with pytest.raises(hf.HarmonicFaceError, match=r"photo: expected the gallery's shape"):
        gallery.reconstruct("ada", GOOD[1:])


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (
            {"model": "magic"},
            "model: expected one of default, linear3, ambient4, harmonic9, pca3, pca5, pca_auto, auto,"
            " harmonic_shadowed, nine_points_simulated, got 'magic'",
        ),
        ({"model": "harmonic9", "threshold": -0.1}, "threshold: expected a number from 0 to 1, got -0.1"),
        ({"model": "harmonic9", "threshold": "high"}, "threshold: expected a number from 0 to 1, got str 'high'"),
        ({"threshold": 0}, "threshold: expected a finite number above 0, got 0"),
        ({"threshold": np.inf}, "threshold: expected a finite number above 0, got inf"),
        ({"shortlist": 1}, "shortlist: expected an integer of at least 2, got int 1"),
        ({"margin": 0.9}, "margin: expected a number of at least 1, got 0.9"),
        ({"margin": np.nan}, "margin: expected a finite number above 0, got nan"),
        ({"margin": "wide"}, "margin: expected a number above 0, got str 'wide'"),
        ({"mask": np.zeros((4, 4), np.bool_)}, "mask: expected at least one pixel in the mask"),
        ({"mask": np.ones((4, 4))}, "mask: expected a boolean mask"),
        ({"mask": np.ones(4, np.bool_)}, r"mask: expected shape \(h, w\), got an array of shape \(4,\)"),
    ],
)
def test_settings_that_no_gallery_has(settings: dict, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        hf.Gallery(**settings)


def test_a_refused_setting_leaves_the_old_one() -> None:
    gallery = hf.Gallery("harmonic9", threshold=0.3, margin=1.5)
    with pytest.raises(hf.HarmonicFaceError, match="threshold"):
        gallery.threshold = 2
    with pytest.raises(hf.HarmonicFaceError, match="margin"):
        gallery.margin = 0.5
    assert (gallery.threshold, gallery.margin) == (0.3, 1.5)


def test_a_few_pixels_tell_nobody_from_another() -> None:
    few = np.zeros((SIZE, SIZE), np.bool_)
    few.flat[:35] = True
    with pytest.raises(hf.HarmonicFaceError, match="match: expected at least 36 good pixels, got 35"):
        gallery_of(PEOPLE, mask=few).match(GOOD)
    with pytest.raises(hf.HarmonicFaceError, match="match: expected at least 36 good pixels, got 35"):
        gallery_of(PEOPLE).match(GOOD, mask=few)
    assert ratio(0.3, 0.0) == np.inf
    assert ratio(0.0, 0.0) == 1.0


def test_nobody_is_named_who_leaves_a_quarter_of_the_energy_over() -> None:
    gallery = gallery_of(PEOPLE)
    assert gallery.is_known(0.05, 1.0)
    assert gallery.is_known(0.5, 1.4)
    assert not gallery.is_known(0.3, 1.3)
    assert not gallery.is_known(0.51, 10.0)


@pytest.mark.parametrize("model", ["default", "harmonic9"])
def test_strangers_are_unknown_and_enrolled_people_are_not(model: str) -> None:
    people = [*hf.synthetic_people(40, 48, seed=77)]
    gallery = hf.Gallery(model)
    for index, person in enumerate(people[:20]):
        gallery.enroll(str(index), person)
    rng = np.random.default_rng(5)
    lamps = [hf.lights.directional([*rng.normal(size=2), 1.5]) for _ in people]
    photos = [hf.photograph(hf.render(*pair), rng) for pair in zip(people, lamps, strict=True)]
    names = [gallery.match(photo).name for photo in photos]
    assert names[:20] == [str(index) for index in range(20)]
    assert sum(name is not None for name in names[20:]) <= 1


def test_photographs_must_differ_and_hold_light() -> None:
    photo = GOOD
    with pytest.raises(hf.HarmonicFaceError, match=r"at least 3 photographs that differ, .* got 1 different of 4"):
        hf.Gallery("harmonic9").enroll("ada", np.stack([photo] * 4))
    with pytest.raises(hf.HarmonicFaceError, match="intensities of at least 0"):
        gallery_of(PEOPLE).match(-photo)
    with pytest.raises(hf.HarmonicFaceError, match="at most 1e"):
        gallery_of(PEOPLE).match(1e300 * photo.astype(np.float64))
