"""The exact search: everybody's bound by one product, fewer people's better bounds, the last ones' exact distances."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface.gallery.search import bound
from harmonicface.gallery.search.crowd import Array, Company, Indices
from harmonicface.gallery.search.limit import Limit
from harmonicface.gallery.search.pixels import Pixels
from harmonicface.gallery.search.products import products
from harmonicface.gallery.search.shared_basis import Question, SharedBasis
from harmonicface.gallery.search.sketch import form_columns

FORESEEN = 32  # people of whom the first stage is asked before anybody is excluded, beside four for each place
FURTHEST = 1.0  # no distance is larger
Units = NDArray[np.float64]


@dataclass(frozen=True)
class Found:
    """The answer, which is that of a scan of everybody, and who was excluded when.

    Parameters
    ----------
    people
        Places in the order of enrolment, nearest first; ties go to who was enrolled first.
    distances
        Of each, as `Subspace.distance`.
    survivors
        How many people no bound had excluded after the quadratic form and after each stage; later stages are left out
        when reading the pixels of those who are left is cheaper.
    measured
        Of how many people the exact distance was computed.
    """

    people: tuple[int, ...]
    distances: tuple[float, ...]
    survivors: tuple[int, ...]
    measured: int


@dataclass
class Suspects:
    """Those of a company whom not all photographs exclude.

    Parameters
    ----------
    company
        Theirs.
    chosen
        (n,) indices, rising.
    bounds
        (n, q) of |Q y|^2.
    kept
        (n, q) whom no bound excludes for which photograph.
    """

    company: Company
    chosen: Indices
    bounds: Array
    kept: NDArray[np.bool_]

    def exclude(self, closeness: Array) -> None:
        """Keep those whose bound reaches what is asked for."""
        self.kept &= self.bounds >= closeness
        some = self.kept.any(axis=1)
        if not some.all():
            self.chosen, self.bounds, self.kept = self.chosen[some], self.bounds[some], self.kept[some]


def search(
    companies: Sequence[Company],
    pixels: Pixels,
    basis: SharedBasis,
    unit: Units,
    top: int | None = 1,
    distance: float = FURTHEST,
) -> Found:
    """Find the people nearest to a photograph.

    Parameters
    ----------
    companies
        Everybody, from `crowd` or `packing.companies_of`.
    pixels
        Everybody's rows.
    basis
        That of the sketches.
    unit
        (p,) pixels of a photograph, of unit length (`unit_photo`).
    top
        How many at most; None for all within the distance.
    distance
        Nobody farther than this, 0 to 1.
    """
    return search_many(companies, pixels, basis, unit[None], top, distance)[0]


def search_many(
    companies: Sequence[Company],
    pixels: Pixels,
    basis: SharedBasis,
    units: Units,
    top: int | None = 1,
    distance: float = FURTHEST,
) -> list[Found]:
    """Find the people nearest to each of several photographs: the answers of `search`, by products of all with all.

    It keeps a few bytes for each person and photograph: ask for a few hundred photographs at a time.

    Parameters
    ----------
    companies, pixels, basis, top, distance
        As for `search`.
    units
        (q, p) photographs of unit length.
    """
    question, stops = Question(basis, units), companies[0].stops
    limits = _limits(companies, pixels, units, top, distance)
    count = form_columns(stops)
    asked = bound.features(question.coordinates(count), question.left(count))
    everybody = [products(company.forms.T, asked) for company in companies]
    if top is not None:
        _foresee(companies, everybody, question, limits, top)
    closeness = _needed(limits)
    suspects = []
    for company, bounds in zip(companies, everybody, strict=True):
        kept = bounds >= closeness
        chosen = np.flatnonzero(kept.any(axis=1))
        suspects.append(Suspects(company, chosen, bounds[chosen], kept[chosen]))
    survivors = [_counted(suspects)]
    for stage, stop in enumerate(stops):
        if not _pays(suspects, stop - (stops[stage - 1] if stage else 0)):
            break
        for some in suspects:
            found = some.company.bounds(stage, some.chosen, question.coordinates(stop), question.left(stop))
            some.bounds = np.minimum(some.bounds, found, out=found)
        if top is not None:
            _measure_likeliest([(one.company.people[one.chosen], one.bounds) for one in suspects], limits, top)
        for some in suspects:
            some.exclude(_needed(limits))
        survivors.append(_counted(suspects))
    _examine(suspects, limits, pixels, units)
    return [_answered(limit, counts) for limit, counts in zip(limits, zip(*survivors, strict=True), strict=True)]


def _limits(
    companies: Sequence[Company], pixels: Pixels, units: Units, top: int | None, distance: float
) -> list[Limit]:
    """Return the limit of each photograph."""
    rank = max(company.rank for company in companies)

    def measured(unit: Units) -> Limit:
        return Limit(top, distance, lambda person: pixels.distance(person, unit), pixels.size, rank)

    return [measured(unit) for unit in units]


def _needed(limits: Sequence[Limit]) -> Array:
    """Return the |Q y|^2 that a bound must reach for each photograph, rounded down."""
    return np.nextafter(np.array([limit.closeness for limit in limits], np.float32), np.float32(-np.inf))


def _counted(suspects: Sequence[Suspects]) -> list[int]:
    """Return how many people are left for each photograph."""
    return [int(count) for count in sum(np.count_nonzero(some.kept, axis=0) for some in suspects)]


def _pays(suspects: Sequence[Suspects], columns: int) -> bool:
    """Return whether a stage reads less than the pixels of those who are left: its part of the basis is float64."""
    return sum(len(some.chosen) * some.company.rank for some in suspects) > 2 * columns


def _foresee(
    companies: Sequence[Company], everybody: Sequence[Array], question: Question, limits: Sequence[Limit], top: int
) -> None:
    """Lower the limits by those who look likeliest to the quadratic form, and of these to the first stage."""
    stop = companies[0].stops[0]
    coordinates, left = question.coordinates(stop), question.left(stop)
    ahead = []
    for company, bounds in zip(companies, everybody, strict=True):
        chosen = np.unique(_likely(bounds, FORESEEN + 4 * top))
        ahead.append((company.people[chosen], company.bounds(0, chosen, coordinates, left)))
    _measure_likeliest(ahead, limits, top)


def _likely(bounds: Array, count: int) -> Indices:
    """Return about as many people with high bounds for each photograph, each the highest of her neighbours."""
    people, asked = bounds.shape
    neighbours = max(1, people // (4 * count))
    if neighbours == 1:
        count = min(count, people)
        return np.concatenate([np.argpartition(one, -count)[-count:] for one in np.ascontiguousarray(bounds.T)])
    groups = bounds[: people // neighbours * neighbours].reshape(-1, neighbours, asked)
    highest = np.ascontiguousarray(groups.max(axis=1).T)
    chosen = np.argpartition(highest, -count, axis=1)[:, -count:]
    inside = groups[chosen, :, np.arange(asked)[:, None]].argmax(axis=2)
    return np.asarray(chosen * neighbours + inside).reshape(-1)


def _measure_likeliest(some: Sequence[tuple[Indices, Array]], limits: Sequence[Limit], top: int) -> None:
    """Measure the people with the highest bounds for each photograph, so that its limit is low early."""
    people = np.concatenate([who for who, _ in some])
    together = np.concatenate([bounds for _, bounds in some]).T
    for limit, bounds in zip(limits, np.ascontiguousarray(together), strict=True):
        count = min(top, len(bounds))
        for person in people[np.argpartition(bounds, -count)[-count:]] if count else ():
            limit.measure(int(person))


def _examine(suspects: Sequence[Suspects], limits: Sequence[Limit], pixels: Pixels, units: Units) -> None:
    """Look at the pixels of those who are left, the likeliest first, each once for all photographs."""
    people = np.concatenate([some.company.people[some.chosen] for some in suspects])
    bounds = np.concatenate([np.where(some.kept, some.bounds, -np.inf) for some in suspects])
    single, needed = units.astype(np.float32), _needed(limits)
    best, least = bounds.max(axis=1), needed.min()
    for index in np.argsort(-best, kind="stable").tolist():
        if best[index] < least:
            break
        person = int(people[index])
        reaching = (bounds[index] >= needed).nonzero()[0].tolist()
        asked = [number for number in reaching if person not in limits[number].measured]
        if not asked:
            continue
        seen = pixels.closeness(person, single if len(asked) == len(single) else single[asked])
        for number, reached in zip(asked, seen.tolist(), strict=True):
            if reached >= limits[number].closeness:
                limits[number].measure(person)
                needed[number] = _needed(limits[number : number + 1])[0]
                least = needed.min()


def _answered(limit: Limit, survivors: Sequence[int]) -> Found:
    """Return the answer of a limit."""
    answer = limit.answer()
    people, distances = tuple(who for _, who in answer), tuple(distance for distance, _ in answer)
    return Found(people, distances, tuple(survivors), len(limit.measured))
