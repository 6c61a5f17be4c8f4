"""The main job: exact queries, errors recounted by hand, the same seed the same errors."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import harmonicface as hf
from harmonicface.bench.benchmark import STRANGERS, BenchmarkResult, run_benchmark
from harmonicface.bench.contenders import METHODS
from harmonicface.bench.tiers import TIERS
from harmonicface.gallery.gallery import Gallery
from harmonicface.recognition.correlation import Correlation
from harmonicface.recognition.opencv import Eigenfaces, Fisherfaces, LocalBinaryPatterns

FACES, SIZE, SEED, QUERIES = 6, 24, 5, 2
TIER_NAMES = [tier.name for tier in TIERS]


@pytest.fixture(scope="module")
def told() -> list[tuple[str, int, int]]:
    return []


@pytest.fixture(scope="module")
def result(told: list[tuple[str, int, int]]) -> BenchmarkResult:
    return run_benchmark(FACES, SIZE, SEED, QUERIES, progress=lambda *step: told.append(step))


def errors(result: BenchmarkResult) -> dict[str, dict[str, int]]:
    return {method.method: method.errors for method in result.methods}


def basis(surface: hf.Surface, model: str) -> np.ndarray:
    x, y, z = np.moveaxis(surface.normals.astype(np.float64), -1, 0)
    one = np.ones_like(x)
    nine = np.array([one, x, y, z, x * y, y * z, x * z, x * x - y * y, 3 * z * z - 1]) * surface.albedo * surface.mask
    return nine[{"linear3": slice(1, 4), "ambient4": slice(0, 4), "harmonic9": slice(0, 9)}[model]].reshape(-1, SIZE**2)


def distances(result: BenchmarkResult, photo: np.ndarray, model: str) -> np.ndarray:
    """How far everybody is from a photograph, by least squares."""
    pixels = photo.ravel().astype(np.float64)
    rests = []
    for person in result.people:
        rows = basis(person.surface, model)
        rests.append(np.linalg.norm(pixels - np.linalg.lstsq(rows.T, pixels, rcond=None)[0] @ rows))
    return np.array(rests) / np.linalg.norm(pixels)


def test_every_method_is_asked_every_photograph(result: BenchmarkResult) -> None:
    assert [method.method for method in result.methods] == list(METHODS)
    assert result.queries == dict.fromkeys(TIER_NAMES, FACES * QUERIES)
    assert list(result.margins) == list(result.open_set) == list(result.asked) == TIER_NAMES
    for method in result.methods:
        assert list(method.errors) == TIER_NAMES
        assert all(0 <= count <= FACES * QUERIES for count in method.errors.values())
        assert min(method.milliseconds, method.enrolment_seconds, method.bytes_per_person) > 0


@pytest.mark.parametrize("model", ["linear3", "ambient4", "harmonic9"])
def test_errors_of_subspaces_are_those_of_least_squares(result: BenchmarkResult, model: str) -> None:
    for tier, queries in result.asked.items():
        wrong = sum(distances(result, query.photo, model).argmin() != query.person for query in queries)
        assert errors(result)[model][tier] == wrong


def test_errors_of_correlation_are_those_of_numpy(result: BenchmarkResult) -> None:
    known = np.concatenate([person.photographs for person in result.people]).reshape(-1, SIZE**2)
    owners = np.repeat(np.arange(FACES), 7)
    for tier, queries in result.asked.items():
        found = [owners[np.corrcoef(known, query.photo.ravel())[-1, :-1].argmax()] for query in queries]
        assert errors(result)["correlation"][tier] == sum(
            person != query.person for person, query in zip(found, queries, strict=True)
        )


def test_nine_images_make_no_errors_but_in_extreme_light(result: BenchmarkResult) -> None:
    nine = errors(result)["harmonic9"]
    assert sum(count for tier, count in nine.items() if tier != "extreme") == 0
    assert sum(errors(result)["correlation"].values()) > 0  # it is not that anything would do


def test_margins_are_those_of_least_squares(result: BenchmarkResult) -> None:
    for tier, queries in result.asked.items():
        ratios = []
        for query in queries:
            found = distances(result, query.photo, "harmonic9")
            ratios.append(np.delete(found, query.person).min() / found[query.person])
        assert_allclose(result.margins[tier].median, np.median(ratios), rtol=1e-4)
        assert_allclose(result.margins[tier].worst, min(ratios), rtol=1e-4)


def test_who_is_refused(result: BenchmarkResult) -> None:
    for tier, queries in result.asked.items():
        refused = []
        for query in queries:
            first, second = np.sort(distances(result, query.photo, "harmonic9"))[:2]
            refused.append(first > result.gallery.threshold and second / first < result.gallery.margin)
        assert_allclose(result.open_set[tier].enrolled_refused, np.mean(refused))
        strangers = result.open_set[tier].strangers_refused * STRANGERS
        assert_allclose(strangers, round(strangers), atol=1e-9)


def test_photographs_are_exact_sums_over_the_light_and_noise(result: BenchmarkResult) -> None:
    for tier in TIERS:
        for query in result.asked[tier.name][:4]:
            surface = result.people[query.person].surface
            light = query.light.parts[0] if tier.name == "several" else query.light
            directions = light.directions.reshape(-1, 3)
            strengths = light.strengths.ravel()
            exact = np.zeros(surface.shape)
            for direction, strength in zip(directions, strengths, strict=True):
                exact += strength * np.maximum(surface.normals @ direction, 0)
            if tier.name == "several":
                exact += float(query.light.parts[1].strength)
            exact *= surface.albedo
            middle = (query.photo > 4 * tier.noise) & (query.photo < 1 - 4 * tier.noise)  # nothing clipped
            exposure = np.sum(query.photo[middle] * exact[middle]) / np.sum(exact[middle] ** 2)
            rest = np.std(query.photo[middle] - exposure * exact[middle])
            assert rest < 1.25 * np.hypot(tier.noise, 1 / 255 / np.sqrt(12)), tier.name


def test_no_photograph_of_the_gallery_is_asked(result: BenchmarkResult) -> None:
    known = {photo.tobytes() for person in result.people for photo in person.photographs}
    asked = [query.photo.tobytes() for queries in result.asked.values() for query in queries]
    assert len(set(asked)) == len(asked) == 6 * FACES * QUERIES
    assert not known & set(asked)
    assert all(len(person.photographs) == 7 for person in result.people)


def test_the_same_seed_gives_the_same_photographs_and_errors(result: BenchmarkResult) -> None:
    again = run_benchmark(FACES, SIZE, SEED, QUERIES)
    assert errors(again) == errors(result)
    assert (again.margins, again.open_set) == (result.margins, result.open_set)
    for tier in TIER_NAMES:
        for one, other in zip(again.asked[tier], result.asked[tier], strict=True):
            assert_array_equal(one.photo, other.photo)


def test_the_methods_that_are_asked_change_nothing_for_the_others(result: BenchmarkResult) -> None:
    alone = run_benchmark(FACES, SIZE, SEED, QUERIES, methods=["correlation"])
    assert errors(alone) == {"correlation": errors(result)["correlation"]}
    assert (alone.margins, alone.open_set) == (result.margins, result.open_set)


def test_another_seed_gives_other_people_and_light(result: BenchmarkResult) -> None:
    other = run_benchmark(FACES, SIZE, SEED + 1, 1, methods=["harmonic9"])
    assert not np.array_equal(other.people[0].surface.albedo, result.people[0].surface.albedo)


def test_progress_goes_forward_to_its_end(result: BenchmarkResult, told: list[tuple[str, int, int]]) -> None:
    stages: dict[str, list[tuple[int, int]]] = {}
    for what, done, of in told:
        stages.setdefault(what, []).append((done, of))
    assert list(stages) == ["people", "photographs for the gallery", *METHODS, "margins and strangers"]
    for steps in stages.values():
        dones = [done for done, _ in steps]
        assert dones == sorted(set(dones))
        assert {of for _, of in steps} == {steps[-1][0]}
    assert stages["harmonic9"][-1] == (6 * FACES * QUERIES, 6 * FACES * QUERIES)


def test_each_row_calls_the_method_that_it_names(monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[tuple[str, str]] = []
    now = [""]

    def watch(kind: type, method: str) -> None:
        original = getattr(kind, method)

        def counted(self, *arguments, **options):  # type: ignore[no-untyped-def]
            name = getattr(self, "model", kind.__name__ + str(getattr(self, "_drop_first", "")))
            calls.append((now[0], name))
            return original(self, *arguments, **options)

        monkeypatch.setattr(kind, method, counted)

    for kind in (Correlation, Eigenfaces, Fisherfaces, LocalBinaryPatterns):
        watch(kind, "nearest")
    watch(Gallery, "match")
    run_benchmark(3, 24, 0, 1, progress=lambda what, *_: now.__setitem__(0, what))
    expected = {
        "correlation": "Correlation",
        "eigenfaces": "Eigenfaces0",
        "eigenfaces_minus3": "Eigenfaces3",
        "fisherfaces": "Fisherfaces",
        "lbph": "LocalBinaryPatterns",
        "linear3": "linear3",
        "ambient4": "ambient4",
        "harmonic9": "harmonic9",
    }
    for row, kind in expected.items():
        assert [name for stage, name in calls if stage == row] == [kind] * 18, row


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"faces": 1}, "faces: expected an integer of at least 2, got int 1"),
        ({"size": 15}, "size: expected an integer of at least 16, got int 15"),
        ({"seed": -1}, "seed: expected an integer of at least 0, got int -1"),
        ({"queries": 0}, "queries: expected an integer of at least 1, got int 0"),
        ({"faces": 2.0}, "faces: expected an integer of at least 2, got float 2.0"),
        ({"methods": ["harmonic9", "magic"]}, "method: expected one of .*, got 'magic'"),
    ],
)
def test_bad_input(arguments: dict, message: str) -> None:
    with pytest.raises(hf.HarmonicFaceError, match=message):
        run_benchmark(**{"faces": 2, "size": 24, "seed": 0, **arguments})
