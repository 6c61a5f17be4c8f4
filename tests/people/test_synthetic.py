import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from harmonicface.errors import HarmonicFaceError
from harmonicface.people.anatomy import EYE, MOUTH
from harmonicface.people.crop import FRAME
from harmonicface.people.synthetic import synthetic_people, synthetic_person

SEEDS = st.integers(min_value=0, max_value=2**63)


@pytest.fixture(scope="module")
def twenty():
    return list(synthetic_people(20, 64, seed=3))


def same(a, b):
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in ("normals", "albedo", "mask"))


def halved(picture):
    h, w = picture.shape[:2]
    return picture.reshape(h // 2, 2, w // 2, 2, -1).mean(axis=(1, 3))


def test_same_seed_same_bits():
    assert same(synthetic_person(12), synthetic_person(12))
    assert same(synthetic_person(12), synthetic_person(np.random.default_rng(12)))
    assert not same(synthetic_person(12), synthetic_person(13))


def test_a_generator_goes_on():
    rng = np.random.default_rng(5)
    first, second = synthetic_person(rng, 32), synthetic_person(rng, 32)
    assert not same(first, second)


def test_person_does_not_depend_on_how_many_are_made():
    few, many = list(synthetic_people(2, 32, seed=9)), list(synthetic_people(4, 32, seed=9))
    assert all(same(a, b) for a, b in zip(few, many, strict=False))
    assert list(synthetic_people(0)) == []


def test_people_of_two_seeds_share_nobody():
    seeds = (0, 1, 2, 2**32, 2**32 + 1)  # words of 32 bits must not be mistaken for a person's number
    people = [person for seed in seeds for person in synthetic_people(3, 16, seed)]
    assert not any(same(a, b) for a, b in itertools.combinations(people, 2))


@settings(max_examples=20, deadline=None)
@given(seed=SEEDS, size=st.tuples(st.integers(8, 96), st.integers(8, 96)))
def test_every_person_is_a_valid_surface(seed, size):
    person = synthetic_person(seed, size)
    assert person.shape == size
    assert person.normals.dtype == person.albedo.dtype == np.float32
    normals = person.pixel_normals
    assert np.allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-5)
    assert normals[:, 2].min() > 0
    albedo = person.pixel_albedo
    assert albedo.min() > 0 and albedo.max() <= 0.95
    assert np.isfinite(person.depth[person.mask]).all()


def test_face_fills_the_picture_but_for_the_corners(twenty):
    for person in twenty:
        assert 0.8 < person.mask.mean() < 0.97
        assert person.mask[:40, 6:-6].all()
        assert not person.mask[-1, 0] and not person.mask[-1, -1]


def test_normals_are_those_of_the_depth(twenty):
    for person in twenty[:5]:
        smooth = person.mask.copy()
        for axis, step in ((0, 1), (0, -1), (1, 1), (1, -1)):
            smooth &= np.roll(person.mask, step, axis)
        down, right = np.gradient(person.depth, person.pixel_size)
        slopes = np.stack([-right, down, np.ones_like(down)], axis=-1)
        slopes /= np.linalg.norm(slopes, axis=-1, keepdims=True)
        cosine = np.einsum("hwc,hwc->hw", slopes, person.normals)[smooth]
        assert np.median(np.degrees(np.arccos(np.clip(cosine, -1, 1)))) < 3


def test_irises_are_dark_where_eyes_belong(twenty):
    for person in synthetic_people(20, 128, seed=3):
        x = (np.arange(128) + 0.5) * person.pixel_size + FRAME[0] - (128 * person.pixel_size - FRAME[2] + FRAME[0]) / 2
        y = FRAME[3] - (np.arange(128) + 0.5) * person.pixel_size
        skin = np.median(person.pixel_albedo)
        for side in (-1, 1):
            near = np.hypot(x[None, :] - side * EYE[0], y[:, None] - EYE[1]) < 5.0
            dark = near & (person.albedo < 0.5 * skin)
            rows, columns = np.nonzero(dark)
            assert dark.sum() > 0.3 * near.sum()
            assert abs(x[columns].mean() - side * EYE[0]) < 3 and abs(y[rows].mean() - EYE[1]) < 3
        strip = person.albedo[:, np.abs(x) < 8].mean(axis=1)
        mouth = np.abs(y - MOUTH[1]) < 7
        assert abs(y[mouth][strip[mouth].argmin()] - MOUTH[1]) < 4


def test_a_person_is_the_same_in_every_size():
    for seed in range(6):
        large, small = synthetic_person(seed, 128), synthetic_person(seed, 64)
        inside = small.mask & (halved(large.mask)[..., 0] == 1)
        other = synthetic_person(seed + 100, 64)
        normals, albedo = halved(large.normals), halved(large.albedo)[..., 0]
        difference = np.linalg.norm(normals - small.normals, axis=2)[inside].mean()
        tone = np.abs(albedo - small.albedo)[inside].mean()
        assert difference < 0.03 and tone < 0.012
        assert difference < 0.3 * np.linalg.norm(normals - other.normals, axis=2)[inside & other.mask].mean()


def test_sides_need_not_be_equal():
    square, tall = synthetic_person(4, 96), synthetic_person(4, (96, 84))
    assert tall.pixel_size == square.pixel_size
    assert np.allclose(square.albedo[:, 6:-6], tall.albedo, atol=1e-6)


@settings(max_examples=5, deadline=None)
@given(seed=SEEDS)
def test_any_two_people_differ(seed):
    people = list(synthetic_people(20, 32, seed))
    common = np.logical_and.reduce([person.mask for person in people])
    for a, b in itertools.combinations(people, 2):
        angle = np.degrees(np.linalg.norm(a.normals - b.normals, axis=2)[common].mean())
        ratio = np.log(a.albedo[common] / b.albedo[common])
        assert angle > 4 and ratio.std() > 0.08


@pytest.mark.parametrize("seed", [-1, 1.5, True, "7", None])
def test_seed_must_be_a_natural_number_or_a_generator(seed):
    with pytest.raises(HarmonicFaceError, match="seed: expected an integer of at least 0, got"):
        synthetic_person(seed)
    with pytest.raises(HarmonicFaceError, match="seed: expected"):
        synthetic_people(1, 32, seed)


@pytest.mark.parametrize("count", [-1, 2.0, True, "3"])
def test_count_must_be_a_natural_number_and_is_checked_at_the_call(count):
    with pytest.raises(HarmonicFaceError, match="count: expected an integer of at least 0, got"):
        synthetic_people(count)


@pytest.mark.parametrize("size", [0, 7, (64,), (64, 0), (64, 7), 3.5, "64"])
def test_size_must_be_pixels(size):
    with pytest.raises(HarmonicFaceError, match="size: expected"):
        synthetic_person(0, size)
    with pytest.raises(HarmonicFaceError, match="size: expected"):
        synthetic_people(1, size)
