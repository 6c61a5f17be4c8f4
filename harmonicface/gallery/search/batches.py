"""Many photographs at once: one matrix product a block of people for the first stage, then each by itself."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from harmonicface.gallery.search import bound
from harmonicface.gallery.search.cascade import FURTHEST, Found, begin, descend, foresee, new_limit, reaches
from harmonicface.gallery.search.crowd import Array, Company
from harmonicface.gallery.search.dense import descend_together
from harmonicface.gallery.search.pixels import Pixels
from harmonicface.gallery.search.shared_basis import Question, SharedBasis

DENSE = 0.1  # share of people and photographs from which products of all with all are faster than of each pair
BLOCK = 1 << 17  # products that are looked at together, about what a processor's cache holds


def search_many(
    companies: Sequence[Company],
    pixels: Pixels,
    basis: SharedBasis,
    units: NDArray[np.float64],
    top: int | None = 1,
    distance: float = FURTHEST,
) -> list[Found]:
    """Find the people nearest to each of several photographs: the answers of `search`.

    It keeps two float32 numbers for each person and photograph: ask for a few hundred photographs at a time.

    Parameters
    ----------
    companies, pixels, basis, top, distance
        As for `search`.
    units
        (q, p) photographs of unit length.
    """
    question, stops = Question(basis, np.ascontiguousarray(units.T)), companies[0].stops
    rest, coordinates = question.remainder(stops[0]), question.coordinates(stops[0])
    seen = [_explained(company, coordinates, rest) for company in companies]
    limits = [new_limit(companies, pixels, unit, top, distance) for unit in units]
    if top is not None:
        for number, limit in enumerate(limits):
            explained = [energies[:, number] for energies, _ in seen]
            foresee(companies, explained, question.one(number), limit, top)
    closeness = np.array([limit.closeness for limit in limits])
    left = [
        reaches(bounds, company.doubts[0][:, None], closeness)
        for company, (_, bounds) in zip(companies, seen, strict=True)
    ]
    if sum(int(some.sum()) for some in left) > DENSE * sum(some.size for some in left):
        return descend_together(companies, left, question, limits, pixels, units)
    found = []
    for number, (unit, limit) in enumerate(zip(units, limits, strict=True)):
        one, suspects = question.one(number), []
        for company, kept in zip(companies, left, strict=True):
            some = begin(company, np.flatnonzero(kept[:, number]), one.coordinates(stops[0]), one.remainder(stops[0]))
            some.exclude(0, one.remainder(stops[0]), limit)
            suspects.append(some)
        found.append(descend(suspects, one, limit, pixels, unit, top))
    return found


def _explained(company: Company, coordinates: Array, remainders: Array) -> tuple[Array, Array]:
    """Return |b|^2 and the plain bound of everybody for every photograph, (n, q) each, block by block."""
    count, asked = len(company.people), coordinates.shape[1]
    explained, bounds = np.empty((count, asked), np.float32), np.empty((count, asked), np.float32)
    step = max(1, BLOCK // (company.rank * asked))
    for start in range(0, count, step):
        block = np.s_[start : start + step]
        products = company.first_products(coordinates, block)
        explained[block], bounds[block] = bound.plain(
            products, company.squares[0][block, :, None], company.largest[0][block, None], remainders
        )
    return explained, bounds
