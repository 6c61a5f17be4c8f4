"""The limit falls with what is measured, and the answer is in order."""

from __future__ import annotations

from harmonicface.gallery.search.bound import least_closeness
from harmonicface.gallery.search.limit import Limit

DISTANCES = [0.5, 0.2, 0.2, 0.9, 0.1]


def test_the_limit_is_the_last_place() -> None:
    asked: list[int] = []
    limit = Limit(2, 1.0, lambda who: asked.append(who) or DISTANCES[who], 10, 3)  # type: ignore[func-returns-value]
    at_first = limit.closeness
    limit.measure(0)
    assert limit.closeness == at_first == least_closeness(1.0, 10, 3)
    for who, last in ((3, 0.9), (2, 0.5), (1, 0.2), (1, 0.2), (4, 0.2)):
        limit.measure(who)
        assert limit.closeness == least_closeness(last, 10, 3)
    assert asked == [0, 3, 2, 1, 4]
    assert limit.answer() == [(0.1, 4), (0.2, 1)]


def test_all_within_a_distance() -> None:
    limit = Limit(None, 0.2, DISTANCES.__getitem__, 10, 3)
    for who in range(5):
        limit.measure(who)
    assert limit.closeness == least_closeness(0.2, 10, 3)
    assert limit.answer() == [(0.1, 4), (0.2, 1), (0.2, 2)]
