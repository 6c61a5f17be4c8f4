"""Merging: few shards, little written twice, whatever is added."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from harmonicface.store.merging import FACTOR, LAST, SMALLEST, size_class, taken_in

PERSON = 150_000


def grown(added: list[int]) -> tuple[list[int], int, list[list[int]]]:
    """Return the shards after many appends, the bytes written, and how often each append's bytes were written."""
    sizes: list[int] = []
    members: list[list[int]] = []
    times = [0] * len(added)
    written = 0
    for number, new in enumerate(added):
        count = taken_in(sizes, new)
        kept = len(sizes) - count
        sizes = [*sizes[:kept], sum(sizes[kept:]) + new]
        members = [*members[:kept], [*(one for group in members[kept:] for one in group), number]]
        written += sizes[-1]
        for one in members[-1]:
            times[one] += 1
    assert [one for group in members for one in group] == list(range(len(added)))  # the order stays
    return sizes, written, [times]


def test_twenty_thousand_single_people() -> None:
    sizes, written, (times,) = grown([PERSON] * 20_000)
    assert sum(sizes) == 20_000 * PERSON
    assert len(sizes) <= 20_000 * PERSON / SMALLEST / FACTOR**LAST + 4 * FACTOR
    assert max(times) <= 1 + LAST - size_class(PERSON)
    assert written <= 5 * sum(sizes)


@given(st.lists(st.one_of(st.integers(SMALLEST, 1 << 30), st.integers(SMALLEST, 1 << 16)), max_size=300))
def test_classes_never_rise_and_each_holds_fewer_than_eight(added: list[int]) -> None:
    sizes, _, (times,) = grown(added)
    classes = [size_class(size) for size in sizes]
    assert classes == sorted(classes, reverse=True)
    assert all(classes.count(level) < FACTOR for level in range(LAST))
    for new, often in zip(added, times, strict=True):
        assert often <= 1 + LAST - size_class(new)


@given(st.lists(st.integers(0, SMALLEST), min_size=1, max_size=200))
def test_tiny_ones_are_few_too(added: list[int]) -> None:
    sizes, written, _ = grown(added)
    assert len(sizes) < 2 * FACTOR
    assert written <= (FACTOR + 2) * SMALLEST * len(added)


def test_large_ones_are_left_alone() -> None:
    assert taken_in([1 << 28] * 500, 1 << 20) == 0
    assert taken_in([1 << 28] * 500 + [1 << 20] * 3, 1 << 28) == 3
