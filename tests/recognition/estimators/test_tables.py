"""The classifiers that make sense on any table are judged by scikit-learn's own checks."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
import pytest
from sklearn.base import BaseEstimator
from sklearn.model_selection import cross_val_score
from sklearn.utils.estimator_checks import check_estimator, estimator_checks_generator, parametrize_with_checks

from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.estimators.base import FaceClassifier
from harmonicface.recognition.estimators.correlation import Correlation
from harmonicface.recognition.estimators.eigenfaces import Eigenfaces
from harmonicface.recognition.estimators.fisherfaces import Fisherfaces
from harmonicface.recognition.estimators.from_surfaces import SurfaceClassifier
from harmonicface.recognition.estimators.gradient_angle import GradientAngle
from harmonicface.recognition.estimators.harmonic import Harmonic9
from harmonicface.recognition.estimators.linear import Ambient4, Linear3
from harmonicface.recognition.estimators.nine_points import NinePointsReal
from harmonicface.recognition.estimators.photograph_subspace import PhotographSubspace
from harmonicface.recognition.estimators.registry import ESTIMATORS, estimator

ON_TABLES = [
    Correlation(),
    Eigenfaces(),
    Eigenfaces(contrast=False),
    Fisherfaces(),
    Fisherfaces(contrast=False),
    PhotographSubspace(2),
    NinePointsReal(),
    Linear3(),
    Ambient4(),
]
WITHOUT_THREE = """
    check_classifier_data_not_an_array check_classifiers_classes check_classifiers_one_label check_classifiers_train
    check_dict_unchanged check_dont_overwrite_parameters check_estimators_fit_returns_self check_estimators_nan_inf
    check_estimators_overwrite_params check_estimators_pickle check_f_contiguous_array_estimator check_fit2d_predict1d
    check_fit_check_is_fitted check_fit_idempotent check_fit_score_takes_y check_methods_sample_order_invariance
    check_methods_subset_invariance check_n_features_in check_pipeline_consistency check_readonly_memmap_input
    check_supervised_y_2d
"""
IMAGES_ALONE = """
    check_classifier_data_not_an_array check_classifiers_classes check_classifiers_one_label check_classifiers_train
    check_dict_unchanged check_dont_overwrite_parameters check_dtype_object check_estimators_dtypes
    check_estimators_fit_returns_self check_estimators_nan_inf check_estimators_overwrite_params check_estimators_pickle
    check_f_contiguous_array_estimator check_fit2d_1feature check_fit2d_1sample check_fit2d_predict1d
    check_fit_check_is_fitted check_fit_idempotent check_fit_score_takes_y check_methods_sample_order_invariance
    check_methods_subset_invariance check_n_features_in check_n_features_in_after_fitting check_pipeline_consistency
    check_positive_only_tag_during_fit check_readonly_memmap_input check_supervised_y_2d
"""
NOT_ON_TABLES = [estimator(name) for name in ESTIMATORS if type(estimator(name)) not in map(type, ON_TABLES)]
each = pytest.mark.parametrize("classifier", ON_TABLES, ids=repr)


@pytest.mark.filterwarnings("ignore::sklearn.exceptions.SkipTestWarning")
@parametrize_with_checks(ON_TABLES)
def test_scikit_learn_checks(estimator: BaseEstimator, check) -> None:
    check(estimator)


def cannot_apply(classifier: FaceClassifier) -> dict[str, str]:
    """Name the checks that fit a method on a table that it cannot learn from."""
    if isinstance(classifier, Eigenfaces):
        return dict.fromkeys(WITHOUT_THREE.split(), "the table has too few columns to leave out three components")
    lacks = "lights" if isinstance(classifier, SurfaceClassifier) else "the height and width of an image"
    return dict.fromkeys(IMAGES_ALONE.split(), f"the check fits a table without {lacks}")


def can_apply() -> Iterator[object]:
    """Yield each check with a method that it can be applied to."""
    for classifier in (*NOT_ON_TABLES, Eigenfaces(drop_first=3)):
        for _, check in estimator_checks_generator(classifier):
            if check.func.__name__ not in cannot_apply(classifier):
                yield pytest.param(classifier, check, id=f"{classifier}-{check.func.__name__}")


@pytest.mark.filterwarnings("ignore::sklearn.exceptions.SkipTestWarning")
@pytest.mark.parametrize(("classifier", "check"), list(can_apply()))
def test_scikit_learn_checks_that_can_apply(classifier: FaceClassifier, check) -> None:
    check(classifier)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("classifier", [GradientAngle(), Harmonic9(), Eigenfaces(drop_first=3)], ids=repr)
def test_no_other_check_is_left_out(classifier: FaceClassifier) -> None:
    results = check_estimator(classifier, on_fail=None, on_skip=None)
    failed = {result["check_name"] for result in results if result["status"] == "failed"}
    assert failed == set(cannot_apply(classifier))


def faces(people: int = 3, each: int = 4, size: int = 60, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Photographs of people who differ, with a little noise, and their names."""
    random = np.random.default_rng(seed)
    names = np.repeat(["ada", "bob", "cyd", "dan"][:people], each)
    unlike = random.uniform(0, 1, (people, size)).repeat(each, axis=0)
    return unlike + random.normal(0, 0.05, unlike.shape), names


