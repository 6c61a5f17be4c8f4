"""One photograph: everybody's bound from a few numbers, fewer people's from more, the last ones' exact distances."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from harmonicface.gallery.search import bound
from harmonicface.gallery.search.crowd import EVERYBODY, Array, Company, Indices
from harmonicface.gallery.search.limit import Limit
from harmonicface.gallery.search.pixels import Pixels
from harmonicface.gallery.search.shared_basis import OneOf, Question, SharedBasis

PROBED = 2  # people who are measured at each stage beside those asked for, to lower the limit early
FORESEEN = 64  # people whom the second stage sees before the first one excludes anybody
FURTHEST = 1.0  # no distance is larger


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
        How many people no bound had excluded after each stage; later stages are left out when reading the pixels of
        those who are left is cheaper.
    measured
        Of how many people the exact distance was computed.
    """

    people: tuple[int, ...]
    distances: tuple[float, ...]
    survivors: tuple[int, ...]
    measured: int


@dataclass
class Suspects:
    """Those of a company whom no bound has excluded so far."""

    company: Company
    chosen: Indices
    products: Array
    explained: Array
    bounds: Array

    def ask_again(self, stage: int, coordinates: Array, remainder: NDArray[np.float32]) -> None:
        """Compute the bounds of a later stage."""
        self.products = self.company.next_products(stage, self.chosen, self.products, coordinates)
        squares = self.company.squares[stage][self.chosen]
        self.explained, self.bounds = bound.plain(
            self.products, squares, self.company.largest[stage][self.chosen], remainder
        )

    def exclude(self, stage: int, remainder: NDArray[np.float32], limit: Limit) -> None:
        """Keep those whose bound reaches the limit: first by the plain bound, then by the sharp one."""
        doubts = self.company.doubts[stage]
        self.keep(reaches(self.bounds, doubts[self.chosen], limit.closeness))
        squares = self.company.squares[stage][self.chosen]
        self.bounds = np.minimum(self.bounds, bound.sharp(self.products, squares, remainder))
        self.keep(reaches(self.bounds, doubts[self.chosen], limit.closeness))

    def keep(self, kept: NDArray[np.bool_]) -> None:
        """Forget the others."""
        self.chosen, self.products = self.chosen[kept], self.products[kept]
        self.explained, self.bounds = self.explained[kept], self.bounds[kept]

    @property
    def people(self) -> Indices:
        """Their places in the order of enrolment."""
        return self.company.people[self.chosen]


