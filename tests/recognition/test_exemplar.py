"""One photograph and the prior give the person's own images: closed forms first, people of neither last."""

from __future__ import annotations

import numpy as np
import pytest

from harmonicface.appearance.basis import harmonic_images
from harmonicface.appearance.render import render
from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.lights import directional
from harmonicface.lighting.natural import natural
from harmonicface.people.prior import FacePrior, synthetic_prior
from harmonicface.people.synthetic import synthetic_people
from harmonicface.recognition.exemplar import Exemplar, exemplar, exemplar_images
from harmonicface.stereo.motion import STILL
from harmonicface.surfaces.surface import Surface

SHAPE = (48, 42)


@pytest.fixture(scope="module")
def prior() -> FacePrior:
    return synthetic_prior(SHAPE, 60)


@pytest.fixture(scope="module")
def people() -> list[Surface]:
    """People who are not in the prior."""
    return list(synthetic_people(6, SHAPE, seed=11))


@pytest.fixture(scope="module")
def found(people: list[Surface], prior: FacePrior) -> list[Exemplar]:
    return [exemplar(render(person, natural(seed)), prior, person.mask, STILL) for seed, person in enumerate(people)]


def apart(first: Surface, second: Surface) -> float:
    """Mean angle between the normals of two surfaces in degrees."""
    both = first.mask & second.mask
    cosines = np.einsum("ij,ij->i", first.normals[both], second.normals[both].astype(np.float64))
    return float(np.degrees(np.arccos(np.clip(cosines, -1, 1))).mean())


def mean_face(prior: FacePrior) -> Surface:
    normals = np.zeros((*prior.shape, 3))
    normals[prior.mask] = prior.mean[[3, 1, 2]].T / np.linalg.norm(prior.mean[1:4], axis=0)[:, None]
    return Surface(normals, prior.mask.astype(float), prior.mask)


def relative(picture: np.ndarray, truth: np.ndarray) -> float:
    """Root mean square difference over that of the truth, at the scale that suits best."""
    scale = (picture * truth).sum() / (picture * picture).sum()
    return float(np.linalg.norm(scale * picture - truth) / np.linalg.norm(truth))


def test_mean_face_under_a_known_light_is_the_mean_face(prior: FacePrior) -> None:
    light = directional([0.3, 0.4, 1.0]).coefficients(2) + np.eye(9)[0]
    photo = np.zeros(SHAPE)
    photo[prior.mask] = light @ prior.mean
    one = exemplar(photo, prior, prior.mask, STILL)
    assert np.abs(one.coefficients).max() < 0.3
    np.testing.assert_allclose(one.light.coefficients(2) * prior.tone, light, atol=0.15 * light[0])
    assert apart(one.surface, mean_face(prior)) < 2


def test_a_face_of_the_prior_comes_back(prior: FacePrior) -> None:
    coefficients = np.random.default_rng(3).standard_normal(len(prior.modes))
    light = directional([0.5, 0.3, 1.0]).coefficients(2) + 0.5 * np.eye(9)[0]
    photo = np.zeros(SHAPE)
    photo[prior.mask] = light @ prior.images(coefficients)
    one = exemplar(photo, prior, prior.mask, STILL)
    strongest = slice(0, 5)
    assert np.corrcoef(one.coefficients[strongest], coefficients[strongest])[0, 1] > 0.8
    assert one.noise < 0.03 * photo[prior.mask].mean()


def test_light_and_images_are_the_photograph(found: list[Exemplar], people: list[Surface]) -> None:
    for seed, (one, person) in enumerate(zip(found, people, strict=True)):
        both = one.surface.mask & person.mask
        picture = np.zeros(SHAPE)
        picture[one.surface.mask] = one.light.coefficients(2) @ harmonic_images(one.surface)
        photo = render(person, natural(seed))
        bright = both & (photo > np.median(photo[both]))
        assert np.linalg.norm(picture[bright] - photo[bright]) < 0.08 * np.linalg.norm(photo[bright])


def test_normals_are_her_own_rather_than_the_mean(
    found: list[Exemplar], people: list[Surface], prior: FacePrior
) -> None:
    hers = np.mean([apart(one.surface, person) for one, person in zip(found, people, strict=True)])
    usual = np.mean([apart(mean_face(prior), person) for person in people])
    assert hers < 0.9 * usual


def test_relit_she_looks_like_herself_under_that_light(found: list[Exemplar], people: list[Surface]) -> None:
    light = natural(99)
    errors = np.array(
        [
            [
                relative(render(one.surface, light)[both], render(person, light)[both])
                for person in people
                for both in [one.surface.mask & person.mask]
            ]
            for one in found
        ]
    )
    assert (errors.argmin(axis=1) == np.arange(len(people))).mean() >= 5 / 6
    assert np.median(np.diag(errors)) < 0.2