@each
def test_distances_decide(classifier: FaceClassifier) -> None:
    photographs, names = faces()
    fitted = classifier.fit(photographs, names)
    distances = fitted.predict_distances(photographs)
    assert distances.shape == (12, 3) and (distances >= 0).all()
    assert (fitted.classes_[distances.argmin(axis=1)] == names).all()
    assert (fitted.predict(photographs) == names).all()
    assert (fitted.decision_function(photographs) == -distances).all()


@each
def test_two_people_have_one_decision(classifier: FaceClassifier) -> None:
    photographs, names = faces(2)
    fitted = classifier.fit(photographs, names)
    distances = fitted.predict_distances(photographs)
    np.testing.assert_array_equal(fitted.decision_function(photographs), distances[:, 0] - distances[:, 1])


@each
def test_single_precision_stays_and_agrees(classifier: FaceClassifier) -> None:
    photographs, names = faces(size=400)
    double = classifier.fit(photographs, names).predict_distances(photographs + 0.1)
    single = classifier.fit(photographs.astype(np.float32), names).predict_distances((photographs + 0.1).astype("f4"))
    np.testing.assert_allclose(single, double, rtol=1e-4, atol=3e-3)


@each
def test_cross_validation(classifier: FaceClassifier) -> None:
    photographs, names = faces()
    assert cross_val_score(classifier, photographs, names, cv=2).mean() == 1


@each
@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (np.ones(60), "Expected 2D array"),
        (np.full((1, 60), np.nan), "contains NaN"),
        (np.ones((1, 59)), "59 features"),
    ],
)
def test_bad_queries_in_one_line(classifier: FaceClassifier, wrong: np.ndarray, message: str) -> None:
    fitted = classifier.fit(*faces())
    with pytest.raises(HarmonicFaceError, match=message) as caught:
        fitted.predict(wrong)
    assert "\n" not in str(caught.value)


@each
def test_bad_training_in_one_line(classifier: FaceClassifier) -> None:
    photographs, names = faces()
    with pytest.raises(HarmonicFaceError, match="inconsistent numbers of samples") as caught:
        classifier.fit(photographs, names[1:])
    assert "\n" not in str(caught.value)
    with pytest.raises(HarmonicFaceError, match="label type"):
        classifier.fit(photographs, np.linspace(0, 1, 12))


def test_brightness_and_contrast_change_nothing() -> None:
    photographs, names = faces()
    fitted = Correlation().fit(photographs, names)
    np.testing.assert_allclose(
        fitted.predict_distances(3 * photographs + 7), fitted.predict_distances(photographs), atol=1e-7
    )
    fitted = PhotographSubspace(2).fit(photographs, names)
    np.testing.assert_allclose(
        fitted.predict_distances(1e-150 * photographs), fitted.predict_distances(photographs), atol=1e-7
    )


def test_correlation_is_numpys() -> None:
    photographs, names = faces()
    query = np.random.default_rng(1).uniform(0, 1, (5, 60))
    expected = np.corrcoef(query, photographs)[:5, 5:].reshape(5, 3, 4).max(axis=2)
    found = 1 - 2 * Correlation().fit(photographs, names).predict_distances(query) ** 2
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_what_shows_nothing_is_far_from_everybody() -> None:
    photographs, names = faces()
    photographs[names == "bob"] = 0
    fitted = PhotographSubspace(2).fit(photographs, names)
    assert fitted.predict_distances(photographs[[0, 4]])[:, 1].tolist() == [1, 1]
    assert fitted.predict_distances(np.zeros((1, 60))).tolist() == [[1, 1, 1]]
    assert Correlation().fit(photographs, names).predict_distances(np.ones((1, 60))).round(6).tolist() == [
        [0.707107] * 3
    ]


