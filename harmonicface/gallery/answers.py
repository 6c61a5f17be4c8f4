"""Answers: from a photograph and people to a Match, by plain projection or by a second look at a shortlist."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harmonicface._validate import Floats
from harmonicface.gallery.enrolled.enrolment import WITH_GEOMETRY
from harmonicface.gallery.enrolled.people import People
from harmonicface.gallery.looks.explanation import Evidence, named, unknown
from harmonicface.gallery.looks.registered import looked_at, registered_look
from harmonicface.gallery.looks.whereabouts import Whereabouts
from harmonicface.gallery.match import INTENSITIES, PATTERNS, Candidate, Match, Search, SearchScores
from harmonicface.gallery.rule import Rule
from harmonicface.gallery.search.cascade import Found
from harmonicface.gallery.search.ranking import distance as distance_of
from harmonicface.gallery.search.ranking import rank, shortlist
from harmonicface.recognition.subspace import unit_photo

FEWEST_LEVELS = 8  # three bits: photographs that are as good as unlit have six or seven, the next darkest of Yale B 22
AT_ONCE = 64  # photographs that are searched for together
EVERYBODY = Found((), (), (), 0)  # what stage one finds where it is not asked
SAMPLE = 500  # pixels, which are enough to see that a photograph has more

Good = NDArray[np.bool_]
Asked = tuple[Floats, Good]  # the compared pixels of a photograph, (p,), and which are good


@dataclass(frozen=True, eq=False)
class Question:
    """A photograph, and whom stage one found for it: plain projection, the same for every model.

    Parameters
    ----------
    asked
        (p,) compared pixels of the photograph, and which are good.
    found
        The nearest people, for a shortlist in any order; nobody where a photograph is dark or everybody is on the list.
    count
        How many candidates are asked for.
    """

    asked: Asked
    found: Found
    count: int

    def search(self, people: People) -> Search:
        """Return how many people stage one excluded."""
        return Search(len(people), self.found.survivors, self.found.measured)


def stage_one(people: People, asked: Asked, count: int, rule: Rule) -> Question:
    """Find the people nearest to a photograph, as many as its answer takes."""
    if _takes_everybody(people, asked, count, rule):
        return Question(asked, EVERYBODY, count)
    pixels, good = asked
    unit = unit_photo(pixels[good], int(good.sum()))
    return Question(asked, (shortlist if rule.by_score else rank)(people, unit, good, _wanted(count, rule)), count)


def stage_one_of_many(people: People, asked: Sequence[Asked], count: int, rule: Rule) -> list[Question]:
    """Find the people nearest to each of several photographs without masks: the answers of `stage_one`, together."""
    searcher = people.searcher()
    if searcher is None:
        return [stage_one(people, one, count, rule) for one in asked]
    found = [EVERYBODY] * len(asked)
    rest = [number for number, one in enumerate(asked) if not _takes_everybody(people, one, count, rule)]
    for start in range(0, len(rest), AT_ONCE):
        some = rest[start : start + AT_ONCE]
        units = np.stack([unit_photo(asked[number][0], people.frame.pixels) for number in some])
        for number, one in zip(some, searcher.search_many(units, _wanted(count, rule)), strict=True):
            found[number] = one
    return [Question(one, hers, count) for one, hers in zip(asked, found, strict=True)]


def _wanted(count: int, rule: Rule) -> int:
    """Return how many people stage one finds: the second is asked for how much nearer the first is."""
    return max(count, rule.shortlist) if rule.by_score else max(count, 2)


def _takes_everybody(people: People, asked: Asked, count: int, rule: Rule) -> bool:
    """Tell whether the shortlist is everybody, or the first ones because the photograph is dark."""
    return rule.by_score and (_wanted(count, rule) >= len(people) or not asked[0][asked[1]].any())


def by_projection(people: People, question: Question, rule: Rule) -> Match:
    """Match by plain projection.

    Parameters
    ----------
    people
        At least one.
    question
        With stage one's answer.
    rule
        Of the gallery.
    """
    (pixels, good), found, count = question.asked, question.found, question.count
    ranked = list(zip(found.distances, found.people, strict=True))
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
            people, best, question.asked, rule.ambient, named(*said) if reason is None else unknown(*said, reason)
        ),
    )


def by_second_look(people: People, question: Question, rule: Rule) -> Match:
    """Match by a second look at a shortlist; the parameters are those of `by_projection`, people with portraits."""
    asked, listed = question.asked, _wanted(question.count, rule)
    pixels, count = asked[0][asked[1]], question.count
    chosen = np.sort(np.array(question.found.people or range(min(listed, len(people))), np.intp))
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
    reason = verdict.unknown(rule.threshold) or _unlit(pixels)
    said = (first.name, None if len(people) == 1 else first.score, rule.threshold, True)
    said_why = named(*said) if reason is None else unknown(*said, reason)
    shift = (float(verdict.shifts[best, 0]), float(verdict.shifts[best, 1]))
    return Match(
        name=first.name if reason is None else None,
        distance=first.distance,
        margin=ratio(candidates[1].distance, first.distance) if len(candidates) > 1 else 1.0,
        light=people.light(index, *seen.asked, shift) if pixels.any() else None,
        candidates=tuple(candidates[:count]),
        domain=PATTERNS,
        reason=reason,
        evidence=_evidence(people, index, asked, True, said_why, seen.whereabouts(best, people, asked)),
    )


def within(people: People, asked: Asked, furthest: float) -> tuple[Candidate, ...]:
    """Return everybody within a distance, nearest first."""
    pixels, good = asked
    found = rank(people, unit_photo(pixels[good], int(good.sum())), good, None, furthest)
    return tuple(
        Candidate(people.name(place), distance, source=people.source(place))
        for distance, place in zip(found.distances, found.people, strict=True)
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
