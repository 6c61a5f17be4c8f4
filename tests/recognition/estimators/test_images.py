"""Methods that see photographs as images: gradient angle, local patterns, Tan & Triggs."""

from __future__ import annotations

import pickle

import cv2
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from sklearn.base import clone

from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.estimators.base import FaceClassifier
from harmonicface.recognition.estimators.gradient_angle import GradientAngle
from harmonicface.recognition.estimators.local_patterns import LocalBinaryPatterns
from harmonicface.recognition.estimators.tan_triggs import TanTriggs, without_light
from harmonicface.recognition.opencv import eight_bits

SHAPE = (40, 32)
METHODS = [GradientAngle(SHAPE), LocalBinaryPatterns(SHAPE), TanTriggs(SHAPE), TanTriggs(SHAPE, "correlation")]
each = pytest.mark.parametrize("classifier", METHODS, ids=repr)


def faces(people: int = 3, each: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """Smooth random pictures, each person's under two lights from the side."""
    random = np.random.default_rng(0)
    ramp = np.linspace(0.3, 0.7, SHAPE[1])
    skins = [gaussian_filter(random.uniform(0, 1, SHAPE), 1.5) for _ in range(people)]
    lit = [skin * light for skin in skins for light in (ramp, ramp[::-1])[:each]]
    return np.stack(lit).reshape(people * each, -1), np.repeat(["ada", "bob", "cyd"][:people], each)


@each
def test_people_are_told_apart_under_another_light(classifier: FaceClassifier) -> None:
    photographs, names = faces()
    fitted = clone(classifier).fit(photographs[::2], names[::2])
    assert (fitted.predict(photographs[1::2]) == names[1::2]).all()
    own = fitted.predict_distances(photographs[::2])
    assert np.abs(np.diag(own)).max() < 1e-3 and (own + np.eye(3) > 0.01).all()
    again = pickle.loads(pickle.dumps(fitted))
    np.testing.assert_array_equal(again.predict_distances(photographs), fitted.predict_distances(photographs))


@each
def test_the_shape_must_be_told_and_fit(classifier: FaceClassifier) -> None:
    photographs, names = faces()
    with pytest.raises(HarmonicFaceError, match=r"image_shape: expected \(height, width\)"):
        clone(classifier).set_params(image_shape=None).fit(photographs, names)
    with pytest.raises(HarmonicFaceError, match="image_shape: expected the height and width of 1280 pixels"):
        clone(classifier).set_params(image_shape=(30, 40)).fit(photographs, names)


def test_angles_do_not_see_gain_and_offset() -> None:
    photographs, names = faces()
    fitted = GradientAngle(SHAPE).fit(photographs, names)
    np.testing.assert_allclose(
        fitted.predict_distances(0.2 * photographs + 3), fitted.predict_distances(photographs), atol=2e-3
    )


def test_angles_between_ramps() -> None:
    """A ramp to the right beside one down: cos 90 = 0, one back: cos 180 = -1, nothing: 0."""
    right = np.tile(np.arange(16.0), (16, 1))
    fitted = GradientAngle((16, 16)).fit(right.reshape(1, -1), ["right"])
    queries = np.stack([right, right.T, -right, np.ones((16, 16))]).reshape(4, -1)
    np.testing.assert_allclose(fitted.predict_distances(queries)[:, 0], [0, 0.5**0.5, 1, 0.5**0.5], atol=1e-3)


def test_a_row_of_pixels_has_angles_along_it() -> None:
    fitted = GradientAngle((1, 8)).fit(np.stack([np.arange(8.0), -np.arange(8.0)]), ["up", "down"])
    assert fitted.predict(np.arange(8.0).reshape(1, -1) ** 2)[0] == "up"


def test_local_patterns_are_opencvs() -> None:
    photographs, names = faces()
    queries = np.roll(photographs, 1, axis=1)
    model = cv2.face.LBPHFaceRecognizer.create()
    images = eight_bits(photographs.reshape(-1, *SHAPE).astype(np.float32), "photographs")
    model.train(list(images), np.repeat([0, 1, 2], 2))
    fitted = LocalBinaryPatterns(SHAPE).fit(photographs, names)
    distances = fitted.predict_distances(queries)
    for query, own in zip(queries.reshape(-1, *SHAPE).astype(np.float32), distances, strict=True):
        label, distance = model.predict(eight_bits(query, "query"))
        assert label == own.argmin() and own.min() == pytest.approx(distance, rel=1e-4)


def test_tan_and_triggs_step_by_step() -> None:
    photo = np.random.default_rng(1).uniform(0, 1, (30, 20))
    curved = photo**0.2
    detail = gaussian_filter(curved, 1, mode="mirror", truncate=4) - gaussian_filter(
        curved, 2, mode="mirror", truncate=4
    )
    detail = detail / np.mean(np.abs(detail) ** 0.1) ** 10
    detail = detail / np.mean(np.minimum(10, np.abs(detail)) ** 0.1) ** 10
    found = without_light(photo)
    inside = (slice(8, -8), slice(8, -8))  # borders are reflected differently
    assert np.corrcoef(found[inside].ravel(), (10 * np.tanh(detail / 10))[inside].ravel())[0, 1] > 0.9999
    assert np.abs(found).max() <= 10


def test_what_is_the_same_everywhere_has_no_detail() -> None:
    assert not without_light(np.zeros((12, 12))).any()


@pytest.mark.parametrize(
    ("refused", "message"),
    [
        (lambda: without_light(np.full((4, 4), -1.0)), "photo: expected .* of at least 0"),
        (lambda: without_light(np.ones((4, 4, 3))), r"photo: expected \(h, w\)"),
        (lambda: TanTriggs(SHAPE, "eyes").fit(*faces()), 'compare: expected "patterns" or "correlation"'),
        (lambda: LocalBinaryPatterns((2, 640)).fit(*faces()), "at least 10 x 10 pixels"),
        (lambda: LocalBinaryPatterns(SHAPE).fit(3 * faces()[0], faces()[1]), "intensities from 0 to 1"),
        (lambda: GradientAngle(SHAPE, 0).fit(*faces()), "scale: expected a finite number above 0"),
    ],
)
def test_bad_input_is_refused(refused, message: str) -> None:
    with pytest.raises(HarmonicFaceError, match=message):
        refused()