def test_eigenfaces_keep_distances_of_the_training_photographs() -> None:
    photographs, names = faces(each=1)
    fitted = Eigenfaces(contrast=False).fit(photographs, names)
    between = np.linalg.norm(photographs[:, None] - photographs, axis=2)
    np.testing.assert_allclose(fitted.predict_distances(photographs), between, atol=1e-10)


def test_eigenfaces_without_the_first_do_not_see_the_light() -> None:
    photographs, names = faces(people=4, each=2, seed=3)
    light = np.random.default_rng(5).uniform(0, 1, 60)
    strength = np.tile([0.0, 10.0], 4)[:, None]
    fitted = Eigenfaces(drop_first=1, contrast=False).fit(photographs + strength * light, names)
    assert (fitted.predict(photographs + 5 * light) == names).all()
    assert abs(fitted.components_ @ light).max() < 0.2


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"drop_first": -1}, "drop_first: expected an integer of at least 0"),
        ({"n_components": 0}, "n_components: expected an integer of at least 1"),
        ({"drop_first": 11}, "enough photographs for 12 principal components, got n_samples=12"),
        ({"drop_first": 2, "n_components": 2}, "enough photographs for 3"),
    ],
)
def test_eigenfaces_refuse(parameters: dict[str, int], message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        Eigenfaces(**parameters).fit(*faces())


def test_fisherfaces_refuse_what_has_no_scatter() -> None:
    photographs, names = faces()
    with pytest.raises(HarmonicFaceError, match="two classes"):
        Fisherfaces().fit(photographs[:4], names[:4])
    with pytest.raises(HarmonicFaceError, match="two photographs of one of them"):
        Fisherfaces().fit(photographs[::4], names[::4])


def test_fisherfaces_find_the_direction_between_two_clouds() -> None:
    random = np.random.default_rng(2)
    covariance = np.array([[2.0, 1.9], [1.9, 2.0]])
    names = np.repeat(["ada", "bob"], 5000)
    cloud = random.multivariate_normal([0, 0], covariance, 10000) + np.outer(names == "bob", [1.0, -1.0])
    direction = Fisherfaces(contrast=False).fit(cloud, names).projection_[:, 0]
    expected = np.linalg.solve(covariance, [1.0, -1.0])  # Fisher's
    cosine = abs(direction @ expected) / np.linalg.norm(direction) / np.linalg.norm(expected)
    assert cosine > 0.999


@pytest.mark.parametrize("kind", [Eigenfaces, Fisherfaces])
def test_without_contrast_the_nearest_are_opencvs(kind: type[FaceClassifier]) -> None:
    random = np.random.default_rng(4)
    photographs, names = np.rint(255 * random.uniform(0, 1, (24, 60))), np.repeat(["ada", "bob", "cyd", "dan"], 6)
    queries = np.rint(0.5 * photographs + 0.5 * random.permutation(photographs))
    recognizer = (
        cv2.face.EigenFaceRecognizer.create(23) if kind is Eigenfaces else cv2.face.FisherFaceRecognizer.create()
    )
    recognizer.train(list(photographs.astype(np.uint8).reshape(-1, 6, 10)), np.repeat(np.arange(4), 6))
    fitted = kind(contrast=False).fit(photographs, names)
    distances = fitted.predict_distances(queries)
    for query, own in zip(queries.astype(np.uint8).reshape(-1, 6, 10), distances, strict=True):
        label, distance = recognizer.predict(query)
        assert label == own.argmin()
        # OpenCV's discriminants have lengths of 1 to half a per cent
        assert own.min() == pytest.approx(distance, rel=1e-9 if kind is Eigenfaces else 5e-3)


def test_fisherfaces_of_people_who_never_change() -> None:
    photographs, names = faces()
    still = photographs[::4].repeat(4, axis=0)
    fitted = Fisherfaces().fit(still, names)
    assert (fitted.predict(photographs) == names).all()


def test_fisherfaces_of_people_with_one_mean() -> None:
    photographs, _ = faces(people=2)
    mirrored = np.concatenate([photographs, -photographs])
    names = np.tile(["ada"] * 4 + ["bob"] * 4, 2)
    assert (Fisherfaces().fit(mirrored, names).predict(mirrored) == names).all()


def test_a_subspace_is_refused_without_dimensions() -> None:
    with pytest.raises(HarmonicFaceError, match="n_components: expected an integer of at least 1"):
        PhotographSubspace(0).fit(*faces())
