"""The prior is the mean and covariance of the people it was made of, and comes back from its file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from harmonicface.appearance.basis import harmonic_images
from harmonicface.errors import HarmonicFaceError
from harmonicface.people.prior import FORMAT, FacePrior, synthetic_prior
from harmonicface.people.spread import common_mask
from harmonicface.people.synthetic import synthetic_people
from harmonicface.store.archive import write_arrays
from harmonicface.surfaces.surface import Surface

COUNT = 8


@pytest.fixture(scope="module")
def people() -> list[Surface]:
    return list(synthetic_people(COUNT, size=(32, 28), seed=5))


@pytest.fixture(scope="module")
def images(people: list[Surface]) -> np.ndarray:
    common = common_mask(people)
    found = np.stack([harmonic_images(person)[:, common[person.mask]] for person in people]).astype(np.float64)
    tones = [person.albedo[common].mean() for person in people]
    return found / np.array(tones)[:, None, None]


def wall(albedo: float, size: int = 4) -> Surface:
    return Surface(np.tile([0.0, 0.0, 1.0], (size, size, 1)), np.full((size, size), albedo))


def test_mean_of_the_people(people: list[Surface], images: np.ndarray) -> None:
    prior = FacePrior.of(people)
    np.testing.assert_allclose(prior.mean, images.mean(axis=0), atol=1e-6)
    assert prior.shape == (32, 28) and (prior.mask == common_mask(people)).all()


def test_all_modes_give_the_covariance_of_each_pixel(people: list[Surface], images: np.ndarray) -> None:
    prior = FacePrior.of(people)
    assert len(prior.modes) == COUNT - 1
    for pixel in (0, 100, 300):
        np.testing.assert_allclose(prior.pixel_covariances[pixel], np.cov(images[:, :, pixel].T), atol=1e-6)
    assert prior.rest.max() < 1e-6


def test_fewer_modes_and_their_rest_keep_the_variance(people: list[Surface], images: np.ndarray) -> None:
    prior = FacePrior.of(people, modes=3)
    assert prior.modes.shape == (3, 9, prior.mask.sum())
    variances = prior.pixel_covariances.diagonal(axis1=1, axis2=2).sum(axis=0)
    np.testing.assert_allclose(variances, images.var(axis=0, ddof=1).sum(axis=1), rtol=1e-4)


def test_modes_are_orthogonal_and_begin_with_the_strongest(people: list[Surface]) -> None:
    flat = FacePrior.of(people).modes.reshape(COUNT - 1, -1).astype(np.float64)
    products = flat @ flat.T
    assert np.abs(products - np.diag(np.diag(products))).max() < 1e-5 * products.max()
    assert (np.diff(np.diag(products)) < 0).all()


def test_a_person_of_the_prior_is_within_its_span(people: list[Surface], images: np.ndarray) -> None:
    prior = FacePrior.of(people)
    modes = prior.modes.reshape(COUNT - 1, -1).astype(np.float64)
    apart = (images[2] - prior.mean).ravel()
    coefficients = modes @ apart / (modes**2).sum(axis=1)
    np.testing.assert_allclose(prior.images(coefficients), images[2], atol=1e-5)


def test_brightness_of_a_person_says_nothing(people: list[Surface]) -> None:
    darker = [Surface(person.normals, 0.5 * person.albedo, person.mask) for person in people]
    bright, dark = FacePrior.of(people), FacePrior.of(darker)
    np.testing.assert_allclose(dark.mean, bright.mean, atol=1e-6)
    assert dark.tone == pytest.approx(0.5 * bright.tone)


def test_nobody_differs_from_himself() -> None:
    prior = FacePrior.of([wall(0.5), wall(0.5), wall(0.2)])
    np.testing.assert_allclose(prior.pixel_covariances, 0, atol=1e-12)


def test_file_gives_it_back(people: list[Surface], tmp_path: Path) -> None:
    prior = FacePrior.of(people, source="eight of them")
    prior.save(tmp_path / "faces.prior")
    again = FacePrior.load(tmp_path / "faces.prior")
    for name in ("mean", "modes", "rest", "mask"):
        np.testing.assert_array_equal(getattr(again, name), getattr(prior, name))
    assert (again.tone, again.source, again.nbytes) == (prior.tone, "eight of them", prior.nbytes)


def test_made_once_and_kept() -> None:
    assert synthetic_prior((16, 14), 3) is synthetic_prior((16, 14), 3)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ([wall(0.5), wall(0.5)], "at least three Surfaces, got 2"),
        ([wall(0.5), wall(0.5), wall(0.5, 5)], "one shape"),
        ([wall(0.5), wall(0.5), wall(0.0)], "albedo above 0, got 0 everywhere of person 2"),
    ],
)
def test_people_that_make_no_prior(given: list[Surface], message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        FacePrior.of(given)


def test_people_without_a_pixel_in_common() -> None:
    normals, albedo = np.tile([0.0, 0.0, 1.0], (2, 2, 1)), np.ones((2, 2))
    masks = np.eye(4, dtype=bool).reshape(4, 2, 2)
    with pytest.raises(HarmonicFaceError, match="pixels that all of them have"):
        FacePrior.of([Surface(normals, albedo, mask) for mask in masks])


def test_no_modes(people: list[Surface]) -> None:
    with pytest.raises(HarmonicFaceError, match="modes"):
        FacePrior.of(people, modes=0)


def test_a_file_of_something_else(tmp_path: Path) -> None:
    write_arrays(tmp_path / "other", {"mean": np.zeros(3)}, {"format": "other"})
    with pytest.raises(HarmonicFaceError, match="expected a harmonicface face prior 1, got a file of 'other'"):
        FacePrior.load(tmp_path / "other")


def test_a_file_whose_arrays_do_not_fit(tmp_path: Path) -> None:
    arrays = {"mean": np.zeros((9, 5)), "modes": np.zeros((2, 9, 5)), "rest": np.zeros(9), "tone": np.ones(1)}
    write_arrays(tmp_path / "odd", {**arrays, "mask": np.ones((2, 2), bool)}, {"format": FORMAT})
    with pytest.raises(HarmonicFaceError, match="nine images of the mask's pixels"):
        FacePrior.load(tmp_path / "odd")
