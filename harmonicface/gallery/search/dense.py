"""The later stages for many photographs together, where each leaves many people: products of all with all."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from harmonicface.gallery.search import bound
from harmonicface.gallery.search.cascade import Found, reaches
from harmonicface.gallery.search.crowd import Company, Indices
from harmonicface.gallery.search.limit import Limit
from harmonicface.gallery.search.pixels import Pixels
from harmonicface.gallery.search.shared_basis import Question

PRODUCTS = 1 << 20  # that are looked at together
Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]
Pairs = tuple[Indices, Indices, Floats]  # people, photographs, and their bounds


def descend_together(
    companies: Sequence[Company],
    left: Sequence[Booleans],
    question: Question,
    limits: Sequence[Limit],
    pixels: Pixels,
    units: Floats,
) -> list[Found]:
    """Take those whom the first stage leaves through the later ones, and answer.

    Parameters
    ----------
    companies, pixels
        As for `search`.
    left
        For each company (n, q) booleans: whom the first stage leaves for which photograph.
    question
        The photographs.
    limits
        Of each photograph.
    units
        (q, p) the photographs.
    """
    survivors = np.zeros((len(companies[0].stops), len(units)), np.intp)
    parts = [
        part
        for company, some in zip(companies, left, strict=True)
        for part in _blocks(company, some, question, limits, survivors)
    ]
    people, photographs, bounds = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    _examine(people, photographs, bounds, limits, pixels, units)
    found = []
    for number, limit in enumerate(limits):
        answer = limit.answer()
        who, distances = tuple(who for _, who in answer), tuple(distance for distance, _ in answer)
        found.append(Found(who, distances, tuple(survivors[:, number].tolist()), len(limit.measured)))
    return found


def _blocks(
    company: Company, left: Booleans, question: Question, limits: Sequence[Limit], survivors: Indices
) -> list[Pairs]:
    """Return the pairs of person and photograph that all stages leave, block by block of people."""
    step = max(1, PRODUCTS // (company.rank * left.shape[1]))
    closeness = np.array([limit.closeness for limit in limits])
    parts = []
    for start in range(0, len(left), step):
        chosen = start + np.flatnonzero(left[start : start + step].any(axis=1))
        kept, bounds = left[chosen], np.empty((len(chosen), left.shape[1]), np.float32)
        products = company.first_products(question.coordinates(company.stops[0]), chosen)
        survivors[0] += kept.sum(axis=0)
        for stage, stop in enumerate(company.stops):
            remainders = question.remainder(stop)
            if stage:
                products = company.next_products(stage, chosen, products, question.coordinates(stop))
            squares, largest = company.squares[stage][chosen, :, None], company.largest[stage][chosen, None]
            bounds = bound.plain(products, squares, largest, remainders)[1]
            if stage:
                kept &= reaches(bounds, company.doubts[stage][chosen, None], closeness)
                some = kept.any(axis=1)
                chosen, kept, products, bounds = chosen[some], kept[some], products[some], bounds[some]
            if stage and stage < len(company.stops) - 1:
                survivors[stage] += kept.sum(axis=0)
        who, photographs = np.nonzero(kept)
        doubts = company.doubts[-1][chosen[who]]
        squares = company.squares[-1][chosen[who]]
        sharp = np.minimum(
            bounds[who, photographs], bound.sharp(products[who, :, photographs], squares, remainders[photographs])
        )
        last = reaches(sharp, doubts, closeness[photographs])
        if len(company.stops) > 1:
            survivors[-1] += np.bincount(photographs[last], minlength=left.shape[1])
        lengths = (np.sqrt(sharp) + doubts)[last].astype(np.float64) * (1 + 4 * float(bound.SINGLE))
        parts.append((company.people[chosen[who[last]]], photographs[last], np.square(lengths)))
    return parts


def _examine(
    people: Indices, photographs: Indices, bounds: Floats, limits: Sequence[Limit], pixels: Pixels, units: Floats
) -> None:
    """Look at the pixels of the people who are left, each once for all photographs that may be hers."""
    single = np.ascontiguousarray(units.T, np.float32)
    order = np.lexsort((-bounds, people))
    starts = np.flatnonzero(np.diff(people[order], prepend=-1))
    for pairs in np.split(order, starts[1:]) if len(order) else []:
        asked = [
            photographs[pair]
            for pair in pairs
            if bounds[pair] >= limits[photographs[pair]].closeness
            and int(people[pair]) not in limits[photographs[pair]].measured
        ]
        if not asked:
            continue
        person = int(people[pairs[0]])
        for photograph, reached in zip(asked, pixels.closeness(person, single[:, asked]), strict=True):
            if reached >= limits[photograph].closeness:
                limits[photograph].measure(person)
