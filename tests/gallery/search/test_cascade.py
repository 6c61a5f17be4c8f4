"""One photograph: the answer is that of a scan of everybody, whatever the people, the basis and the photograph."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from harmonicface.gallery.search.cascade import search, search_many
from harmonicface.gallery.search.shared_basis import SharedBasis
from harmonicface.recognition.subspace import unit_photo

PIXELS = 60
Make = Callable[..., Any]
KINDS = ("person", "noisy", "shared", "orthogonal", "random", "one pixel")


def photograph(
    kind: str, rng: np.random.Generator, rows: list[NDArray[np.float32]], basis: SharedBasis
) -> NDArray[np.float64]:
    """Return a unit photograph: of somebody, noisy, in the span of the shared basis, orthogonal to it, or anything."""
    who = rows[int(rng.integers(len(rows)))].astype(np.float64)
    seen = rng.normal(size=len(who)) @ who
    anything = rng.normal(size=PIXELS)
    shared = (basis.rows @ anything) @ basis.rows
    rest = anything - shared
    pictures = {
        "person": seen,
        "noisy": seen + 0.05 * rng.normal(size=PIXELS) * np.linalg.norm(seen) / np.sqrt(PIXELS),
        "shared": shared,
        "orthogonal": rest if np.linalg.norm(rest) > 1e-6 else anything,
        "random": anything,
        "one pixel": np.eye(PIXELS)[int(rng.integers(PIXELS))],
    }
    return unit_photo(pictures[kind], PIXELS)


@st.composite
def situations(draw: st.DrawFn) -> dict[str, Any]:
    """Draw people, a basis, stages and what is asked."""
    m = draw(st.integers(1, PIXELS))
    columns = sorted(draw(st.sets(st.integers(1, 64), min_size=1, max_size=3)))
    asked = draw(st.sampled_from(["top", "within", "both"]))
    return {
        "seed": draw(st.integers(0, 10_000)),
        "ranks": draw(st.lists(st.sampled_from([1, 2, 5, 9, 25]), min_size=1, max_size=24)),
        "alike": draw(st.sampled_from([0.0, 0.5, 0.9, 0.999, 1.0])),
        "duplicates": draw(st.booleans()),
        "m": m,
        "columns": columns,
        "dtype": draw(st.sampled_from(["float16", "float32"])),
        "learned": draw(st.booleans()),
        "kind": draw(st.sampled_from(KINDS)),
        "top": None if asked == "within" else draw(st.integers(1, 30)),
        "distance": 1.0 if asked == "top" else draw(st.sampled_from([0.0, 1e-6, 0.04, 0.5, 0.99, 1.0])),
    }


@settings(max_examples=300)
@given(situations())
def test_the_answer_is_the_scans(make: Make, draw: Make, everybody: Make, situation: dict[str, Any]) -> None:
    rng = np.random.default_rng(situation["seed"])
    rows = draw(rng, situation["ranks"], PIXELS, situation["alike"], situation["duplicates"])
    stacked = np.concatenate(rows)
    if situation["learned"]:
        basis = SharedBasis.of(stacked, np.geomspace(1, 0.01, len(stacked)), situation["m"])
    else:
        basis = SharedBasis(np.linalg.qr(rng.normal(size=(PIXELS, situation["m"])))[0].T)
    known = make(rows, basis, situation["columns"], situation["dtype"])
    units = np.stack([photograph(kind, rng, rows, basis) for kind in (situation["kind"], "noisy", "random")])
    asked = situation["top"], situation["distance"]
    expected = [everybody(rows, unit, *asked) for unit in units]
    alone = [search(known.companies, known.pixels, basis, unit, *asked) for unit in units]
    together = search_many(known.companies, known.pixels, basis, units, *asked)
    for answers in (alone, together):
        assert [list(zip(one.distances, one.people, strict=True)) for one in answers] == expected


def test_ties_go_to_who_was_enrolled_first(make: Make, draw: Make) -> None:
    rng = np.random.default_rng(0)
    one = draw(rng, [3], PIXELS, 0.0)[0]
    known = make([one] * 7, SharedBasis(np.eye(PIXELS)[:4]), [2, 4])
    found = search(known.companies, known.pixels, known.basis, unit_photo(rng.normal(size=PIXELS), PIXELS), 4)
    assert found.people == (0, 1, 2, 3)
    assert len(set(found.distances)) == 1


@pytest.mark.parametrize("dtype", ["float16", "float32"])
def test_most_people_are_excluded_and_few_are_measured(make: Make, draw: Make, everybody: Make, dtype: str) -> None:
    rng = np.random.default_rng(1)
    rows = draw(rng, [5, 9] * 200, PIXELS, 0.5)
    basis = SharedBasis.of(np.concatenate(rows), np.ones(2800), 40)
    known = make(rows, basis, [10, 40], dtype)
    unit = photograph("noisy", rng, rows, basis)
    found = search(known.companies, known.pixels, basis, unit, 1)
    assert [(found.distances[0], found.people[0])] == everybody(rows, unit, 1, 1.0)
    assert found.survivors[-1] < 40
    assert found.measured < 10
    assert list(found.survivors) == sorted(found.survivors, reverse=True)


def test_nobody_within_a_distance(make: Make, draw: Make) -> None:
    rng = np.random.default_rng(2)
    known = make(draw(rng, [2] * 5, PIXELS, 0.0), SharedBasis(np.eye(PIXELS)[:30]), [30])
    unit = unit_photo(rng.normal(size=PIXELS), PIXELS)
    found = search(known.companies, known.pixels, known.basis, unit, None, 0.01)
    assert found.people == ()
    assert found.distances == ()


@pytest.mark.parametrize(("top", "distance"), [(1, 1.0), (5, 1.0), (None, 0.3), (None, 0.0), (3, 0.5)])
def test_many_photographs_find_what_each_finds_alone(make: Make, draw: Make, top: int | None, distance: float) -> None:
    rng = np.random.default_rng(4)
    rows = draw(rng, [9, 5, 25, 9] * 60, 300, 0.7)
    known = make(rows, SharedBasis.of(np.concatenate(rows[:80]), np.ones(20 * 48), 60), [8, 30, 60])
    units = np.stack([rng.normal(size=len(rows[who])) @ rows[who] + 0.01 * rng.normal(size=300) for who in range(12)])
    units /= np.linalg.norm(units, axis=1, keepdims=True)
    everybody = known.companies, known.pixels, known.basis
    alone = [search(*everybody, unit, top, distance) for unit in units]
    with patch("harmonicface.gallery.search.crowd.BLOCK", 2_000):
        together = search_many(*everybody, units, top, distance)
    for one, other in zip(alone, together, strict=True):
        assert (one.people, one.distances) == (other.people, other.distances)
        assert list(other.survivors) == sorted(other.survivors, reverse=True)
        assert len(other.people) <= other.measured <= len(rows)
