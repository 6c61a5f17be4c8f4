"""Morphs: many distinct people from a few, for benchmarks of galleries larger than the generator makes in a while."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from harmonicface._validate import at_least
from harmonicface.errors import HarmonicFaceError
from harmonicface.surfaces.surface import Surface


def morphs(people: Sequence[Surface], count: int) -> Iterator[Surface]:
    """Yield people halfway between two others: mean albedo, mean normals of unit length, where both are seen.

    Every pair of n people comes once, at most n (n - 1) / 2 of them; neighbours in the order have nobody in common
    but by chance. They are more alike than people are, so that a search has more to tell apart.

    Parameters
    ----------
    people
        Of one shape.
    count
        How many morphs, at least 1.

    Raises
    ------
    HarmonicFaceError
        More morphs than pairs.

    Examples
    --------
    >>> import harmonicface as hf
    >>> len(list(morphs([hf.synthetic_person(number, 16) for number in range(4)], 6)))
    6
    """
    pool, pairs = len(people), len(people) * (len(people) - 1) // 2
    if at_least(count, 1, "count") > pairs:
        raise HarmonicFaceError(f"count: expected at most {pairs} morphs of {pool} people, got {count}")
    for number in range(count):
        step, first = divmod(number, pool)
        yield _between(people[first], people[(first + step + 1) % pool])


def _between(one: Surface, other: Surface) -> Surface:
    """Return the person halfway."""
    mask = one.mask & other.mask
    normals = one.normals + other.normals
    lengths = np.linalg.norm(normals, axis=2, keepdims=True)
    mask &= lengths[..., 0] > 0
    normals = np.where(mask[..., None], normals / np.where(lengths > 0, lengths, 1), 0)
    return Surface(normals, (one.albedo + other.albedo) / 2, mask)
