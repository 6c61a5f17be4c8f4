"""The exemplar as a classifier: strangers to the prior, known from one photograph each."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from sklearn.base import clone

from harmonicface.appearance.render import render
from harmonicface.datasets.yale_b import load_yale_b
from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.natural import natural
from harmonicface.people.prior import FacePrior, synthetic_prior
from harmonicface.people.synthetic import synthetic_people
from harmonicface.recognition.estimators.exemplar import Exemplar

SHAPE = (48, 42)
PEOPLE = 6
NAMES = np.array([f"person {number}" for number in range(PEOPLE)])


@pytest.fixture(scope="module")
def prior() -> FacePrior:
    return synthetic_prior(SHAPE, 40)


@pytest.fixture(scope="module")
def photographs() -> np.ndarray:
    """Everybody under two natural lights, (2, people, pixels)."""
    people = list(synthetic_people(PEOPLE, SHAPE, seed=11))
    lit = [[render(person, natural(10 * turn + i)).ravel() for i, person in enumerate(people)] for turn in (1, 2)]
    return np.array(lit)


def test_people_are_known_from_one_photograph_each(prior: FacePrior, photographs: np.ndarray) -> None:
    classifier = Exemplar(SHAPE, prior).fit(photographs[0], NAMES)
    assert (classifier.predict(photographs[0]) == NAMES).all()
    assert (classifier.predict(photographs[1]) == NAMES).mean() >= 5 / 6
    assert classifier.predict_distances(photographs[1]).shape == (PEOPLE, PEOPLE)


def test_background_is_not_compared(prior: FacePrior, photographs: np.ndarray) -> None:
    classifier = Exemplar(SHAPE, prior).fit(photographs[0], NAMES)
    painted = np.where(classifier.mask_, photographs[1], 7.0)
    np.testing.assert_allclose(
        classifier.predict_distances(painted), classifier.predict_distances(photographs[1]), atol=1e-6
    )


def test_of_several_photographs_the_clearest_counts(prior: FacePrior, photographs: np.ndarray) -> None:
    rng = np.random.default_rng(0)
    clear, names = photographs[0, :3], NAMES[:3]
    spoilt = clear + 0.5 * clear.mean() * rng.standard_normal(clear.shape)
    both = Exemplar(SHAPE, prior).fit(np.concatenate([spoilt, clear]), np.tile(names, 2))
    alone = Exemplar(SHAPE, prior).fit(clear, names)
    np.testing.assert_allclose(
        both.predict_distances(photographs[1]), alone.predict_distances(photographs[1]), atol=1e-6
    )


def test_it_can_be_cloned_with_its_prior(prior: FacePrior) -> None:
    assert Exemplar(SHAPE, prior).get_params() == {"image_shape": SHAPE, "prior": prior}
    assert clone(Exemplar(SHAPE)).image_shape == SHAPE


def test_no_shape(photographs: np.ndarray) -> None:
    with pytest.raises(HarmonicFaceError, match="image_shape"):
        Exemplar().fit(photographs[0], NAMES)


def test_faces_that_do_not_overlap(prior: FacePrior, photographs: np.ndarray, monkeypatch: pytest.MonkeyPatch) -> None:
    pixels = iter(np.eye(SHAPE[0] * SHAPE[1], dtype=bool).reshape(-1, *SHAPE))
    monkeypatch.setattr(
        "harmonicface.recognition.exemplar.exemplar",
        lambda *_: SimpleNamespace(noise=1.0, surface=SimpleNamespace(mask=next(pixels))),
    )
    with pytest.raises(HarmonicFaceError, match="faces that overlap"):
        Exemplar(SHAPE, prior).fit(photographs[0], NAMES)


@pytest.mark.data
def test_people_of_yale_b_from_one_frontal_photograph(data_dir) -> None:
    people = load_yale_b(data_dir / "yaleb", people=[6, 7, 8])
    frontal = np.stack([person.photographs[person.angles.argmin()].ravel() for person in people])
    classifier = Exemplar((192, 168), synthetic_prior(SHAPE, 40)).fit(frontal, [person.number for person in people])
    wrong = np.concatenate(
        [
            classifier.predict(person.photographs[person.subsets <= 2].reshape(-1, 192 * 168)) != person.number
            for person in people
        ]
    )
    assert wrong.sum() == 0
