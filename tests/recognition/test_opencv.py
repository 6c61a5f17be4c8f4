from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from scipy.ndimage import gaussian_filter
from sklearn.decomposition import PCA
from sklearn.discriminant_analysis import LinearDiscriminantAnalysis

from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.opencv import Eigenfaces, Fisherfaces, LocalBinaryPatterns, eight_bits

RANDOM = np.random.default_rng(11)
SHAPE = (24, 20)


def smooth(count: int, sigma: float = 3) -> np.ndarray:
    """Smooth random images of 0 to 1."""
    images = gaussian_filter(RANDOM.normal(size=(count, *SHAPE)), (0, sigma, sigma))
    lowest, highest = images.min(axis=(1, 2), keepdims=True), images.max(axis=(1, 2), keepdims=True)
    return (images - lowest) / (highest - lowest)


FACES = smooth(6)
PEOPLE = [np.clip(0.6 * face + 0.4 * smooth(5), 0, 1) for face in FACES]
QUERIES = np.clip(0.5 * np.repeat(FACES, 15, axis=0) + 0.5 * smooth(90), 0, 1)
ROWS = np.rint(255 * np.concatenate(PEOPLE)).reshape(30, -1)
OWNERS = np.repeat(range(6), 5)


@pytest.mark.parametrize("drop", [0, 1, 3])
def test_eigenfaces_decide_as_principal_components_by_scikit_learn(drop: int) -> None:
    eigenfaces = Eigenfaces(drop_first=drop)
    eigenfaces.enroll(PEOPLE)
    components = PCA(svd_solver="full").fit(ROWS)
    known = components.transform(ROWS)[:, drop : len(ROWS) - 1]
    asked = components.transform(np.rint(255 * QUERIES).reshape(90, -1))[:, drop : len(ROWS) - 1]
    expected = OWNERS[np.linalg.norm(asked[:, None] - known, axis=2).argmin(axis=1)]
    assert len(set(expected)) == 6
    assert_array_equal([eigenfaces.nearest(query) for query in QUERIES], expected)


def test_dropping_the_first_components_decides_otherwise() -> None:
    plain, reduced = Eigenfaces(), Eigenfaces(drop_first=3)
    plain.enroll(PEOPLE)
    reduced.enroll(PEOPLE)
    assert [plain.nearest(query) for query in QUERIES] != [reduced.nearest(query) for query in QUERIES]


def test_dropping_light_finds_the_face_that_plain_eigenfaces_miss() -> None:
    shade = np.linspace(-1, 1, SHAPE[1]) * np.ones(SHAPE)
    faces = 0.5 + 0.1 * (smooth(5) - 0.5)
    levels = np.array([0.0, 0.25, -0.25])[:, None, None]
    people = [face + np.roll(levels, turn, axis=0)[: 2 + turn % 2] * shade for turn, face in enumerate(faces)]
    queries = [face + 0.12 * shade for face in faces]
    plain, reduced = Eigenfaces(), Eigenfaces(drop_first=1)
    plain.enroll(people)
    reduced.enroll(people)
    assert [reduced.nearest(query) for query in queries] == list(range(5))
    assert [plain.nearest(query) for query in queries] != list(range(5))


def test_fisherfaces_decide_as_discriminants_by_scikit_learn() -> None:
    fisherfaces = Fisherfaces()
    fisherfaces.enroll(PEOPLE)
    reduced = PCA(n_components=30 - 6, svd_solver="full").fit(ROWS)  # the published n - c, so that scatter is regular
    discriminants = LinearDiscriminantAnalysis(solver="eigen").fit(reduced.transform(ROWS), OWNERS)
    directions = discriminants.scalings_[:, :5]
    directions = directions / np.linalg.norm(directions, axis=0)
    known = reduced.transform(ROWS) @ directions
    asked = reduced.transform(np.rint(255 * QUERIES).reshape(90, -1)) @ directions
    nearest = np.linalg.norm(asked[:, None] - known, axis=2).reshape(90, 6, 5).min(axis=2)
    first, second = np.sort(nearest, axis=1)[:, :2].T
    clear = second > 1.2 * first  # the theory leaves the lengths of the discriminants open, OpenCV's are 1 to 1.17
    assert clear.sum() > 30
    expected = nearest.argmin(axis=1)[clear]
    assert len(set(expected)) == 6
    assert_array_equal([fisherfaces.nearest(query) for query in QUERIES[clear]], expected)


