"""A gallery behind scikit-learn's interface."""

from __future__ import annotations

import numpy as np
import pytest
from sklearn.base import clone
from sklearn.model_selection import cross_val_score

import harmonicface as hf
from harmonicface.gallery.classifier import GalleryClassifier

SIZE = 48
TOWARDS = np.array(
    [[0.0, 0.0, 1.0], [0.4, 0.0, 0.9], [-0.4, 0.1, 0.9], [0.0, 0.45, 0.9], [0.1, -0.4, 0.9], [0.5, 0.4, 0.7]]
)
TOWARDS /= np.linalg.norm(TOWARDS, axis=1, keepdims=True)
NAMES = ("sofia", "ada", "emmy")
PEOPLE = list(hf.synthetic_people(3, SIZE, seed=3))
X = np.stack([hf.render(one, hf.lights.directional(to)).ravel() for one in PEOPLE for to in TOWARDS])
Y = np.repeat(NAMES, len(TOWARDS))


def test_it_answers_as_the_gallery_does() -> None:
    classifier = GalleryClassifier((SIZE, SIZE)).fit(X[::2], Y[::2])
    gallery = hf.Gallery()
    for name in sorted(NAMES):
        gallery.enroll(name, X[::2][Y[::2] == name].reshape(-1, SIZE, SIZE))
    for row in X[1::2]:
        assert classifier.predict([row])[0] == gallery.match(row.reshape(SIZE, SIZE)).candidates[0].name
        found = gallery.search_scores(row.reshape(SIZE, SIZE)).scores
        assert np.allclose(classifier.predict_distances([row])[0], -found)


def test_known_lights_make_surfaces() -> None:
    classifier = GalleryClassifier((SIZE, SIZE), "harmonic9").fit(X, Y, lights=np.tile(TOWARDS, (3, 1)))
    assert classifier.gallery_.source_of("0") == "lit photographs"
    dark_side = hf.render(PEOPLE[0], hf.lights.from_angles(-70, 10)).ravel()
    assert classifier.predict([dark_side])[0] == "sofia"


def test_cross_validation_and_clones() -> None:
    classifier = GalleryClassifier((SIZE, SIZE))
    assert cross_val_score(classifier, X, Y, cv=3).tolist() == [1, 1, 1]
    assert clone(classifier).get_params() == {"image_shape": (SIZE, SIZE), "model": "default"}


@pytest.mark.parametrize(
    ("settings", "lights", "message"),
    [
        ({}, None, "image_shape"),
        ({"image_shape": (SIZE, SIZE), "model": "none"}, None, "model: expected one of"),
        ({"image_shape": (SIZE, SIZE)}, TOWARDS, r"lights: expected shape \(18, 3\), got \(6, 3\)"),
    ],
)
def test_what_it_cannot_learn_from(settings: dict, lights: np.ndarray | None, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        GalleryClassifier(**settings).fit(X, Y, lights)
