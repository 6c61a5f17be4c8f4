"""Photographs are grouped by person: known graphs, small crowds, and ten people of Yale B."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sklearn.base import BaseEstimator
from sklearn.metrics import adjusted_rand_score
from sklearn.utils.estimator_checks import parametrize_with_checks

from harmonicface.appearance.render import render
from harmonicface.datasets.yale_b import load_yale_b
from harmonicface.errors import HarmonicFaceError
from harmonicface.lighting.natural import natural
from harmonicface.people.synthetic import synthetic_people
from harmonicface.recognition.clustering import HarmonicClustering, linked, neighbour_graph, pieces

SHAPE = (96, 84)
PEOPLE, EACH = 4, 6
WHO = np.repeat(np.arange(PEOPLE), EACH)
NO_SHAPE = """
    check_clustering check_dict_unchanged check_dont_overwrite_parameters check_dtype_object check_estimators_dtypes
    check_estimators_fit_returns_self check_estimators_nan_inf check_estimators_overwrite_params
    check_estimators_pickle check_f_contiguous_array_estimator check_fit2d_1feature check_fit2d_predict1d
    check_fit_check_is_fitted check_fit_idempotent check_fit_score_takes_y check_methods_sample_order_invariance
    check_methods_subset_invariance check_n_features_in check_n_features_in_after_fitting check_pipeline_consistency
    check_positive_only_tag_during_fit check_readonly_memmap_input