def search(
    companies: Sequence[Company],
    pixels: Pixels,
    basis: SharedBasis,
    unit: NDArray[np.float64],
    top: int | None = 1,
    distance: float = FURTHEST,
) -> Found:
    """Find the people nearest to a photograph.

    Parameters
    ----------
    companies
        Everybody, from `crowd`.
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
    question = Question(basis, unit)
    first = companies[0].stops[0]
    rest, coordinates = question.remainder(first), question.coordinates(first)
    suspects = [begin(company, np.arange(len(company.people)), coordinates, rest) for company in companies]
    limit = new_limit(companies, pixels, unit, top, distance)
    if top is not None:
        foresee(companies, [some.explained for some in suspects], question, limit, top)
    for some in suspects:
        some.exclude(0, rest, limit)
    return descend(suspects, question, limit, pixels, unit, top)


def new_limit(
    companies: Sequence[Company], pixels: Pixels, unit: NDArray[np.float64], top: int | None, distance: float
) -> Limit:
    """Return the limit of a search that has just begun."""
    rank = max(company.rank for company in companies)
    return Limit(top, distance, lambda person: pixels.distance(person, unit), pixels.size, rank)


def descend(
    suspects: Sequence[Suspects],
    question: Question | OneOf,
    limit: Limit,
    pixels: Pixels,
    unit: NDArray[np.float64],
    top: int | None,
) -> Found:
    """Take those whom the first stage leaves through the later ones."""
    stops = suspects[0].company.stops
    survivors = [sum(len(some.chosen) for some in suspects)]
    for stage in range(1, len(stops)):
        if not _pays(suspects, stops[stage] - stops[stage - 1]):
            break
        rest, coordinates = question.remainder(stops[stage]), question.coordinates(stops[stage])
        for some in suspects:
            some.ask_again(stage, coordinates, rest)
        if top is not None:
            _probe(suspects, limit, top + PROBED)
        for some in suspects:
            some.exclude(stage, rest, limit)
        survivors.append(sum(len(some.chosen) for some in suspects))
    _examine(suspects, len(survivors) - 1, pixels, unit, limit)
    answer = limit.answer()
    people, distances = tuple(who for _, who in answer), tuple(distance for distance, _ in answer)
    return Found(people, distances, tuple(survivors), len(limit.measured))


def _pays(suspects: Sequence[Suspects], columns: int) -> bool:
    """Return whether a stage reads less than the pixels of those who are left: its part of the basis is float64."""
    return sum(len(some.chosen) * some.company.rank for some in suspects) > 2 * columns


def begin(company: Company, chosen: Indices, coordinates: Array, remainder: NDArray[np.float32]) -> Suspects:
    """Return people of a company with the bounds of the first stage."""
    everybody = len(chosen) == len(company.people)
    products = company.first_products(coordinates, EVERYBODY if everybody else chosen)
    squares, largest = company.squares[0], company.largest[0]
    if not everybody:
        squares, largest = squares[chosen], largest[chosen]
    return Suspects(company, chosen, products, *bound.plain(products, squares, largest, remainder))


def foresee(
    companies: Sequence[Company], explained: Sequence[Array], question: Question | OneOf, limit: Limit, top: int
) -> None:
    """Lower the limit by those who look likeliest at the first stage, and of these at the second."""
    stops = companies[0].stops
    coordinates, rest = question.coordinates(stops[0]), question.remainder(stops[0])
    likely = zip(companies, _likeliest(explained, FORESEEN + 4 * top), strict=True)
    ahead = [begin(company, chosen, coordinates, rest) for company, chosen in likely]
    if len(stops) > 1 and _pays(ahead, stops[1] - stops[0]):
        coordinates, rest = question.coordinates(stops[1]), question.remainder(stops[1])
        for some in ahead:
            some.ask_again(1, coordinates, rest)
    _probe(ahead, limit, top + PROBED)


def _likeliest(explained: Sequence[Array], count: int) -> list[Indices]:
    """Return, of each company, those among the people of whom most is explained."""
    together = np.concatenate(explained)
    count = min(count, len(together))
    chosen = np.sort(np.argpartition(together, -count)[-count:]) if count else np.empty(0, np.intp)
    starts = np.cumsum([0, *(len(some) for some in explained)])
    return [chosen[(chosen >= a) & (chosen < b)] - a for a, b in pairwise(starts)]


def _probe(suspects: Sequence[Suspects], limit: Limit, count: int) -> None:
    """Measure the likeliest people, so that the limit is low before anybody is examined."""
    for some, chosen in zip(suspects, _likeliest([some.explained for some in suspects], count), strict=True):
        for person in some.people[chosen]:
            limit.measure(int(person))


def reaches(bounds: Array, doubts: Array, closeness: float | NDArray[np.float64]) -> NDArray[np.bool_]:
    r"""Return where (\sqrt{bound} + doubt)^2, with float32's rounding, is at least the closeness."""
    least = np.sqrt(np.maximum(closeness, 0.0)) * (1 - 8 * float(bound.SINGLE))
    return np.asarray(np.sqrt(bounds) + doubts >= np.asarray(least, np.float32))


def _examine(suspects: Sequence[Suspects], stage: int, pixels: Pixels, unit: NDArray[np.float64], limit: Limit) -> None:
    """Look at the pixels of those who are left, the likeliest first."""
    people = np.concatenate([some.people for some in suspects])
    lengths = [np.sqrt(some.bounds) + some.company.doubts[stage][some.chosen] for some in suspects]
    bounds = np.square(np.concatenate(lengths).astype(np.float64)) * (1 + 8 * float(bound.SINGLE))
    single = unit.astype(np.float32)[:, None]
    for index in np.argsort(-bounds, kind="stable"):
        if bounds[index] < limit.closeness:
            break
        person = int(people[index])
        if person not in limit.measured and pixels.closeness(person, single)[0] >= limit.closeness:
            limit.measure(person)
