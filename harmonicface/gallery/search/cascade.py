"""One photograph: everybody's bound from a few numbers, fewer people's from more, the last ones' exact distances."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface.gallery.search import bound
from harmonicface.gallery.search.crowd import Array, Company, Indices
from harmonicface.gallery.search.limit import Limit
from harmonicface.gallery.search.pixels import Pixels
from harmonicface.gallery.search.shared_basis import SharedBasis

PROBED = 3  # people who are measured at each stage beside those asked for, to lower the limit early
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
        How many people no bound had excluded after each stage, then after all pixels in float32; the exact distance of
        each of the last was computed.
    """

    people: tuple[int, ...]
    distances: tuple[float, ...]
    survivors: tuple[int, ...]


@dataclass
class _Suspects:
    """Those of a company whom no bound has excluded so far."""

    company: Company
    chosen: Indices
    products: Array
    explained: Array
    bounds: Array

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
    question = basis.question(unit[None])
    coordinates = question.coordinates[0].astype(np.float32)
    stops = companies[0].stops
    # cast up: nextafter of a rounding to nearest is never below
    remainders = np.nextafter(question.remainders[0, list(stops)].astype(np.float32), np.float32(np.inf))
    rank = max(company.rank for company in companies)
    limit = Limit(top, distance, lambda person: pixels.distance(person, unit), pixels.size, rank)
    suspects, survivors = [_everybody(company, coordinates, remainders[0]) for company in companies], []
    for stage in range(len(stops)):
        if stage:
            for some in suspects:
                _ask_again(some, stage, coordinates, remainders[stage])
        _probe(suspects, limit, top)
        for some in suspects:
            _exclude(some, stage, remainders[stage], limit)
        survivors.append(sum(len(some.chosen) for some in suspects))
    survivors.append(_examine(suspects, pixels, unit, limit))
    answer = limit.answer()
    return Found(tuple(who for _, who in answer), tuple(distance for distance, _ in answer), tuple(survivors))


def _everybody(company: Company, coordinates: Array, remainder: np.float32) -> _Suspects:
    """Return the bounds of the first stage."""
    products = company.first_products(coordinates)
    explained, bounds = bound.plain(products, company.squares[0], remainder)
    return _Suspects(company, np.arange(len(products)), products, explained, bounds)


def _ask_again(some: _Suspects, stage: int, coordinates: Array, remainder: np.float32) -> None:
    """Compute the bounds of a later stage."""
    some.products = some.company.next_products(stage, some.chosen, some.products, coordinates)
    squares = some.company.squares[stage][some.chosen]
    some.explained, some.bounds = bound.plain(some.products, squares, remainder)


def _probe(suspects: Sequence[_Suspects], limit: Limit, top: int | None) -> None:
    """Measure the likeliest people, so that the limit is low before anybody is examined."""
    if top is None:
        return
    explained = np.concatenate([some.explained for some in suspects])
    people = np.concatenate([some.people for some in suspects])
    count = min(top + PROBED, len(people))
    if count:
        for person in people[np.argpartition(explained, -count)[-count:]]:
            limit.measure(int(person))


def _exclude(some: _Suspects, stage: int, remainder: np.float32, limit: Limit) -> None:
    """Keep those whose bound reaches the limit: first by the plain bound, then by the sharp one."""
    some.keep(reaches(some.bounds, some.company.doubts[stage][some.chosen], limit.closeness))
    squares = some.company.squares[stage][some.chosen]
    some.bounds = np.minimum(some.bounds, bound.sharp(some.products, squares, remainder))
    some.keep(reaches(some.bounds, some.company.doubts[stage][some.chosen], limit.closeness))


def reaches(bounds: Array, doubts: Array, closeness: float) -> NDArray[np.bool_]:
    r"""Return where (\sqrt{bound} + doubt)^2, with float32's rounding, is at least the closeness."""
    least = np.sqrt(max(0.0, closeness)) * (1 - 4 * float(bound.SINGLE))
    if closeness <= 0:
        return np.ones(bounds.shape, np.bool_)
    return np.asarray(np.sqrt(bounds) + doubts >= np.float32(least * (1 - 2 * float(bound.SINGLE))))


def _examine(suspects: Sequence[_Suspects], pixels: Pixels, unit: NDArray[np.float64], limit: Limit) -> int:
    """Look at the pixels of those who are left, the likeliest first; return of how many the distance was computed."""
    people = np.concatenate([some.people for some in suspects])
    lengths = [np.sqrt(some.bounds) + some.company.doubts[-1][some.chosen] for some in suspects]
    bounds = np.square(np.concatenate(lengths).astype(np.float64)) * (1 + 8 * float(bound.SINGLE))
    single = unit.astype(np.float32)[:, None]
    for index in np.argsort(-bounds, kind="stable"):
        if bounds[index] < limit.closeness:
            break
        person = int(people[index])
        if person not in limit.measured and pixels.closeness(person, single)[0] >= limit.closeness:
            limit.measure(person)
    return len(limit.measured)
