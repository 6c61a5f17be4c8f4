"""Many photographs at once: one matrix product a block of people for the first stage, then each by itself."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from harmonicface.gallery.search import bound
from harmonicface.gallery.search.cascade import FURTHEST, Found, begin, descend, foresee, new_limit, reaches
from harmonicface.gallery.search.crowd import Array, Company
from harmonicface.gallery.search.pixels import Pixels
from harmonicface.gallery.search.shared_basis import Question, SharedBasis

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
    together, first = Question(basis, np.ascontiguousarray(units.T)), companies[0].stops[0]
    rest, coordinates = together.remainder(first), together.coordinates(first)
    seen = [_explained(company, coordinates, rest) for company in companies]
    found = []
    for number, unit in enumerate(units):
        question, limit = Question(basis, unit), new_limit(companies, pixels, unit, top, distance)
        remainder, alone = question.remainder(first), question.coordinates(first)
        if top is not None:
            foresee(companies, [explained[:, number] for explained, _ in seen], question, limit, top)
        suspects = []
        for company, (_, bounds) in zip(companies, seen, strict=True):
            left = np.flatnonzero(reaches(bounds[:, number], company.doubts[0], limit.closeness))
            some = begin(company, left, alone, remainder)
            some.exclude(0, remainder, limit)
            suspects.append(some)
        found.append(descend(suspects, question, limit, pixels, unit, top))
    return found


def _explained(company: Company, coordinates: Array, remainders: Array) -> tuple[Array, Array]:
    """Return |b|^2 and the plain bound of everybody for every photograph, (n, q) each, block by block."""
    count, asked = len(company.people), coordinates.shape[1]
    explained, bounds = np.empty((count, asked), np.float32), np.empty((count, asked), np.float32)
    step = max(1, BLOCK // (company.rank * asked))
    for start in range(0, count, step):
        block = np.s_[start : start + step]
        products = company.first_products(coordinates, block)
        explained[block], bounds[block] = bound.plain(products, company.squares[0][block, :, None], remainders)
    return explained, bounds
