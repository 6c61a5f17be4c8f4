"""A gallery on the workers of a cluster: its answers are those of one process, also when a worker is killed."""

from __future__ import annotations

import logging
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from distributed import Client, LocalCluster

import harmonicface as hf
from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.distributed import shared_shelf as distributed
from harmonicface.gallery.distributed.share import shares_of
from harmonicface.gallery.distributed.shared_shelf import NEAR, Held, SharedShelf
from harmonicface.gallery.distributed.workers import AT_ONCE, enrolments, in_order, threads_of
from harmonicface.gallery.enrolled.enrolment import Model, enrolment_of
from harmonicface.gallery.frame import Frame
from harmonicface.gallery.search.cascade import Found
from harmonicface.recognition.models import harmonic9
from harmonicface.store.folder import ArrayFolder
from tests.gallery.shelved_people import drawn, made, pairs, scan, units

PEOPLE = [drawn((9, 5)[number % 2], "float32") for number in range(60)]
ASKED = units(PEOPLE, 12)


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    """Two processes of one thread each; what they say of a worker that is killed is no warning of ours."""
    quiet = {"silence_logs": logging.CRITICAL, "dashboard_address": ":0"}
    with LocalCluster(n_workers=2, threads_per_worker=1, **quiet) as cluster, Client(cluster, timeout=60) as client:
        client.wait_for_workers(2, timeout=60)
        yield client


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> ArrayFolder:
    return made(tmp_path_factory.mktemp("people") / "folder", PEOPLE, (4, 33))


@pytest.fixture(scope="module")
def shelf(client: Client, folder: ArrayFolder) -> SharedShelf:
    return SharedShelf(str(folder.path), client)


def holders(client: Client, shelf: SharedShelf) -> list[tuple[str, ...]]:
    """Return where the shelves are."""
    return [client.who_has([held])[held.key] for held in shelf._held]


def test_every_worker_holds_its_share(client: Client, shelf: SharedShelf) -> None:
    assert len(shelf) == 60
    assert sorted(holders(client, shelf)) == sorted((address,) for address in threads_of(client))


@pytest.mark.parametrize(("top", "distance"), [(1, 1.0), (5, 1.0), (None, 0.6), (3, 0.4), (100, 1.0)])
def test_answers_are_those_of_one_process(shelf: SharedShelf, top: int | None, distance: float) -> None:
    expected = [scan(PEOPLE, unit, top, distance) for unit in ASKED]
    assert [pairs(one) for one in shelf.search_many(ASKED, top, distance)] == expected
    assert pairs(shelf.search(ASKED[0], top, distance)) == expected[0]
    assert shelf.search_many(ASKED[:0], top, distance) == []


@pytest.mark.parametrize(("small", "message"), [(1, 1 << 22), (1, 2 * ASKED[:1].nbytes), (1 << 16, 1)])
def test_photographs_that_are_large_take_another_way(
    shelf: SharedShelf, monkeypatch: pytest.MonkeyPatch, small: int, message: int
) -> None:
    monkeypatch.setattr(distributed, "SMALL", small)
    monkeypatch.setattr(distributed, "MESSAGE", message)
    expected = [scan(PEOPLE, unit, 2, 1.0) for unit in ASKED]
    for _ in range(3):
        assert [pairs(one) for one in shelf.search_many(ASKED, 2)] == expected


