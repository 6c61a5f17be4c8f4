"""Decisions one against many: who comes first, and whether anybody does; closed and open sets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import gammaln

from harmonicface import _validate
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.decision import ErrorCurve, Scores, checked_scores, curve_of
from harmonicface.recognition.intervals import Rate, rate


@dataclass(frozen=True)
class OpenSet:
    """What a threshold does to searches for people who may not be enrolled.

    Parameters
    ----------
    threshold
        The best person of a search is named if her score is at least so high.
    fpir
        False positive identification rate: searches for strangers that name somebody.
    fnir
        False negative identification rate: searches for enrolled people that do not name them; 1 - FNIR is the
        detection and identification rate.
    """

    threshold: float
    fpir: Rate
    fnir: Rate

    @property
    def identified(self) -> float:
        """The detection and identification rate, 1 - FNIR."""
        return 1 - self.fnir.value


def match_ranks(scores: ArrayLike, people: ArrayLike) -> NDArray[np.int64]:
    """Return at which place each search finds the right person, from 1; who is tied with her comes before her.

    Parameters
    ----------
    scores
        (q, n) of each search with each person, higher where more alike.
    people
        (q,) index of the right one, 0 to n - 1.

    Raises
    ------
    HarmonicFaceError
        No searches, other shapes, NaN or infinity, an index that is nobody's.

    Examples
    --------
    >>> match_ranks([[3, 1, 2], [3, 1, 2]], [0, 2]).tolist()
    [1, 2]
    """
    table = checked_table(scores)
    right = _checked_people(people, table)
    own = np.take_along_axis(table, right[:, None], axis=1)
    return np.asarray((table >= own).sum(axis=1), np.int64)


def cumulative_match(scores: ArrayLike, people: ArrayLike) -> Scores:
    """Return the CMC curve: the share of searches that find the right person among the first k, (n,), k from 1.

    Parameters
    ----------
    scores, people
        As for `match_ranks`.

    Raises
    ------
    HarmonicFaceError
        As `match_ranks`.

    Examples
    --------
    >>> cumulative_match([[3, 1, 2], [3, 1, 2]], [0, 2]).tolist()
    [0.5, 1.0, 1.0]
    """
    ranks, count = match_ranks(scores, people), np.shape(scores)[1]
    return np.asarray(np.cumsum(np.bincount(ranks, minlength=count + 1)[1:]) / len(ranks))


def open_set(
    scores: ArrayLike, people: ArrayLike, strangers: ArrayLike, threshold: float, confidence: float = 0.95
) -> OpenSet:
    """Return FPIR and FNIR at a threshold (ISO/IEC 19795-1), with Clopper-Pearson intervals.

    Parameters
    ----------
    scores
        (q, n) of searches for enrolled people.
    people
        (q,) index of the right one.
    strangers
        (u,) best scores of searches for people who are not enrolled.
    threshold
        In the unit of the scores; a score at the threshold is accepted.
    confidence
        Of the intervals, 0 to 1.

    Raises
    ------
    HarmonicFaceError
        No searches of a kind, other shapes, NaN or infinity, an index that is nobody's.

    Examples
    --------
    >>> found = open_set([[5, 1], [2, 6], [3, 4]], [0, 1, 0], strangers=[1, 2], threshold=2)
    >>> found.fpir.value, round(found.identified, 3)
    (0.5, 0.667)
    """
    best = checked_scores(strangers, "strangers'")
    named = _identifying(scores, people) >= threshold
    return OpenSet(
        float(threshold),
        rate(int((best >= threshold).sum()), best.size, confidence),
        rate(int(named.size - named.sum()), named.size, confidence),
    )


def identification_curve(scores: ArrayLike, people: ArrayLike, strangers: ArrayLike) -> ErrorCurve:
    """Return FPIR (as `fmr`) and FNIR (as `fnmr`) at all thresholds.

    The FNIR does not fall below the share of enrolled people's searches in which another person is first.

    Parameters
    ----------
    scores, people, strangers
        As for `open_set`.

    Raises
    ------
    HarmonicFaceError
        As `open_set`.

    Examples
    --------
    >>> identification_curve([[5, 1], [2, 6], [3, 4]], [0, 1, 0], strangers=[1, 2]).fnmr[-1].round(3)
    np.float64(0.333)
    """
    return curve_of(_identifying(scores, people), checked_scores(strangers, "strangers'"))


def expected_fpir(fmr: float, people: int) -> float:
    """Return the FPIR of a search over n people if each were an independent comparison: 1 - (1 - FMR)^n.

    Comparisons of one photograph are not independent, so that a measured rate mostly lies below it.

    Parameters
    ----------
    fmr
        Of one comparison, 0 to 1.
    people
        At least 1.

    Raises
    ------
    HarmonicFaceError
        A rate outside 0 to 1, nobody.

    Examples
    --------
    >>> round(expected_fpir(1e-4, 1000), 4)
    0.0952
    """
    chance = _validate.fraction(fmr, "fmr")
    count = _validate.at_least(people, 1, "people")
    return 1.0 if chance == 1 else float(-np.expm1(count * np.log1p(-chance)))


def fpir_by_size(scores: ArrayLike, threshold: float, sizes: Sequence[int]) -> Scores:
    r"""Return the FPIR that galleries of other sizes would have, averaged over all galleries within this one.

    Where k of n people reach the threshold in a search, a random gallery of m holds one of them with the probability
    :math:`1 - \binom{n - k}{m} / \binom{n}{m}`; the mean over searches is exact, nothing is drawn. Scores must
    not depend on who else is enrolled.

    Parameters
    ----------
    scores
        (u, n) of searches for strangers with each person.
    threshold
        In the unit of the scores; a score at the threshold is accepted.
    sizes
        Of the galleries, each from 1 to n.

    Returns
    -------
    array
        (len(sizes),), 0 to 1.

    Raises
    ------
    HarmonicFaceError
        No searches, another shape, NaN or infinity, a size that is not from 1 to n.

    Examples
    --------
    >>> fpir_by_size([[3, 1, 1, 1], [0, 0, 0, 0]], threshold=2, sizes=[1, 2, 4]).round(3).tolist()
    [0.125, 0.25, 0.5]
    """
    table = checked_table(scores)
    people = table.shape[1]
    for size in sizes:
        if _validate.at_least(size, 1, "size") > people:
            raise HarmonicFaceError(f"sizes: expected at most {people} people, as many as there are, got {size}")
    reaching = (table >= threshold).sum(axis=1)
    return np.array([float((1 - _none_drawn(people, reaching, size)).mean()) for size in sizes])


def _none_drawn(people: int, reaching: NDArray[np.intp], size: int) -> Scores:
    """Return how likely nobody who reaches the threshold is among so many drawn: (n - k over m) / (n over m)."""
    others = people - reaching
    rest = np.maximum(others - size, 0)
    log = gammaln(others + 1) - gammaln(rest + 1) - gammaln(people + 1) + gammaln(people - size + 1)
    return np.where(others >= size, np.exp(log), 0.0)


def checked_table(scores: ArrayLike) -> Scores:
    """Return (q, n) finite scores of at least one search with at least one person.

    Raises
    ------
    HarmonicFaceError
        None, another shape, NaN or infinity.
    """
    table = _validate.finite(scores, "scores")
    if table.ndim != 2 or table.size == 0:
        expected = "shape (searches, people), at least one of each"
        raise HarmonicFaceError(f"scores: expected {expected}, got {_validate.describe(table)}")
    return table.astype(np.float64)


def _identifying(scores: ArrayLike, people: ArrayLike) -> Scores:
    """Return the score of the right person where she is first, minus infinity where she is not."""
    table = checked_table(scores)
    right = _checked_people(people, table)
    own = np.take_along_axis(table, right[:, None], axis=1)[:, 0]
    return np.where((table >= own[:, None]).sum(axis=1) == 1, own, -np.inf)


def _checked_people(people: ArrayLike, table: Scores) -> NDArray[np.int64]:
    """Return one valid index a search."""
    right = np.asarray(people)
    if right.shape != (len(table),) or right.dtype.kind not in "iu":
        expected = f"an index for each of {len(table)} searches"
        raise HarmonicFaceError(f"people: expected {expected}, got {_validate.describe(right)}")
    if right.min() < 0 or right.max() >= table.shape[1]:
        expected = f"indices from 0 to {table.shape[1] - 1}"
        raise HarmonicFaceError(f"people: expected {expected}, got {right.min()} to {right.max()}")
    return right.astype(np.int64)
