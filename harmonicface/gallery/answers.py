"""Answers: from a photograph and people to a Match, by plain projection or by a second look at a shortlist."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.gallery.enrolment import WITH_GEOMETRY
from harmonicface.gallery.explanation import Evidence, named, unknown
from harmonicface.gallery.match import INTENSITIES, PATTERNS, Candidate, Match, SearchScores
from harmonicface.gallery.people import People
from harmonicface.gallery.ranking import distance as distance_of
from harmonicface.gallery.ranking import rank, shortlist
from harmonicface.gallery.registered import looked_at, registered_look
from harmonicface.gallery.rule import Rule
from harmonicface.gallery.whereabouts import Whereabouts
from harmonicface.recognition.subspace import unit_photo

FEWEST_LEVELS = 8  # three bits: photographs that are as good as unlit have six or seven, the next darkest of Yale B 22
SAMPLE = 500  # pixels, which are enough to see that a photograph has more

Good = NDArray[np.bool_]
Asked = tuple[Floats, Good]  # the compared pixels of a photograph, (p,), and which are good


def by_projection(people: People, asked: Asked, count: int, rule: Rule) -> Match:
    """Match by plain projection.

    Parameters
    ----------
    people
        At least one.
    asked
        (p,) compared pixels of the photograph, and which are good.
    count
        How many candidates.
    rule
        Of the gallery.
    """
    pixels, good = asked
    ranked = rank(people, unit_photo(pixels[good], int(good.sum())), good, max(count, 2))
    distance, best = ranked[0]
    margin = ratio(ranked[1][0], distance) if len(ranked) > 1 else 1.0
    known = rule.is_known(distance, margin)
    reason = None if known else "nobody is near, or clearly nearer than the next"
    said = (people.name(best), distance, rule.threshold, False)
    return Match(
        name=people.name(best) if known else None,
        distance=distance,
        margin=margin,
        light=people.light(best, pixels, good, ambient=rule.ambient),
        candidates=tuple(
            Candidate(people.name(place), value, source=people.source(place)) for value, place in ranked[:count]
        ),
        domain=INTENSITIES,
        reason=reason,
        evidence=_evidence(
            people, best, asked, rule.ambient, named(*said) if reason is None else unknown(*said, reason)
        ),
    )


def by_second_look(people: People, asked: Asked, count: int, rule: Rule) -> Match:
    """Match by a second look at a shortlist; the parameters are those of `by_projection`, people with portraits."""
    pixels, good = asked
    listed = max(count, rule.shortlist)
    chosen = shortlist(people, pixels[good].astype(np.float64), good, listed)
    seen = registered_look(people, asked, chosen, listed, rule.threshold)
    verdict, shape = seen.verdict, people.frame.shape
    order = verdict.order[: max(count, 2)]
    candidates = [
        Candidate(
            name=people.name(int(seen.chosen[place])),
            distance=float(verdict.distances[place]),
            score=float(verdict.scores[place]),
            shift=seen.shift(place, shape),
            source=people.source(int(seen.chosen[place])),
        )
        for place in order
    ]
    first, best, index = candidates[0], order[0], int(seen.chosen[order[0]])
    reason = verdict.unknown(rule.threshold) or _unlit(pixels[good])
    said = (first.name, None if len(people) == 1 else first.score, rule.threshold, True)
    said_why = named(*said) if reason is None else unknown(*said, reason)
    shift = (float(verdict.shifts[best, 0]), float(verdict.shifts[best, 1]))
    return Match(
        name=first.name if reason is None else None,
        distance=first.distance,
        margin=ratio(candidates[1].distance, first.distance) if len(candidates) > 1 else 1.0,
        light=people.light(index, *seen.asked, shift) if pixels[good].any() else None,
        candidates=tuple(candidates[:count]),
        domain=PATTERNS,
        reason=reason,
        evidence=_evidence(people, index, asked, True, said_why, seen.whereabouts(best, people, asked)),
    )


def scores_by_projection(people: People, asked: Asked, names: Sequence[str], chosen: Sequence[int]) -> SearchScores:
    """Return the scores of some people, by name and place, by plain projection."""
    pixels, good = asked
    unit = unit_photo(pixels[good], int(good.sum()))
    distances = np.array([distance_of(people, place, unit, good) for place in chosen])
    return SearchScores(tuple(names), -distances, distances, np.zeros((len(names), 2)))


def scores_by_second_look(people: People, asked: Asked, names: Sequence[str], chosen: Sequence[int]) -> SearchScores:
    """Return the scores of some people, by name and place, by a second look at all of them."""
    verdict = looked_at(people, asked, np.asarray(chosen, np.intp)).verdict
    return SearchScores(tuple(names), verdict.scores, verdict.distances, verdict.shifts, verdict.blocks)


def ratio(second: float, first: float) -> float:
    """Return second over first, for distances that may both be zero.

    Examples
    --------
    >>> ratio(0.3, 0.2), ratio(0.3, 0.0), ratio(0.0, 0.0)
    (1.4999999999999998, inf, 1.0)
    """
    if first == 0:
        return 1.0 if second == 0 else np.inf
    return second / first


def _unlit(pixels: Floats) -> str | None:
    """Say that a photograph has so few grey levels that no face can be seen in it; None if it has enough."""
    some = pixels[:: max(len(pixels) // SAMPLE, 1)]
    if np.unique(some).size >= FEWEST_LEVELS or (count := np.unique(pixels).size) >= FEWEST_LEVELS:
        return None
    return f"the photograph has no more than {count} grey levels"


def _evidence(
    people: People, index: int, asked: Asked, ambient: bool, reason: str, where: Whereabouts | None = None
) -> Evidence:
    """Return what `Match.explain` needs."""
    return Evidence(
        frame=people.frame,
        pixels=asked[0],
        good=asked[1],
        subspace=people.subspace(index),
        where=where,
        geometry=people.source(index) in WITH_GEOMETRY,
        ambient=ambient,
        reason=reason,
    )