def test_her_texture_stays_hers(people: list[Surface], prior: FacePrior) -> None:
    person = people[0]
    albedo = person.albedo.copy()
    albedo[30:33, 8:11] *= 0.3  # a mole on the cheek, which nobody of the prior has
    marked = Surface(person.normals, albedo, person.mask)
    light = directional([0.2, 0.2, 1.0])
    plain, spotted = (exemplar(render(one, light), prior, motion=STILL).surface.albedo for one in (person, marked))
    assert spotted[31, 9] < 0.6 * plain[31, 9]
    assert abs(spotted[31, 30] / plain[31, 30] - 1) < 0.1


def test_unit_of_the_photograph_goes_to_the_light(people: list[Surface], prior: FacePrior) -> None:
    photo = render(people[1], natural(1))
    one, thousand = exemplar(photo, prior, motion=STILL), exemplar(1000 * photo, prior, motion=STILL)
    np.testing.assert_allclose(thousand.light.coefficients(2), 1000 * one.light.coefficients(2), rtol=1e-3, atol=1e-2)
    np.testing.assert_allclose(thousand.surface.albedo, one.surface.albedo, atol=1e-4)
    assert thousand.noise == pytest.approx(1000 * one.noise, rel=1e-3)


def test_albedo_has_the_tone_of_the_prior(found: list[Exemplar], prior: FacePrior) -> None:
    tones = [one.surface.albedo[one.surface.mask].mean() for one in found]
    np.testing.assert_allclose(tones, prior.tone, rtol=0.35)


def test_what_the_mask_hides_is_not_read(people: list[Surface], prior: FacePrior) -> None:
    photo = render(people[2], natural(2))
    good = np.ones(SHAPE, bool)
    good[:14] = False
    burnt = np.where(good, photo, photo.max())
    hidden, burnt_hidden = (exemplar(picture, prior, good, STILL) for picture in (np.where(good, photo, 0), burnt))
    np.testing.assert_allclose(burnt_hidden.surface.albedo, hidden.surface.albedo, atol=1e-4)
    assert apart(hidden.surface, people[2]) < apart(mean_face(prior), people[2]) + 1


def test_light_is_not_negative_anywhere_the_lamps_could_be(found: list[Exemplar]) -> None:
    for one in found:
        assert one.light.coefficients(2)[0] > 0
        assert np.linalg.norm(one.light.coefficients(2)[1:4]) <= np.sqrt(3) * one.light.coefficients(2)[0] * (1 + 1e-6)


def test_a_turned_photograph_has_turned_normals(people: list[Surface], prior: FacePrior) -> None:
    photo = render(people[3], directional([0.4, 0.2, 1.0]))
    upright = exemplar(photo, prior, motion=STILL).surface
    height = SHAPE[0]
    quarter = np.array([[0.0, -1.0, height - 1.0], [1.0, 0.0, 0.0]])  # clockwise: up becomes right
    turned = exemplar(np.rot90(photo, -1), prior, motion=quarter).surface
    back = np.rot90(turned.normals)
    both = np.rot90(turned.mask) & upright.mask
    x, y = -back[..., 1], back[..., 0]  # the axes turned back
    np.testing.assert_allclose(x[both], upright.normals[both][:, 0], atol=0.05)
    np.testing.assert_allclose(y[both], upright.normals[both][:, 1], atol=0.05)


@pytest.mark.parametrize("size", [(96, 84), (64, 64), (24, 21)])
def test_other_sizes_are_found_by_themselves(prior: FacePrior, size: tuple[int, int]) -> None:
    person = next(synthetic_people(1, size, seed=11))
    photo = render(person, directional([0.3, 0.2, 1.0]))
    images = exemplar_images(photo, prior)
    assert images.shape == (9, size[0] * size[1]) and images.dtype == np.float32
    one = exemplar(photo, prior)
    np.testing.assert_array_equal(images[:, one.surface.mask.ravel()], harmonic_images(one.surface))
    assert not images[:, ~one.surface.mask.ravel()].any()
    assert (one.surface.mask & person.mask).sum() > 0.8 * person.mask.sum()
    assert apart(one.surface, person) < 12


@pytest.mark.parametrize(
    ("photo", "mask", "motion", "message"),
    [
        (np.eye(12), None, None, "at least 16 x 16"),
        (np.eye(48)[:, :42], np.zeros(SHAPE, bool), STILL, "at least one pixel in the mask"),
        (np.eye(48)[:, :42], np.ones((3, 3), bool), STILL, "boolean mask"),
        (np.eye(48)[:, :42], None, [[1, 0, 900], [0, 1, 0]], "at least 36 good pixels of a face, got 0"),
        (np.eye(48)[:, :42], None, np.zeros((2, 3)), "can be undone"),
        (-np.eye(48)[:, :42], None, STILL, "expected some light in the face"),
    ],
)
def test_bad_input(prior: FacePrior, photo: np.ndarray, mask: np.ndarray, motion: np.ndarray, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        exemplar(photo, prior, mask, motion)
