"""One against one: the angle by plain least squares, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import harmonicface as hf
from harmonicface.datasets.yale_b import YalePerson, load_yale_b
from harmonicface.stereo.reconstruction import reconstruct

ADA, EMMY = hf.synthetic_people(2, size=32, seed=4)
LAMP = np.array([0.3, 0.2, 1.0]) / np.linalg.norm([0.3, 0.2, 1.0])


def lit(surface: hf.Surface) -> np.ndarray:
    """A picture under one lamp, by the definition."""
    return surface.albedo * np.maximum(surface.normals @ LAMP, 0)


def nine(surface: hf.Surface, mask: np.ndarray) -> np.ndarray:
    x, y, z = surface.normals[mask].astype(np.float64).T
    one = np.ones_like(x)
    return surface.albedo[mask] * np.array([one, x, y, z, x * y, y * z, x * z, x * x - y * y, 3 * z * z - 1])


def brute_distance(photo: np.ndarray, surface: hf.Surface, mask: np.ndarray) -> float:
    basis, pixels = nine(surface, mask), photo[mask]
    rest = pixels - np.linalg.lstsq(basis.T, pixels, rcond=None)[0] @ basis
    return float(np.linalg.norm(rest) / np.linalg.norm(pixels))


@pytest.mark.parametrize("photo", [lit(ADA), lit(EMMY)], ids=["her", "another"])
@pytest.mark.parametrize("masked", [False, True])
def test_the_distance_is_that_of_least_squares(photo: np.ndarray, masked: bool) -> None:
    mask = np.arange(32)[None, :] < 20 if masked else None
    mask = None if mask is None else np.repeat(mask, 32, axis=0)
    answer = hf.verify(photo, ADA, mask=mask)
    seen = ADA.mask if mask is None else ADA.mask & mask
    assert_allclose(answer.distance, brute_distance(photo, ADA, seen), rtol=1e-4)


def test_yes_and_no() -> None:
    assert hf.verify(lit(ADA), ADA).same
    assert not hf.verify(lit(EMMY), ADA).same
    assert hf.verify(lit(EMMY), EMMY).same
    assert isinstance(hf.verify(lit(ADA), ADA).same, bool)


def test_the_threshold_decides() -> None:
    distance = hf.verify(lit(ADA), ADA).distance
    assert hf.verify(lit(ADA), ADA, threshold=distance).same
    assert not hf.verify(lit(ADA), ADA, threshold=distance * 0.999).same
    assert hf.verify(lit(EMMY), ADA, threshold=1).same
    assert hf.verify(lit(ADA), ADA, threshold=0.3).threshold == 0.3


def test_the_light_that_explains_the_photograph_is_told() -> None:
    towards = hf.verify(lit(ADA), ADA).light.coefficients(1)[[3, 1, 2]]
    assert towards @ LAMP / np.linalg.norm(towards) > 0.95


def test_unit_and_colour_do_not_matter() -> None:
    grey = hf.verify(lit(ADA), ADA)
    assert_allclose(hf.verify(1e-9 * lit(ADA), ADA).distance, grey.distance, rtol=1e-5)
    assert_allclose(hf.verify(np.repeat(lit(ADA)[..., None], 3, axis=2), ADA).distance, grey.distance, rtol=1e-5)


def test_what_is_outside_the_mask_does_not_matter() -> None:
    photo = np.where(ADA.mask, lit(ADA), 7.0)
    assert_allclose(hf.verify(photo, ADA).distance, hf.verify(lit(ADA), ADA).distance, rtol=1e-12)


def test_burnt_out_pixels_are_left_out() -> None:
    photo = lit(ADA).copy()
    burnt = photo > np.quantile(photo[ADA.mask], 0.9)
    photo[burnt] = 50.0
    assert not hf.verify(photo, ADA).same
    assert hf.verify(photo, ADA, mask=~burnt).same


OUTSIDE = ~ADA.mask


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"photo": np.ones((32, 31))}, r"photo: expected the Surface's shape \(32, 32\), got \(32, 31\)"),
        ({"photo": np.full((32, 32), np.nan)}, "photo: expected finite numbers"),
        ({"photo": np.zeros((32, 32))}, "photo: expected some light in it"),
        ({"photo": np.ones(4)}, "photo: expected an image"),
        ({"mask": np.zeros((32, 32), np.bool_)}, "mask: expected at least one pixel in the mask, got an empty one"),
        ({"mask": np.ones((2, 2), np.bool_)}, r"mask: expected a boolean mask of shape \(32, 32\), got"),
        ({"mask": OUTSIDE}, "mask and the Surface's mask together: expected at least one pixel"),
        ({"threshold": 1.5}, "threshold: expected a number from 0 to 1, got 1.5"),
    ],
)
def test_bad_input(arguments: dict, message: str) -> None:
    assert OUTSIDE.any()
    with pytest.raises(hf.HarmonicFaceError, match=message):
        hf.verify(**{"photo": lit(ADA), "surface": ADA, **arguments})


def real_people(data_dir: Path) -> tuple[list[hf.Surface], list[YalePerson]]:
    faces = load_yale_b(data_dir / "yaleb", [1, 2, 3])
    surfaces = []
    for face in faces:
        chosen = face.subsets == 1
        surfaces.append(reconstruct(face.photographs[chosen], face.lights[chosen]))
    return surfaces, faces


@pytest.mark.data
def test_patterns_know_real_people_in_hard_light(data_dir: Path) -> None:
    surfaces, faces = real_people(data_dir)
    right = {"intensities": 0, "patterns": 0}
    asked = 0
    for index, face in enumerate(faces):
        for photo in face.photographs[face.subsets >= 3][::12]:
            for other, surface in enumerate(surfaces):
                asked += 1
                for domain in right:
                    right[domain] += hf.verify(photo, surface, domain=domain).same == (other == index)
    assert right["patterns"] == asked > 30
    assert right["intensities"] < 0.8 * asked


@pytest.mark.data
def test_two_photographs_of_one_person(data_dir: Path) -> None:
    _, faces = real_people(data_dir)
    first = [face.photographs[face.angles.argmin()] for face in faces]
    for index, face in enumerate(faces):
        for photo in face.photographs[face.subsets == 3][::3]:
            answers = [hf.verify(photo, other) for other in first]
            assert [one.same for one in answers] == [other == index for other in range(3)]
            assert all(one.domain == "patterns" and one.light is None and one.threshold == 0.75 for one in answers)


def test_patterns_do_not_mind_a_shift() -> None:
    large = hf.synthetic_person(1, 64)
    photo = np.roll(hf.render(large, hf.lights.directional([0.5, 0.3, 1])), (2, -3), axis=(0, 1))
    found = hf.verify(photo, large, domain="patterns")
    assert found.same and found.domain == "patterns" and found.light is not None
    assert not hf.verify(photo, large).same


def test_a_photograph_is_like_itself_whatever_its_unit() -> None:
    photo = hf.render(hf.synthetic_person(1, 64), hf.lights.directional([0.5, 0.3, 1])) + 0.01
    assert hf.verify(7e4 * photo, photo).distance < 0.05
    assert hf.verify(np.repeat(photo[..., None], 3, axis=2), photo).distance < 0.05
    half = np.zeros(photo.shape, np.bool_)
    half[:, :40] = True
    hidden = np.where(half, photo, np.random.default_rng(0).uniform(0, 1, photo.shape))
    assert hf.verify(hidden, photo, mask=half).distance < hf.verify(hidden, photo).distance


def test_darkness_and_walls_are_nobody() -> None:
    large = hf.synthetic_person(1, 64)
    for photo in (np.zeros((64, 64)), np.ones((64, 64))):
        answer = hf.verify(photo, large, domain="patterns")
        assert not answer.same and answer.distance == 1
        assert not hf.verify(photo, hf.render(large, hf.lights.directional([0, 0, 1]))).same
    assert hf.verify(np.zeros((64, 64)), large, domain="patterns").light is None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"domain": "edges"}, "domain: expected intensities or patterns, got 'edges'"),
        (
            {"surface": np.ones((32, 32)), "domain": "intensities"},
            "domain: expected patterns, as photographs are compa",
        ),
        ({"surface": np.ones((32, 31))}, r"photo: expected the other photograph's shape \(32, 31\), got \(32, 32\)"),
        ({"surface": np.ones(4)}, "surface: expected an image of shape"),
        ({"surface": np.ones((32, 32)), "mask": np.ones((2, 2), np.bool_)}, "mask: expected a boolean mask of shape"),
        ({"photo": np.ones((8, 8)), "surface": np.ones((8, 8))}, "photo: expected at least 24 pixels a side"),
    ],
)
def test_bad_domains_and_photographs(arguments: dict, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        hf.verify(**{"photo": lit(ADA), "surface": ADA, **arguments})


def test_a_black_surface_explains_nothing() -> None:
    black = hf.Surface(ADA.normals, np.zeros_like(ADA.albedo), ADA.mask)
    with pytest.raises(hf.HarmonicFaceError, match="images: expected a picture with something in it"):
        hf.verify(lit(ADA), black)
