"""Who is nearest: a search, or a product over everybody, then exact distances for those who may be the first."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from harmonicface.gallery.enrolled.rows import RowBlock
from harmonicface.gallery.frame import Frame
from harmonicface.gallery.search.cascade import FURTHEST, Found
from harmonicface.gallery.search.searcher import Searcher
from harmonicface.recognition.subspace import Subspace

# Closeness |Q y|^2 is summed in float32; whoever is within this of the last place is examined too.
ROUNDING = 1e-5
# Through a mask it is divided by the eigenvalues of Q Q^T over the good pixels, which magnify the rounding.
MASKED_ROUNDING = 1e-3
SMALLEST_EIGENVALUE = 0.05
DISPLACEMENTS = (-1 / 12, -1 / 24, 0.0, 1 / 24, 1 / 12)  # of the height, across and down

Good = NDArray[np.bool_]


class Everybody(Protocol):
    """Whom a photograph is compared with, by place."""

    def __len__(self) -> int: ...

    def subspace(self, place: int) -> Subspace:
        """Return the subspace of one person."""
        ...

    def blocks(self) -> Iterator[RowBlock]:
        """Yield everybody's rows, the people of each block one after the other."""
        ...

    def searcher(self) -> Searcher | None:
        """Return who finds people without reading everybody; None as long as they are scanned."""
        ...

    @property
    def rounding(self) -> float:
        """How far |Q y|^2 may be from 1 - distance^2 because stored rows are not quite orthonormal."""
        ...


def rank(
    people: Everybody, unit: NDArray[np.float64], good: Good, top: int | None, furthest: float = FURTHEST
) -> Found:
    """Return who is nearest to a photograph, and how many people were excluded on the way.

    Through a mask, and among people without a shared basis, everybody is looked at.

    Parameters
    ----------
    people
        At least one, with orthonormal rows over p pixels.
    unit
        The good pixels of a photograph, of unit length.
    good
        (p,) booleans: which pixels these are.
    top
        How many at most, at least 1; None for all within the distance.
    furthest
        Nobody farther than this.
    """
    searcher = people.searcher() if good.all() else None
    if searcher is not None:
        return searcher.search(unit, top, furthest)
    closeness, doubt = _closeness(people, unit, good)
    last = -np.inf if top is None or top >= len(closeness) else float(np.partition(closeness, -top)[-top])
    candidates = np.flatnonzero(closeness >= max(last, 1 - furthest**2) - doubt)
    exact = sorted((distance(people, int(place), unit, good), int(place)) for place in candidates)
    nearest = [one for one in exact if one[0] <= furthest][:top]
    return Found(tuple(who for _, who in nearest), tuple(far for far, _ in nearest), (), len(candidates))


def shortlist(people: Everybody, unit: NDArray[np.float64], good: Good, count: int) -> Found:
    """Return the `count` people nearest to a photograph, in the order of enrolment.

    They are those of `rank`. Of a scan, exact distances are computed of those only who may be the last on the list or
    the first off it, and none are returned.

    Parameters
    ----------
    people, unit, good
        As for `rank`.
    count
        How many, at least 1.
    """
    searcher = people.searcher() if good.all() else None
    if searcher is not None:
        return searcher.search(unit, count)
    closeness, doubt = _closeness(people, unit, good)
    chosen, measured = _nearest(closeness, count, doubt, lambda place: distance(people, place, unit, good))
    return Found(tuple(chosen.tolist()), (), (), measured)


