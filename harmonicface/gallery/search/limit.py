"""Limit: how far a person may be from the photograph and still be part of the answer."""

from __future__ import annotations

from collections.abc import Callable

from harmonicface.gallery.search.bound import least_closeness


class Limit:
    """The distance that a person must not exceed to be part of the answer, as it falls.

    Parameters
    ----------
    top
        How many people are asked for; None for all within the distance.
    distance
        The largest distance asked for.
    measure
        From a person to her exact distance.
    pixels, rank
        Of a photograph; the largest of anybody.
    """

    def __init__(
        self, top: int | None, distance: float, measure: Callable[[int], float], pixels: int, rank: int
    ) -> None:
        self._top, self._distance, self._measure = top, distance, measure
        self._size = pixels, rank
        self.measured: dict[int, float] = {}
        self.closeness = least_closeness(distance, pixels, rank)

    def measure(self, person: int) -> None:
        """Measure a person, once, and lower the limit."""
        if person in self.measured:
            return
        self.measured[person] = self._measure(person)
        if self._top is not None and len(self.measured) >= self._top:
            last = sorted(self.measured.values())[self._top - 1]
            self.closeness = max(self.closeness, least_closeness(last, *self._size))

    def answer(self) -> list[tuple[float, int]]:
        """Return distances and people, nearest first; ties in the order of enrolment."""
        found = sorted((distance, who) for who, distance in self.measured.items() if distance <= self._distance)
        return found[: self._top]
