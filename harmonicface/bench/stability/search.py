"""Rows of the stability table: the exact search, and the bound by which it excludes people."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.bench.stability import exact
from harmonicface.bench.stability.row import CONSTANT, Answers, Measured, Rows, named, unit
from harmonicface.gallery.search import bound
from harmonicface.gallery.search.cascade import search
from harmonicface.gallery.search.crowd import crowd
from harmonicface.gallery.search.pixels import Pixels
from harmonicface.gallery.search.shared_basis import Question, SharedBasis
from harmonicface.gallery.search.sketch import form_columns, sketch, stage_columns
from harmonicface.recognition.subspace import Subspace, unit_photo

PIXELS, PEOPLE = 60, 12
COLUMNS = (5, 15)

Rows32 = NDArray[np.float32]


def of_search() -> Answers:
    """Return a function for each row."""
    return {**named("search", _of_crowds()), **named("bound", _of_bounds())}


def _people(ranks: Sequence[int] = (5,) * PEOPLE, seed: int = 0) -> list[Rows32]:
    """Return the rows of people who have a part of their pictures in common."""
    random = np.random.default_rng(seed)
    common = random.normal(size=(max(ranks), PIXELS))
    return [Subspace.of(common[:rank] + 0.5 * random.normal(size=(rank, PIXELS))).rows for rank in ranks]


def _photo(seed: int = 1) -> Floats:
    return np.random.default_rng(seed).normal(size=PIXELS)


def _learned(people: Sequence[Floats], rows: int = 15) -> SharedBasis:
    stacked = np.concatenate(people)
    return SharedBasis.of(stacked, np.ones(len(stacked)), rows)


def _outside(rows: Floats) -> NDArray[np.float64]:
    """Return orthonormal rows of what some rows leave over."""
    return np.ascontiguousarray(np.linalg.svd(rows.astype(np.float64))[2][len(rows) :])


def _of_crowds() -> Rows:
    people = _people()
    usual = _learned(people)
    near = people[3][2] + 0.3 * people[3][0]
    rows: Rows = {"a crowd": partial(_found, people, usual, _photo())}
    rows["sketches of float16"] = partial(_found, people, usual, _photo(), dtype="float16")
    mixed = _people([1, 2, 3, 5, 9] * 2)
    rows["people of 1 to 9 rows"] = partial(_found, mixed, _learned(mixed), _photo())
    single = _people([1] * PEOPLE)
    rows["people of one row"] = partial(_found, single, _learned(single), _photo())
    rows["a photo in the span"] = partial(_found, people, usual, near)
    rows["a photo that nobody explains"] = partial(_found, people[:8], usual, _outside(np.concatenate(people[:8]))[0])
    for apart in (1e-2, 1e-4, 1e-6):
        twin = Subspace.of(people[3] + apart * np.random.default_rng(2).normal(size=people[3].shape)).rows
        rows[f"two people {apart:.0e} apart"] = partial(_found, [*people, twin], usual, near + 1e-3 * _photo())
    rows["one person seven times"] = partial(_found, [people[3]] * 7, usual, near + 1e-3 * _photo())
    rows["a basis of one row"] = partial(_found, people, _learned(people, 1), _photo())
    rows["a basis of everything"] = partial(_found, people, SharedBasis(np.eye(PIXELS)), _photo())
    blind = SharedBasis(_outside(np.concatenate(people[:8]))[:10])
    rows["a basis that sees nobody"] = partial(_found, people[:8], blind, _photo())
    loose = [one + 1e-3 / PIXELS * np.random.default_rng(3).normal(size=one.shape) for one in people]
    rows["rows off orthonormal by 1e-03"] = partial(_found, [one.astype(np.float32) for one in loose], usual, _photo())
    for size, case in ((1e-300, "1e-300"), (1e300, "1e+300"), (1e-310, "1e-310 (subnormal)")):
        rows[f"a photo of {case}"] = partial(_found, people, usual, size * _photo())
    rows["rows not orthonormal"] = partial(_found, [one * np.float32(1.1) for one in people], usual, _photo())
    rows["a basis not orthonormal"] = lambda: _found(people, SharedBasis(1.001 * usual.rows), _photo())
    rows["a black photo"] = partial(_found, people, usual, np.zeros(PIXELS))
    rows["NaN"] = partial(_found, people, usual, np.full(PIXELS, np.nan))
    return rows


def _found(people: Sequence[Rows32], basis: SharedBasis, photo: Floats, dtype: str = "float32") -> Measured:
    """Compare the least distance that is found, and that of who is named, with the least of all sines in fractions."""
    seen = unit_photo(photo, PIXELS)
    sketches = [sketch(one, basis, COLUMNS, dtype) for one in people]
    defects = np.array([one.defect for one in sketches])
    companies = crowd(sketches, stage_columns(COLUMNS, len(basis.rows)))
    found = search(companies, Pixels(lambda person: people[person], defects, PIXELS), basis, seen)
    sines = [exact.sine(one.astype(np.float64), seen) for one in people]
    named = sines[int(found.people[0])]
    allowed = CONSTANT * (unit(1.0) + float(defects.max()) ** 2)
    note = (
        "the least distance, and that of who is named, absolute; allowed: rounding and the square of how far rows are "
        "said to be off orthonormal"
    )
    error = max(abs(found.distances[0] - min(sines)), abs(named - min(sines)))
    return Measured(error, allowed, 1.0, note)


def _of_bounds() -> Rows:
    people = _people()
    basis = _learned(people)
    within = [Subspace.of(turn @ basis.rows).rows for turn in np.random.default_rng(4).normal(size=(3, 5, 15))]
    beyond = _outside(basis.rows)
    inside, outside = _photo()[:15] @ basis.rows, _photo()[: len(beyond)] @ beyond
    rows: Rows = {"any person": partial(_bounded, people, basis, _photo())}
    rows["nothing left over"] = partial(_bounded, people, basis, inside)
    rows["everything left over"] = partial(_bounded, people, basis, outside)
    rows["a person within the basis"] = partial(_bounded, within, basis, _photo())
    rows["a person outside the basis"] = partial(_bounded, [beyond[:5].astype(np.float32)], basis, _photo())
    for size, case in ((1e-30, "1e-30"), (1e-42, "1e-42 (subnormal)")):
        rows[f"products of {case}"] = partial(_bounded, within, basis, outside + size * inside)
    return rows


def _bounded(people: Sequence[Rows32], basis: SharedBasis, photo: Floats) -> Measured:
    """Compare the bounds of all stages with what each person explains in fractions: none may be below."""
    seen = unit_photo(photo, PIXELS)
    question = Question(basis, seen[None])
    sketches = [sketch(one, basis, COLUMNS) for one in people]
    (company,) = crowd(sketches, COLUMNS)
    explained = np.array([exact.closeness(one.astype(np.float64), seen) for one in people])
    count = form_columns(company.stops)
    asked = bound.features(question.coordinates(count), question.left(count))
    first = np.stack([np.append(one.form, [one.levels[0], one.doubts[0]]) @ asked for one in sketches])
    everybody = np.arange(len(people))
    later = [
        company.bounds(stage, everybody, question.coordinates(stop), question.left(stop))
        for stage, stop in enumerate(company.stops)
    ]
    below = max(float((explained - bounds[:, 0].astype(np.float64)).max()) for bounds in (first, *later))
    return Measured(max(below, 0.0), 0.0, 1.0, "how far any bound is below the truth")
