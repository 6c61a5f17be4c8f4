"""What a protocol on Yale B gives: errors per subset, times, and who was taken for whom."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from harmonicface.bench.degradation import Picture
from harmonicface.bench.yale_protocols import CHOSEN_ON, PUBLISHED_SUBSETS, SUBSETS, published_size
from harmonicface.recognition.intervals import Rate, rate

TOTALS = {"1-4": PUBLISHED_SUBSETS, "1-5": SUBSETS}


@dataclass(frozen=True, eq=False)
class Query:
    """A photograph that is asked for.

    Parameters
    ----------
    person
        Index of who is in it.
    subset
        1 to 5.
    photo
        (h, w) as the methods are shown it.
    file
        Its name, without folder and ending.
    """

    person: int
    subset: int
    photo: Picture
    file: str


@dataclass(frozen=True, eq=False)
class Answers:
    """What one method answered.

    Parameters
    ----------
    queries
        What was asked, in order.
    named
        Index of the person whom the method named, one a query.
    distances
        (n, people) how far everybody was; None for a method that only names the nearest.
    """

    queries: Sequence[Query]
    named: Sequence[int]
    distances: NDArray[np.float64] | None = None

    def missed(self) -> list[tuple[Query, int]]:
        """Return the photographs that were given to somebody else, and to whom."""
        return [pair for pair in zip(self.queries, self.named, strict=True) if pair[0].person != pair[1]]


@dataclass(frozen=True)
class YaleMethod:
    """How one method did.

    Parameters
    ----------
    error_percent
        By subset, those without photographs left out.
    ms_per_query
        Median time of a query in milliseconds.
    wrong, asked
        By subset, wrong answers and photographs asked for, over all divisions.
    splits
        How many divisions there were.
    answers
        One by one.
    """

    error_percent: dict[str, float]
    ms_per_query: float
    wrong: dict[str, int] = field(default_factory=dict)
    asked: dict[str, int] = field(default_factory=dict)
    splits: int = 1
    answers: Answers | None = field(default=None, repr=False, compare=False)

    @classmethod
    def of(cls, answers: Answers, seconds: Sequence[float], splits: int = 1) -> YaleMethod:
        """Count wrong answers."""
        subsets = np.array([query.subset for query in answers.queries])
        missed = np.array([query.subset for query, _ in answers.missed()])
        asked = {str(subset): int((subsets == subset).sum()) for subset in SUBSETS}
        wrong = {str(subset): int((missed == subset).sum()) for subset in SUBSETS}
        percent = {subset: 100 * wrong[subset] / count for subset, count in asked.items() if count}
        return cls(percent, 1e3 * float(np.median(seconds)), wrong, asked, splits, answers)

    def rate(self, subsets: Sequence[int]) -> Rate | None:
        """Return the error over some subsets with its 95 % interval; None if nothing was asked in them.

        The interval is that of one division: the others ask for the same photographs again.
        """
        names = [str(subset) for subset in subsets]
        trials = sum(self.asked.get(name, 0) for name in names)
        return self._rate(sum(self.wrong.get(name, 0) for name in names), trials) if trials else None

    def _rate(self, events: int, trials: int) -> Rate:
        """Return a rate whose interval is that of one division."""
        one = rate(round(events / self.splits), max(round(trials / self.splits), 1))
        return Rate(events, trials, events / trials, one.low, one.high)

    def wrong_by_person(self, people: Sequence[int]) -> dict[int, tuple[int, int]]:
        """Return wrong answers and photographs asked for by the people's numbers; nothing if answers were not kept."""
        if self.answers is None:
            return {}
        asked = np.bincount([query.person for query in self.answers.queries], minlength=len(people))
        wrong = np.bincount([query.person for query, _ in self.answers.missed()], minlength=len(people))
        return {number: (int(wrong[index]), int(asked[index])) for index, number in enumerate(people)}

    def unseen(self, people: Sequence[int]) -> Rate | None:
        """Return the error on people on whom no setting was chosen; None if none of them was asked for."""
        counts = [pair for number, pair in self.wrong_by_person(people).items() if number not in CHOSEN_ON]
        wrong, asked = (sum(pair[which] for pair in counts) for which in (0, 1))
        return self._rate(wrong, asked) if asked else None

    def totals(self) -> dict[str, Rate]:
        """Return the errors over subsets 1 to 4, as published, and over all five, where anything was asked."""
        found = {total: self.rate(subsets) for total, subsets in TOTALS.items()}
        return {total: one for total, one in found.items() if one is not None}


@dataclass(frozen=True)
class YaleResult:
    """The table of a protocol: photographs asked for per subset, and each method's errors on them.

    Parameters
    ----------
    protocol, train, people
        "yale-b", the name of what was learned from, the people's numbers.
    n
        Per subset, photographs that were asked for; over all divisions where there are several.
    methods
        By name.
    noise, jpeg
        How the photographs that were asked for were spoiled.
    splits
        How many divisions into training and queries there were.
    left_out
        Methods that the protocol cannot feed, and why.
    """

    protocol: str
    train: str
    people: list[int]
    n: dict[str, int]
    methods: dict[str, YaleMethod]
    noise: float = 0.0
    jpeg: int | None = None
    splits: int = 1
    left_out: dict[str, str] = field(default_factory=dict)

    @property
    def as_published(self) -> bool:
        """Whether these are the photographs of the published tables, as they are."""
        return published_size(self.people, self.n) and not self.noise and self.jpeg is None


def as_json(result: YaleResult) -> dict[str, object]:
    """Return what `evaluate yale-b --json` prints.

    Examples
    --------
    >>> sorted(as_json(YaleResult("yale-b", "subset1", [1, 2], {"1": 2}, {})))[:4]
    ['jpeg', 'left_out', 'methods', 'n']
    """
    return {
        "protocol": result.protocol,
        "train": result.train,
        "people": result.people,
        "n": result.n,
        "methods": {name: _method(method, result.people) for name, method in result.methods.items()},
        "noise": result.noise,
        "jpeg": result.jpeg,
        "splits": result.splits,
        "left_out": result.left_out,
    }


def _method(method: YaleMethod, people: Sequence[int]) -> dict[str, object]:
    """Return one method's figures."""
    found = method.totals()
    return {
        "error_percent": method.error_percent,
        "ms_per_query": method.ms_per_query,
        "wrong": method.wrong,
        "wrong_by_person": {str(number): wrong for number, (wrong, _) in method.wrong_by_person(people).items()},
        "total_percent": {total: 100 * one.value for total, one in found.items()},
        "total_interval_percent": {total: [100 * one.low, 100 * one.high] for total, one in found.items()},
    }