def test_patterns_recognize_their_own_photographs() -> None:
    patterns = LocalBinaryPatterns()
    patterns.enroll(PEOPLE)
    assert [patterns.nearest(photo) for person in PEOPLE for photo in person] == list(OWNERS)


def test_patterns_ignore_a_monotone_change_of_grey() -> None:
    patterns = LocalBinaryPatterns()
    patterns.enroll([np.round(200 * person) / 255 for person in PEOPLE])
    plain = [patterns.nearest(np.round(200 * query) / 255) for query in QUERIES]
    brighter = [patterns.nearest((np.round(200 * query) + 40) / 255) for query in QUERIES]
    assert plain == brighter
    assert len(set(plain)) == 6


def test_memory_is_that_of_the_arrays() -> None:
    pixels, photographs = SHAPE[0] * SHAPE[1], 30
    sizes = {}
    for method in (Eigenfaces(), Eigenfaces(drop_first=3), Fisherfaces(), LocalBinaryPatterns()):
        assert method.bytes_per_person == 0
        method.enroll(PEOPLE)
        sizes[method] = method.bytes_per_person
    plain, reduced, fisher, patterns = sizes.values()
    assert plain == 8 * (pixels * 29 + pixels + photographs * 29) // 6
    assert reduced == 8 * (pixels * 26 + pixels + photographs * 26) // 6
    assert fisher == 8 * (pixels * 5 + pixels + photographs * 5) // 6
    assert patterns == 4 * 64 * 256 * 5


def test_eight_bits_are_rounded() -> None:
    stored = np.arange(256, dtype=np.float32) / np.float32(255)
    assert_array_equal(eight_bits(stored, "photo"), np.arange(256))
    assert_array_equal(eight_bits(np.array([0.4, 0.6], np.float32) / 255, "photo"), [0, 1])


@pytest.mark.parametrize("values", [[-0.01, 0.5], [0.5, 1.01]])
def test_intensities_that_eight_bits_cannot_hold(values: list[float]) -> None:
    with pytest.raises(HarmonicFaceError, match="photo: expected intensities from 0 to 1, got"):
        eight_bits(np.array(values, np.float32), "photo")


@pytest.mark.parametrize("drop", [-1, 1.5, True])
def test_no_count_of_components(drop: int) -> None:
    with pytest.raises(HarmonicFaceError, match="drop_first: expected an integer of at least 0, got"):
        Eigenfaces(drop_first=drop)


def test_too_few_photographs_for_a_component() -> None:
    with pytest.raises(
        HarmonicFaceError, match=r"expected enough for 4 principal components, got 4 of shape \(24, 20\)"
    ):
        Eigenfaces(drop_first=3).enroll([PEOPLE[0][:4]])
    with pytest.raises(HarmonicFaceError, match=r"expected enough for 4 principal components, got 5 of shape \(1, 3\)"):
        Eigenfaces(drop_first=3).enroll([PEOPLE[0][:, :1, :3]])


@pytest.mark.parametrize("people", [PEOPLE[:1], [person[:1] for person in PEOPLE]], ids=["one person", "one each"])
def test_too_few_photographs_for_discriminants(people: list[np.ndarray]) -> None:
    with pytest.raises(HarmonicFaceError, match="expected at least two people, and two photographs of one of them"):
        Fisherfaces().enroll(people)


def test_too_few_pixels_for_the_cells() -> None:
    with pytest.raises(HarmonicFaceError, match=r"expected at least 10 x 10 pixels for 8 x 8 cells, got \(24, 9\)"):
        LocalBinaryPatterns().enroll([person[:, :, :9] for person in PEOPLE])