def displaced_shortlist(
    people: Everybody, frame: Frame, pixels: NDArray[np.float64], good: Good, count: int
) -> NDArray[np.intp]:
    """Return the `count` people nearest to a photograph that may show them displaced by up to a twelfth of its height.

    Parameters
    ----------
    people, count
        As for `shortlist`.
    frame
        The gallery's.
    pixels, good
        (p,) of a photograph that is not dark, and which are good.
    """
    if count >= len(people):
        return np.arange(len(people))
    units = displaced(frame, pixels, good)
    searcher = people.searcher()
    if searcher is not None:
        found = searcher.search_many(units, count)
        nearest_first = sorted(pair for one in found for pair in zip(one.distances, one.people, strict=True))
        return np.sort(np.array(list(dict.fromkeys(who for _, who in nearest_first))[:count], np.intp))
    single = units.astype(np.float32)
    closeness = np.concatenate([block.displaced_closeness(single) for block in people.blocks()])

    def nearest(place: int) -> float:
        subspace = people.subspace(place)
        return min(subspace.distance(unit) for unit in units)

    return _nearest(closeness, count, 2 * (ROUNDING + people.rounding), nearest)[0]


def displaced(frame: Frame, pixels: NDArray[np.float64], good: Good) -> NDArray[np.float64]:
    """Return a photograph displaced by up to a twelfth of its height, (s, p) of unit length, bad pixels 0."""
    steps = [round(part * frame.shape[0]) for part in DISPLACEMENTS]
    units = []
    for right, down in product(steps, steps):
        moved, known = frame.moved(pixels, good, (right, down))
        length = float(np.linalg.norm(moved[known]))
        if length > 0:
            units.append(moved * known / length)
    return np.stack(units)


def distance(people: Everybody, place: int, unit: NDArray[np.float64], good: Good) -> float:
    """Return the distance of one person; who has nothing behind the mask explains nothing."""
    subspace = people.subspace(place)
    if good.all():
        return subspace.distance(unit)
    return subspace.restrict(good).distance(unit) if subspace.rows[:, good].any() else 1.0


def _nearest(
    closeness: NDArray[np.floating], count: int, doubt: float, exact: Callable[[int], float]
) -> tuple[NDArray[np.intp], int]:
    """Return the `count` nearest places, rising, and of how many exact distances had to decide."""
    if count >= len(closeness):
        return np.arange(len(closeness)), 0
    last = np.partition(closeness, -count)[-count]
    sure = np.flatnonzero(closeness > last + doubt)
    rest = np.flatnonzero((closeness >= last - doubt) & (closeness <= last + doubt))
    measured = len(rest) if len(sure) + len(rest) > count else 0
    if measured:
        rest = np.array([place for _, place in sorted((exact(int(one)), int(one)) for one in rest)], np.intp)
    return np.sort(np.concatenate([sure, rest[: count - len(sure)]])), measured


def _closeness(people: Everybody, unit: NDArray[np.float64], good: Good) -> tuple[NDArray[np.floating], float]:
    """Return how much of a photograph everybody explains, and how much that may differ from 1 - distance^2."""
    if good.all():
        found = np.concatenate([block.closeness(unit) for block in people.blocks()])
        return found, ROUNDING + 2 * people.rounding
    places, parts = 0, []
    for block in people.blocks():
        parts.append(_masked_closeness(people, block, places, unit, good))
        places += len(block)
    return np.concatenate(parts), MASKED_ROUNDING + 2 * people.rounding / SMALLEST_EIGENVALUE


def _masked_closeness(
    people: Everybody, block: RowBlock, first: int, unit: NDArray[np.float64], good: Good
) -> NDArray[np.float64]:
    r"""Return how much of a photograph the people of a block explain over the good pixels g: b^T G^{-1} b.

    b = Q_g y and G = Q_g Q_g^T = I - Q_b Q_b^T, from the bad pixels alone. Where they leave G nearly singular, the
    person is examined exactly.
    """
    photo = np.zeros(len(good))
    photo[good] = unit
    bad = block.array[:, ~good].astype(np.float64)
    closeness = np.empty(len(block))
    for index, (part, hidden) in enumerate(zip(block.split(block.products(photo)), block.split(bad), strict=True)):
        values, vectors = np.linalg.eigh(np.eye(len(part)) - hidden @ hidden.T)
        if values[0] > SMALLEST_EIGENVALUE:
            closeness[index] = (np.square(part @ vectors) / values).sum()
        else:
            closeness[index] = 1 - distance(people, first + index, unit, good) ** 2
    return closeness
