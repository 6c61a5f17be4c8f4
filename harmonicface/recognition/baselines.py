"""Baselines: methods that know photographs only, by name, behind one interface."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Protocol

from numpy.typing import ArrayLike

from harmonicface.errors import HarmonicFaceError
from harmonicface.recognition.correlation import Correlation
from harmonicface.recognition.opencv import Eigenfaces, Fisherfaces, LocalBinaryPatterns


class Baseline(Protocol):
    """A method that learns from photographs of people and names the person in another one."""

    def enroll(self, photographs: Sequence[ArrayLike]) -> None:
        """Learn all people at once from (n_i, h, w) linear intensities, 0 to 1; the person of `photographs[i]` is i."""

    def nearest(self, photo: ArrayLike) -> int:
        """Return the index of the person most like a photo of shape (h, w), 0 to 1."""

    @property
    def bytes_per_person(self) -> int:
        """Bytes that the method keeps, over the number of people; 0 before anybody is enrolled."""


BASELINES: dict[str, Callable[[], Baseline]] = {
    "correlation": Correlation,
    "eigenfaces": Eigenfaces,
    "eigenfaces_minus3": partial(Eigenfaces, drop_first=3),
    "fisherfaces": Fisherfaces,
    "lbph": LocalBinaryPatterns,
}


def baseline(name: str) -> Baseline:
    """Return a new baseline of that name, with nobody enrolled.

    Raises
    ------
    HarmonicFaceError
        There is no baseline of that name.

    Examples
    --------
    >>> baseline("correlation").bytes_per_person
    0
    """
    if name not in BASELINES:
        raise HarmonicFaceError(f"baseline: expected one of {', '.join(BASELINES)}, got {name!r}")
    return BASELINES[name]()
