"""Sketches in the arrays of files: what is found there is what is found among the sketches themselves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from harmonicface.errors import HarmonicFaceError
from harmonicface.gallery.search.cascade import search
from harmonicface.gallery.search.packing import Pack, companies_of, packed, sketch_kinds, unpacked
from harmonicface.gallery.search.pixels import Pixels
from harmonicface.gallery.search.shared_basis import SharedBasis
from harmonicface.gallery.search.sketch import Sketch, sketch

PIXELS = 60
STOPS = (8, 20, 40)
BASIS = SharedBasis(np.linalg.qr(np.random.default_rng(0).normal(size=(PIXELS, 40)))[0].T)


def pack(sketches: Sequence[Sketch | None], alive: Sequence[bool], first: int, dtype: str = "float32") -> Pack:
    """Return a file of people, some of whom have no sketch or are gone."""
    kinds = sketch_kinds(STOPS, dtype)
    of_each = [packed(one) for one in sketches if one is not None]
    arrays = {
        name: np.concatenate([np.empty((0, *shape), kind), *(one[name] for one in of_each)])
        for name, (kind, shape) in kinds.items()
    }
    ranks = np.array([0 if one is None else len(one.numbers[0]) for one in sketches])
    kept = np.array(alive)
    places = first + np.flatnonzero(kept & (ranks > 0))
    return Pack(arrays, ranks, places, kept)


@pytest.mark.parametrize("dtype", ["float16", "float32"])
def test_a_sketch_comes_back_from_its_arrays(draw: Callable[..., Any], dtype: str) -> None:
    one = sketch(draw(np.random.default_rng(0), [9], PIXELS, 0.3)[0], BASIS, STOPS, dtype)
    arrays = packed(one)
    assert {name: (array.dtype, array.shape[1:]) for name, array in arrays.items()} == sketch_kinds(STOPS, dtype)
    back = unpacked(arrays)
    for name in ("form", "levels", "doubts"):
        np.testing.assert_array_equal(getattr(back, name), getattr(one, name), strict=True)
    for stage in range(3):
        np.testing.assert_array_equal(back.numbers[stage], one.numbers[stage], strict=True)
    assert (back.defect, back.stops) == (one.defect, one.stops)


@pytest.mark.parametrize("dtype", ["float16", "float32"])
def test_people_of_several_files_are_found(draw: Callable[..., Any], everybody: Callable[..., Any], dtype: str) -> None:
    rng = np.random.default_rng(1)
    ranks = [9, 5, 9, 9, 25, 5, 9, 9, 5, 5]
    rows: list[NDArray[np.float32]] = draw(rng, ranks, PIXELS, 0.5)
    sketches: list[Sketch | None] = [sketch(one, BASIS, STOPS, dtype) for one in rows]
    defects = np.array([one.defect for one in sketches if one is not None])
    sketches[3] = None
    alive = [True, False, True, True, True, True, True, False, True, True]
    packs = [pack(sketches[a:b], alive[a:b], a, dtype) for a, b in ((0, 4), (4, 6), (6, 10))]
    companies = companies_of(packs, STOPS)
    assert [company.rank for company in companies] == [5, 9, 25]
    assert sorted(int(who) for company in companies for who in company.people) == [0, 2, 4, 5, 6, 8, 9]
    there = [who for who in range(10) if alive[who] and who != 3]
    pixels = Pixels(lambda who: rows[who], defects, PIXELS)
    for who in there:
        unit = rng.normal(size=len(rows[who])) @ rows[who] + 0.02 * rng.normal(size=PIXELS)
        unit /= np.linalg.norm(unit)
        expected = [
            (distance, there[index]) for distance, index in everybody([rows[one] for one in there], unit, 4, 1.0)
        ]
        found = search(companies, pixels, BASIS, unit, 4)
        assert list(zip(found.distances, found.people, strict=True)) == expected


def test_nobody_makes_no_company() -> None:
    assert companies_of([], STOPS) == ()
    assert companies_of([pack([None], [True], 0)], STOPS) == ()


def test_refusals(draw: Callable[..., Any]) -> None:
    with pytest.raises(HarmonicFaceError, match="dtype: expected one of float16, float32, got 'int8'"):
        sketch_kinds(STOPS, "int8")
    one = sketch(draw(np.random.default_rng(0), [9], PIXELS, 0.3)[0], BASIS, STOPS)
    whole = pack([one], [True], 0)
    with pytest.raises(HarmonicFaceError, match="places: expected 1 of people with a sketch, got 2"):
        companies_of([Pack(whole.arrays, whole.ranks, np.arange(2), whole.alive)], STOPS)
    with pytest.raises(HarmonicFaceError, match=r"sketch_numbers_2: expected rows of shape \(44,\).*got \(40,\)"):
        companies_of([whole], (8, 20, 44))
    with pytest.raises(HarmonicFaceError, match=r"sketch_numbers_3: expected rows .* got none"):
        companies_of([whole], (8, 20, 40, 44))