"""


def cannot_apply(estimator: BaseEstimator) -> dict[str, str]:
    """Name the checks of tables that are no photographs."""
    if estimator.affinity == "conic":
        return {"check_clustering": "blobs about the origin are not the cones of non-negative photographs"}
    return dict.fromkeys(NO_SHAPE.split(), "the check fits a table without the height and width of an image")


@pytest.mark.filterwarnings("ignore::sklearn.exceptions.SkipTestWarning")
@pytest.mark.filterwarnings("ignore::sklearn.exceptions.ConvergenceWarning")
@parametrize_with_checks(
    [HarmonicClustering(2, "conic"), HarmonicClustering()],
    expected_failed_checks=cannot_apply,
)
def test_scikit_learn_checks(estimator: BaseEstimator, check) -> None:
    check(estimator)


@pytest.fixture(scope="module")
def photographs() -> np.ndarray:
    """Four people under six natural lights each, other ones for everybody."""
    people = synthetic_people(PEOPLE, SHAPE, seed=21)
    lit = [render(person, natural(10 * i + j)) for i, person in enumerate(people) for j in range(EACH)]
    return np.array(lit).reshape(PEOPLE * EACH, -1)


@pytest.mark.parametrize("known", [PEOPLE, None])
def test_people_are_told_apart(known: int | None, photographs: np.ndarray) -> None:
    found = HarmonicClustering(known, "patterns", SHAPE).fit(photographs)
    assert adjusted_rand_score(WHO, found.labels_) == 1
    assert found.n_clusters_ == PEOPLE and found.affinity_matrix_.shape == (len(WHO), len(WHO))


def test_order_and_brightness_change_nothing(photographs: np.ndarray) -> None:
    order = np.random.default_rng(0).permutation(len(WHO))
    brightness = np.random.default_rng(1).uniform(0.1, 10, (len(WHO), 1))
    found = HarmonicClustering(None, "patterns", SHAPE).fit_predict((brightness * photographs)[order])
    assert adjusted_rand_score(WHO[order], found) == 1
    assert found[0] == 0 and (np.diff(np.unique(found)) == 1).all()


def test_darkness_and_a_wall_are_nobody(photographs: np.ndarray) -> None:
    bare = np.zeros((2, photographs.shape[1]))
    bare[1] = 0.5
    found = HarmonicClustering(PEOPLE, "patterns", SHAPE).fit(np.concatenate([bare, photographs]))
    assert (found.labels_[:2] == -1).all() and adjusted_rand_score(WHO, found.labels_[2:]) == 1
    alone = HarmonicClustering(1, "patterns", SHAPE).fit(bare)
    assert (alone.labels_ == -1).all() and alone.n_clusters_ == 0


def test_one_person_is_one_group(photographs: np.ndarray) -> None:
    assert not HarmonicClustering(1, "patterns", SHAPE).fit_predict(photographs[:3]).any()


def test_cones_of_rays() -> None:
    random = np.random.default_rng(0)
    rays = np.zeros((2, 3, 30))
    rays[0, :, :15], rays[1, :, 15:] = random.uniform(0, 1, (2, 3, 15))
    mixed = np.einsum("pnr,prx->pnx", random.uniform(0, 1, (2, 12, 3)), rays).reshape(24, 30)
    assert adjusted_rand_score(np.repeat([0, 1], 12), HarmonicClustering(2, "conic").fit_predict(mixed)) == 1


@given(st.integers(2, 5), st.integers(4, 7), st.floats(0, 0.005))
def test_pieces_are_counted(count: int, size: int, bridge: float) -> None:
    graph = np.kron(np.eye(count), np.ones((size, size))) + bridge
    np.fill_diagonal(graph, 0)
    assert pieces(graph) == count


def test_one_piece_and_a_lonely_node() -> None:
    assert pieces(1 - np.eye(6)) == 1
    assert pieces(np.zeros((1, 1))) == 1


def test_bridges_under_one_lamp_are_not_taken() -> None:
    """A pair of strangers is as alike as a person is with herself, but less so than each with her own."""
    alike = np.kron(np.eye(2), np.full((5, 5), 0.8)) + 0.1
    alike[4, 5] = alike[5, 4] = 0.6
    graph = neighbour_graph(alike, 4)
    assert graph[4, 5] < 0.01 * graph[0, 1]
    np.testing.assert_array_equal(graph, graph.T)
    assert not graph.diagonal().any()


def test_all_alike_are_linked() -> None:
    assert (neighbour_graph(np.ones((2, 2)), 1)[0, 1]) > 0.9
    np.testing.assert_allclose(linked(np.zeros((2, 2))), [[0, 1e-6], [1e-6, 0]])


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"affinity": "colour"}, "expected one of patterns, gradient, conic, got str 'colour'"),
        ({"affinity": "patterns"}, "image_shape"),
        ({"affinity": "gradient", "image_shape": (3, 3)}, "height and width of 8064 pixels"),
        ({"n_clusters": 0}, "n_clusters"),
        ({"n_clusters": 99, "image_shape": SHAPE}, "at most the 24 photographs, got 99"),
        ({"n_neighbors": 0, "image_shape": SHAPE}, "n_neighbors"),
    ],
)
def test_bad_settings(settings: dict, message: str, photographs: np.ndarray) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        HarmonicClustering(**settings).fit(photographs)


@pytest.mark.parametrize("table", [np.ones(5), np.full((4, 5), np.nan), np.ones((1, 5)), [["a", "b"]]])
def test_bad_tables_in_one_line(table: object) -> None:
    with pytest.raises(HarmonicFaceError) as caught:
        HarmonicClustering(affinity="conic").fit(table)
    assert "\n" not in str(caught.value)


@pytest.mark.data
@pytest.mark.parametrize(("affinity", "told"), [("patterns", None), ("gradient", 3)])
def test_people_of_yale_b(data_dir, affinity: str, told: int | None) -> None:
    """Settings were chosen on people 1 to 5; these are all lights of 6 to 8, by patterns without saying how many."""
    people = load_yale_b(data_dir / "yaleb", people=[6, 7, 8])
    table = np.concatenate([person.photographs for person in people]).reshape(-1, 192 * 168)
    found = HarmonicClustering(told, affinity, image_shape=(192, 168)).fit(table)
    assert found.n_clusters_ == 3
    assert adjusted_rand_score(np.repeat([6, 7, 8], [len(person.files) for person in people]), found.labels_) == 1
