"""Strangers: how high they are expected to score, predicted from comparisons of few people with each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import stdtr, stdtrit

from harmonicface import _validate
from harmonicface._validate import Floats
from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.decision import threshold_at_fmr
from harmonicface.recognition.identification import expected_fpir


@dataclass(frozen=True)
class Strangers:
    r"""The score of a stranger with one enrolled person, as a distribution; made by `Strangers.of`.

    Comparisons share people: a face that many resemble raises all of its own. So their number tells little; what counts
    are the people. The prediction is Student's, with as many degrees of freedom as there are people on both sides,
    less two, and the deviation s of persons' pairs and of photographs within a pair together:

    .. math:: x \sim \bar x + s \sqrt{1 + 1 / pairs} \; t_{a + b - 2}

    Parameters
    ----------
    mean, deviation
        Of the scores; the deviation has the factor under the root in it.
    freedom
        Degrees of freedom, at least 1.
    best
        Of each search that was seen, the best score.
    """

    mean: float
    deviation: float
    freedom: int
    best: tuple[float, ...]

    @classmethod
    def of(cls, scores: Sequence[ArrayLike], enrolled: int) -> Strangers:
        """Learn from the searches of people who are not in the gallery that they search.

        Parameters
        ----------
        scores
            For each stranger, (n_i, m_i) scores of her n_i photographs with m_i people; at least two strangers.
        enrolled
            How many different people they were compared with, at least 1.

        Raises
        ------
        HarmonicFaceError
            Fewer than two strangers, no photograph or nobody enrolled, NaN, scores that are all the same.

        Examples
        --------
        >>> rng = np.random.default_rng(0)
        >>> found = Strangers.of([rng.normal(0, 1, (1, 50)) for _ in range(200)], enrolled=50)
        >>> round(found.mean, 1), round(found.deviation, 1), found.freedom
        (0.0, 1.0, 248)
        """
        tables = [_table(one) for one in scores]
        if len(tables) < 2:
            raise HarmonicFaceError(f"scores: expected those of at least two strangers, got {len(tables)}")
        _validate.at_least(enrolled, 1, "enrolled")
        pairs = np.concatenate([table.mean(axis=0) for table in tables])
        within = np.concatenate([table.var(axis=0) for table in tables])
        variance = float((pairs.var(ddof=1) + within.mean()) * (1 + 1 / len(pairs)))
        if variance == 0:
            raise HarmonicFaceError(f"scores: expected some that differ, got {len(pairs)} pairs of the same score")
        best = np.concatenate([table.max(axis=1) for table in tables])
        mean = float(pairs.mean())
        return cls(mean, variance**0.5, max(len(tables) + enrolled - 2, 1), tuple(best.tolist()))

    def threshold(self, fpir: float, people: int) -> float:
        """Return the score that a stranger's best in a gallery of n people reaches with a probability of fpir.

        It is never lower than what the searches that were seen need by themselves.

        Parameters
        ----------
        fpir
            Above 0 and below 1, per search.
        people
            In the gallery, at least 1.

        Raises
        ------
        HarmonicFaceError
            A rate that is not between 0 and 1, nobody.

        Examples
        --------
        >>> found = Strangers(0.0, 1.0, 1000, (1.0, 2.0))
        >>> round(found.threshold(0.01, 1), 2), round(found.threshold(0.01, 100), 2)
        (2.33, 3.73)
        """
        rate = _validate.fraction(fpir, "fpir")
        if not 0 < rate < 1:
            raise HarmonicFaceError(f"fpir: expected a rate between 0 and 1, got {fpir}")
        each = -np.expm1(np.log1p(-rate) / _validate.at_least(people, 1, "people"))
        predicted = self.mean + self.deviation * -float(stdtrit(self.freedom, each))
        return max(predicted, threshold_at_fmr(self.best, rate))

    def fmr(self, threshold: float) -> float:
        """Return the probability that a stranger reaches a threshold with one person."""
        return float(stdtr(self.freedom, (self.mean - threshold) / self.deviation))

    def fpir(self, threshold: float, people: int) -> float:
        """Return the probability that a stranger reaches a threshold with anybody of n people: 1 - (1 - FMR)^n."""
        return expected_fpir(self.fmr(threshold), people)


def _table(scores: ArrayLike) -> Floats:
    """Return a stranger's scores."""
    table = _validate.finite(scores, "scores")
    if table.ndim != 2 or table.size == 0:
        expected = "shape (photographs, people), at least one of each"
        raise HarmonicFaceError(f"scores: expected {expected}, got {_validate.describe(table)}")
    return table
