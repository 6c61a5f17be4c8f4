"""The exemplar as a classifier: strangers to the prior, known from one photograph each."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from sklearn.base import BaseEstimator, clone
from sklearn.utils.estimator_checks import parametrize_with_checks

from harmonicface.appearance.render import render
from harmonicface.datasets.yale_b import load_yale_b
from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.natural import natural
from harmonicface.people.prior import FacePrior, synthetic_prior
from harmonicface.people.synthetic import synthetic_people
from harmonicface.recognition.estimators.exemplar import Exemplar

SHAPE = (48, 42)
PEOPLE = 6
IMAGES_ALONE = """
    check_classifier_data_not_an_array check_classifiers_classes check_classifiers_one_label check_classifiers_train
    check_dict_unchanged check_dont_overwrite_parameters check_dtype_object check_estimators_dtypes
    check_estimators_fit_returns_self check_estimators_nan_inf check_estimators_overwrite_params check_estimators_pickle
    check_f_contiguous_array_estimator check_fit2d_1feature check_fit2d_1sample check_fit2d_predict1d
    check_fit_check_is_fitted check_fit_idempotent check_fit_score_takes_y check_methods_sample_order_invariance
    check_methods_subset_invariance check_n_features_in check_n_features_in_after_fitting check_pipeline_consistency
    check_positive_only_tag_during_fit check_readonly_memmap_input check_supervised_y_2d
"""
NAMES = np.array([f"person {number}" for number in range(PEOPLE)])


def cannot_apply(_: BaseEstimator) -> dict[str, str]:
    return dict.fromkeys(IMAGES_ALONE.split(), "the check fits a table without the height and width of an image")


@pytest.mark.filterwarnings("ignore::sklearn.exceptions.SkipTestWarning")
@parametrize_with_checks([Exemplar()], expected_failed_checks=cannot_apply)
def test_scikit_learn_checks_that_can_apply(estimator: BaseEstimator, check) -> None:
    check(estimator)


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