def test_one_person_is_looked_for_nearby_first(shelf: SharedShelf, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []
    whole = SharedShelf._asked

    def seen(self: SharedShelf, photographs: np.ndarray, top: int | None, distance: float) -> list[Found]:
        asked.append((len(photographs), distance))
        return whole(self, photographs, top, distance)

    monkeypatch.setattr(SharedShelf, "_asked", seen)
    monkeypatch.setattr(distributed, "MANY", 20)
    near = PEOPLE[40][2].astype(np.float64)
    found = shelf.search_many(np.stack([near, ASKED[-1]]))
    assert [pairs(one) for one in found] == [scan(PEOPLE, unit, 1, 1.0) for unit in (near, ASKED[-1])]
    assert found[0].distances[0] < NEAR < found[1].distances[0]
    assert asked == [(2, NEAR), (1, 1.0)]
    monkeypatch.setattr(distributed, "MANY", 31)
    shelf.search(near)
    assert asked[2:] == [(1, 1.0)]


def test_closeness_is_in_the_order_of_enrolment(shelf: SharedShelf) -> None:
    expected = [np.square(ASKED @ rows.T.astype(np.float64)).sum(axis=1) for rows in PEOPLE]
    np.testing.assert_allclose(shelf.closeness(ASKED), expected, rtol=1e-5)


def test_shelves_stay_where_they_are_however_many_questions_are_asked(client: Client, shelf: SharedShelf) -> None:
    before = holders(client, shelf)
    threads = [threading.Thread(target=shelf.search, args=(unit,)) for unit in ASKED]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert holders(client, shelf) == before


def test_killing_a_worker_changes_no_answer(client: Client, shelf: SharedShelf) -> None:
    expected = [scan(PEOPLE, unit, 3, 1.0) for unit in ASKED]
    process = next(iter(client.run(os.getpid).values()))
    timer = threading.Timer(0.2, os.kill, (process, signal.SIGKILL))
    answers, start = [], time.monotonic()
    timer.start()
    while timer.is_alive() or len(answers) < 30 or time.monotonic() - start < 1:
        answers.append(pairs(shelf.search(ASKED[len(answers) % len(ASKED)], 3)))
    assert answers == [expected[number % len(ASKED)] for number in range(len(answers))]
    client.wait_for_workers(2, timeout=60)  # its nanny starts another one
    assert process not in client.run(os.getpid).values()
    shelf.spread()
    assert sorted(holders(client, shelf)) == sorted((address,) for address in threads_of(client))
    assert [pairs(one) for one in shelf.search_many(ASKED, 3)] == expected


def test_what_a_worker_refuses_is_said_here(client: Client, tmp_path: Path) -> None:
    other = made(tmp_path / "folder", PEOPLE[:9])
    manifest = other.version().manifest
    other.compact()
    with pytest.raises(HarmonicFaceError, match="got a gallery that was changed since"):
        SharedShelf(str(other.path), client, manifest)


def keep_copies(cache: str) -> None:
    """Say to a worker where copies are kept."""
    os.environ["HARMONICFACE_CACHE"] = cache


def test_a_gallery_by_a_path_of_fsspec(
    client: Client, folder: ArrayFolder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cache = str(tmp_path / "copies")
    monkeypatch.setenv("HARMONICFACE_CACHE", cache)
    client.run(keep_copies, cache)
    shelf = SharedShelf(f"file://{folder.path}", client)
    assert pairs(shelf.search(ASKED[1], 60)) == scan(PEOPLE, ASKED[1], 60, 1.0)
    (copy,) = (tmp_path / "copies").iterdir()
    assert {path.name for path in copy.iterdir()} == {path.name for path in folder.path.iterdir()}


def test_what_is_sent_of_a_shelf_is_the_share(folder: ArrayFolder) -> None:
    held = Held(shares_of(str(folder.path), 2)[1])
    made_again, (share,) = held.__reduce__()
    assert (made_again, share) == (Held, held.share)
    assert sys.getsizeof(held) >= held.shelf.nbytes


def square(number: int) -> int:
    """Square a number, but not every one."""
    if number == 37:
        raise HarmonicFaceError("number: expected another than 37")
    return number * number


def test_results_come_in_the_order_of_the_items(client: Client) -> None:
    assert list(in_order(client, square, iter(range(30)))) == [number**2 for number in range(30)]
    assert list(in_order(client, square, [])) == []


def test_what_is_refused_is_raised_behind_the_results_before(client: Client) -> None:
    results = []
    with pytest.raises(HarmonicFaceError, match="expected another than 37"):
        for result in in_order(client, square, range(100)):
            results.append(result)  # noqa: PERF402 - what came before the error is looked at
    assert results == [number**2 for number in range(37)]


def test_few_items_are_taken_ahead(client: Client) -> None:
    taken = []

    def items() -> Iterator[int]:
        for number in range(30):
            taken.append(number)
            yield number

    results = in_order(client, square, items(), ahead=1)
    next(results)
    assert len(taken) == AT_ONCE
    results.close()


def test_workers_enrol_as_this_process_does(client: Client, tmp_path: Path) -> None:
    people = [hf.synthetic_person(number, 24) for number in range(10)]
    people[4].save(tmp_path / "person.npz")
    sources = [*people[:4], tmp_path / "person.npz", partial(hf.synthetic_person, 5, 24), *people[6:]]
    model = Model(harmonic9, fewest=1, templates=True)
    expected = [enrolment_of(person, Frame(np.ones((24, 24), np.bool_)), model) for person in people]
    found = list(enrolments(client, sources, None, model))
    assert list(enrolments(client, [], None, model)) == []
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(one.subspace.rows, other.subspace.rows)
        np.testing.assert_array_equal(one.subspace.to_coefficients, other.subspace.to_coefficients)
        assert one.template is not None and other.template is not None
        np.testing.assert_array_equal(one.template.values, other.template.values)
        assert (one.source, one.frame.shape) == (other.source, (24, 24))


@pytest.mark.parametrize("model", ["default", "harmonic9"])
def test_a_gallery_that_is_opened_with_a_client(client: Client, tmp_path: Path, model: str) -> None:
    people = [(str(number), hf.synthetic_person(number, 24)) for number in range(12)]
    photographs = [hf.render(people[number][1], hf.lights.directional([number - 5, 2, 9])) for number in range(12)]
    alone = hf.Gallery.create(tmp_path / "alone", model)
    assert alone.enroll_many(people) == 12
    hf.Gallery.create(tmp_path / "shared", model, mask=alone.mask)
    shared = hf.Gallery.open(tmp_path / "shared", client=client)
    assert shared.enroll_many(people) == 12
    for number, photo in enumerate(photographs):
        found, expected = shared.match(photo), alone.match(photo)
        assert found.name == expected.name == str(number)
        assert [(one.name, one.distance) for one in found.candidates] == [
            (one.name, one.distance) for one in expected.candidates
        ]
    shared.remove("3")
    assert "3" not in [one.name for one in shared.match(photographs[3], top=20).candidates]


def test_a_client_is_one_of_dask() -> None:
    with pytest.raises(HarmonicFaceError, match=r"client: expected a client of dask.distributed, got SimpleNamespace"):
        threads_of(SimpleNamespace())


def test_a_cluster_without_workers_is_refused() -> None:
    with (
        LocalCluster(n_workers=0, silence_logs=logging.CRITICAL, dashboard_address=":0") as cluster,
        Client(cluster) as idle,
        pytest.raises(HarmonicFaceError, match="expected a cluster with workers, got one that has none now"),
    ):
        threads_of(idle)


def test_a_missing_dask_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(HarmonicFaceError, match=r"expected dask.distributed, got none: pip install harmonicface\[dist"):
        threads_of(SimpleNamespace())
